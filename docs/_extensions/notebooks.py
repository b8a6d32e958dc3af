"""Pages as notebooks: while the site is built, each page that has code gets NAME.ipynb beside it, and a link to it.

A ```python block is a cell, and the ```text block after it its output. In a ```console block each line with `$` is a
cell that calls the command. The tests run these cells, so a notebook holds what its page shows.

`python docs/_extensions/notebooks.py FOLDER` writes the Python of every page as a module of `FOLDER/pages`, whose types
`make lint` checks.
"""

import json
import re
import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # the tests use this file without Sphinx
    from sphinx.application import Sphinx

BLOCK = re.compile(r"^```(python|text shape|text|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LEFT_OUT = re.compile(r"^(`{3,}|:{3,})\{.*?^\1$|!\[[^\]]*\]\([^)]*\)", re.MULTILINE | re.DOTALL)
"""What only the site can show: directives, and pictures, which the cells draw."""
RUN = ("index", "tutorial", "examples/", "howto/")
"""Pages whose code the tests run, and folders of such."""
KERNEL = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}


def cells_of(text: str) -> list[dict[str, Any]]:
    """Return the cells of a page in order: its prose, and its code with what it prints."""
    cells: list[dict[str, Any]] = []
    end = 0
    for block in BLOCK.finditer(text):
        cells += _prose(text[end : block.start()])
        end = block.end()
        kind, content = block.groups()
        if kind == "python":
            cells.append(_code(content))
        elif kind == "console":
            commands = re.split(r"^\$ ", content, flags=re.MULTILINE)[1:]
            cells += [_code(f"!{line}", output) for line, _, output in (one.partition("\n") for one in commands)]
        else:
            ran = next(cell for cell in reversed(cells) if cell["cell_type"] == "code")
            ran |= _code(ran["source"], content, is_shape=kind == "text shape")
    return cells + _prose(text[end:])


def _code(source: str, output: str = "", is_shape: bool = False) -> dict[str, Any]:
    """Return a cell; of the output of one with a shape only lines and indents are said."""
    outputs = [{"output_type": "stream", "name": "stdout", "text": output}] if output else []
    metadata = {"tags": ["shape"]} if is_shape else {}
    cell = {"cell_type": "code", "source": source.strip("\n"), "outputs": outputs, "metadata": metadata}
    return cell | {"execution_count": None}


def _prose(text: str) -> list[dict[str, Any]]:
    """Return a cell of prose, if there is any; links to other pages are left as their words."""
    plain = re.sub(r"\[([^\]]*)\]\((?![a-z]+:)[^)]*\)", r"\1", LEFT_OUT.sub("", text)).strip()
    return [{"cell_type": "markdown", "source": plain, "metadata": {}}] if plain else []


def code_of(text: str) -> list[tuple[str, str, bool]]:
    """Return source, output and whether only the output's shape is said, of every cell of code of a page."""
    cells = [cell for cell in cells_of(text) if cell["cell_type"] == "code"]
    return [(c["source"], "".join(out["text"] for out in c["outputs"]), bool(c["metadata"])) for c in cells]


def link(app: "Sphinx", name: str, source: list[str]) -> None:
    """End a page that has code with a link to its notebook."""
    if name.startswith(RUN) and code_of(source[0]):
        file = f"{Path(name).name}.ipynb"
        source[0] += f'\n\n<p><a href="{file}" download>This page as a notebook: {file}</a></p>\n'


def write(app: "Sphinx", exception: Exception | None) -> None:
    """Write the notebooks beside the pages."""
    for name in () if exception else sorted(app.env.found_docs):
        text = Path(app.env.doc2path(name)).read_text() if name.startswith(RUN) else ""
        if code_of(text):
            notebook = {"cells": cells_of(text), "metadata": KERNEL, "nbformat": 4, "nbformat_minor": 4}
            (Path(app.outdir) / f"{name}.ipynb").write_text(json.dumps(notebook, indent=1))


def setup(app: "Sphinx") -> dict[str, bool]:
    """Connect both."""
    app.connect("source-read", link)
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_modules(folder: Path) -> None:
    """Write them anew."""
    root = Path(__file__).parents[2]
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for page in (root / "README.md", *(root / "docs").rglob("*.md")):
        blocks = [content for kind, content in BLOCK.findall(page.read_text()) if kind == "python"]
        name = re.sub(r"\W", "_", str(page.relative_to(root).with_suffix("")))
        (folder / f"{name}.py").write_text("\n".join(blocks))


if __name__ == "__main__":
    write_modules(Path(sys.argv[1], "pages"))
