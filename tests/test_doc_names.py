"""Every dotted name of octmip and femlib that a page of the docs gives is there."""

import importlib
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"])
NAME = re.compile(r"(?<![\w./@-])((?:octmip|femlib)(?:\.[A-Za-z_]\w*)+)(?![\w/-])(?!\.\w)")
FILES = (".py", ".md", ".so", ".pyi", ".json", ".toml", ".sh", ".rs", ".html", ".svg", ".onnx", ".c", ".csv")


def resolves(name: str) -> bool:
    """Return whether a dotted name is a module, or an attribute of one (or of a class in it)."""
    parts = name.split(".")
    for n_modules in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:n_modules]))
        except ModuleNotFoundError as error:
            if not str(error.name).startswith(("octmip", "femlib")):
                return True  # a package of an extra is missing: the module is there
            continue
        for part in parts[n_modules:]:
            fields = getattr(found, "__dataclass_fields__", {})
            if part not in fields and not hasattr(found, part):
                return False
            found = getattr(found, part, None)
        return True
    return False


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_dotted_name_of_a_page_is_there(page: Path) -> None:
    names = {name for name in NAME.findall(page.read_text()) if not name.endswith(FILES)}
    assert not sorted(name for name in names if not resolves(name))
