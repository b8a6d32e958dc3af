"""The page of one tree, for who has to decide with it: whole in itself, nothing asked for from elsewhere."""

from collections.abc import Mapping

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.page import Masthead, page_facts, render
from octmip.interfaces.report.tree.contents import page_contents
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.words import Wording


def tree_page(
    file: TreeFile,
    source: str | None = None,
    evidence: Evidence | None = None,
    *,
    data: str | None = None,
    units: Mapping[str, str] | None = None,
    masthead: Masthead | None = None,
    histograms: bool = False,
) -> str:
    """Return the HTML page of a tree.

    Parameters
    ----------
    file
        the tree, its claims and what it was trained on (`record_tree`).
    source
        name of the tree file, for the footer and the commands; None where there is no file.
    evidence
        what its data say (`octmip.interfaces.report.tree.evidence.gather`); without it the page shows what the file
        holds.
    data
        name of the data file, None where there is none.
    units
        of the columns' values, by column, beside those of the file.
    masthead
        heading, asset and day; by default the heading names the label's column.
    histograms
        whether the splits show the values of the samples that come to them, which needs evidence.
    """
    wording = Wording(file.feature_names, file.class_names, file.columns, {**file.readings.units, **(units or {})})
    made = masthead.made if masthead else None
    facts = page_facts(data, file.sha256, made, **({"Tree file": source} if source else {}))
    page = page_contents(file, source, evidence, wording, data, histograms)
    return render("tree.html", masthead=masthead, styles=["tree.css"], scripts=["tree.js"], facts=facts, **page)
