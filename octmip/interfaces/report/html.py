"""The page of one tree, for who has to decide with it: whole in itself, nothing asked for from elsewhere."""

import datetime
from collections.abc import Mapping

from octmip.formats.tree_file import TreeFile
from octmip.interfaces.report.page import page_facts, render
from octmip.interfaces.report.tree.contents import page_contents
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.words import Wording


def tree_page(
    file: TreeFile,
    source: str | None = None,
    evidence: Evidence | None = None,
    *,
    title: str | None = None,
    data: str | None = None,
    units: Mapping[str, str] | None = None,
    made: datetime.date | None = None,
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
    title
        the heading; by default what is told, by the name of the label's column.
    data
        name of the data file, None where there is none.
    units
        of the columns' values, by column.
    made
        day on the page; today by default.
    """
    wording = Wording(file.feature_names, file.class_names, file.columns, units or {})
    facts = page_facts(data, file.sha256, made, **({"Tree file": source} if source else {}))
    page = page_contents(file, source, evidence, wording, data) | ({"title": title} if title else {})
    return render("tree.html", styles=["tree.css"], scripts=["tree.js"], facts=facts, **page)
