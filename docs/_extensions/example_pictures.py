"""The pictures of the examples: kept as files beside the pages, or drawn anew by the examples while the site is built.

An example that draws saves its figure by the file name under which its page shows it, `pictures/examples/NAME`. The
files that are kept let a page be read without a build. `python -m sphinx ... -D draw_examples=1` runs every example
and puts what it draws into the built site instead; `python docs/_extensions/example_pictures.py` writes the kept files
again. `tests/test_examples.py` holds that every picture a page shows is saved by its own code.
"""

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the tests use this file without Sphinx
    from sphinx.application import Sphinx

DOCS = Path(__file__).parent.parent
KEPT = DOCS / "pictures" / "examples"
SHOWN = re.compile(r"!\[[^\]]*\]\((?:\.\./)?pictures/examples/([^)\s]+)\)")
SAME_FILE = {"svg.hashsalt": "octmip", "savefig.bbox": "tight", "svg.fonttype": "path"}


def shown_pictures(text: str) -> list[str]:
    """Return the names of the pictures that a page shows and its own code draws."""
    return SHOWN.findall(text)


def run_page(text: str) -> None:
    """Run the cells of a page, in order, in the current folder; what they print is dropped."""
    from notebooks import code_of

    from octmip.interfaces.cli import main

    namespace: dict[str, object] = {}
    for source, _, _ in code_of(text):
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            if source.startswith("!"):
                main(shlex.split(source)[1:])
            else:
                exec(source, namespace)


@contextlib.contextmanager
def drawn_pictures(page: Path) -> Iterator[list[Path]]:
    """Run a page in a folder of its own and yield the pictures that it shows."""
    import matplotlib

    text, before = page.read_text(), Path.cwd()
    os.environ["SOURCE_DATE_EPOCH"] = "0"  # an SVG file holds its date: the same picture is the same file
    with tempfile.TemporaryDirectory() as folder, matplotlib.rc_context(SAME_FILE), warnings.catch_warnings():
        os.chdir(folder)
        try:
            run_page(text)
            yield [Path(folder) / name for name in shown_pictures(text)]
        finally:
            os.chdir(before)


def pages_with_pictures() -> list[Path]:
    """Return the pages whose code draws a picture."""
    pages = [DOCS / "index.md", *sorted((DOCS / "examples").glob("*.md")), *sorted((DOCS / "howto").glob("*.md"))]
    return [page for page in pages if page.stem != "gallery" and shown_pictures(page.read_text())]


def draw(folder: Path, pages: list[Path]) -> None:
    """Put the pictures of all pages into a folder."""
    from benchmarks.small_svg import shrink

    folder.mkdir(parents=True, exist_ok=True)
    for page in pages:
        with drawn_pictures(page) as pictures:
            for picture in pictures:
                shrink(picture)
                (folder / picture.name).write_bytes(picture.read_bytes())


def redraw(app: "Sphinx", exception: Exception | None) -> None:
    """Replace the kept pictures in the built site by what the examples draw now."""
    if exception is None and app.config.draw_examples:
        draw(Path(app.outdir) / "_images", pages_with_pictures())


def setup(app: "Sphinx") -> dict[str, bool]:
    """Register the setting `draw_examples` and the step after the build."""
    app.add_config_value("draw_examples", False, "html", types=(bool, str, int))
    app.connect("build-finished", redraw)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    sys.path.insert(0, str(DOCS.parent))
    chosen = [page for page in pages_with_pictures() if not sys.argv[1:] or page.stem in sys.argv[1:]]
    draw(KEPT, chosen)
