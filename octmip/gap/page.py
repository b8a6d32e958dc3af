"""The report: one self-contained HTML page, no script, no outside file."""

from octmip.gap.diagnosis import Diagnosis
from octmip.gap.words import page_of_words


def report_page(diagnosis: Diagnosis) -> str:
    """Return the page."""
    return page_of_words(diagnosis)
