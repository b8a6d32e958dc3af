"""What Sphinx and the theme leave out for people who hear pages or use the keyboard: levels, names, roles, focus.

Each row mends one rule of axe-core on the built pages, which then finds nothing, on light and dark pages.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the tests use this file without Sphinx
    from sphinx.application import Sphinx

MENDED = (
    (r'role="heading"(?! aria-level)', 'role="heading" aria-level="2"'),  # aria-required-attr: captions of the menu
    (r'<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="Pages">'),  # landmark-unique
    (r'<aside class="toc-drawer', '<aside aria-label="On this page" class="toc-drawer'),
    (r"<pre>", '<pre tabindex="0">'),  # scrollable-region-focusable: a listing scrolls by the keyboard
    (r'<div class="(table|math)-wrapper', r'<div tabindex="0" class="\1-wrapper'),
    (r'role="doc-biblioentry"', 'role="listitem"'),  # aria-deprecated-role
    (r'<th class="head">(<p></p>)?</th>', "<td></td>"),  # empty-table-header: the corner of a table
    (r'(?=<div id="search-results">)', "<h1>Search</h1>"),  # page-has-heading-one
)
PARAMETERS = re.compile(r'("sig-paren">\(</span>)\s*<dl>(.*?)</dl>(?=\s*<span class="sig-paren">)', re.DOTALL)
"""Of a signature on several lines: no list of terms, as it has no term (definition-list)."""


def mended(page: str) -> str:
    """Return a page of HTML with all of it."""
    for pattern, better in MENDED:
        page = re.sub(pattern, better, page)
    return PARAMETERS.sub(_in_lines, page)


def _in_lines(found: re.Match[str]) -> str:
    lines = found[2].replace("<dd>", '<span class="sig-line">').replace("</dd>", "</span>")
    return f'{found[1]}<span class="sig-lines">{lines}</span>'


def mend(app: "Sphinx", exception: Exception | None) -> None:
    """Mend every page of the site."""
    for page in () if exception else Path(app.outdir).rglob("*.html"):
        page.write_text(mended(page.read_text()))


def setup(app: "Sphinx") -> dict[str, bool]:
    """Connect the step after the build."""
    app.connect("build-finished", mend)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
