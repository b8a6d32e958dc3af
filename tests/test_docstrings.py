"""The examples in docstrings run, and every public callable of the packages below has one."""

import doctest
import importlib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
FILES = [file for name in ("octmip", "femlib") for file in sorted((ROOT / name).rglob("*.py"))]
WITH = [file for file in FILES if ">>> " in file.read_text()]
MODULES = [".".join(file.relative_to(ROOT).with_suffix("").parts) for file in WITH]
PUBLIC = (
    *("octmip", "octmip.gap", "octmip.interfaces.plot", "octmip.monitor", "octmip.monitor.export"),
    *("octmip.recordings", "octmip.sensing", "femlib", "femlib.dataset", "femlib.rom", "femlib.structure"),
)
"""An example sees `numpy` as np, the names of octmip and of the packages here that hold its module.

femlib.wing is not among them: a wing takes three seconds.
"""


def names_of(package: str) -> dict[str, object]:
    found = importlib.import_module(package)
    return {name: getattr(found, name) for name in found.__all__}


@pytest.mark.parametrize("module", MODULES)
def test_the_examples_of_a_module_run(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"np": importlib.import_module("numpy")}
    for package in PUBLIC:
        names |= names_of(package) if f"{module}.".startswith(f"{package}.") else {}
    how = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    done = doctest.testmod(importlib.import_module(module), extraglobs=names, optionflags=how)
    assert done.attempted
    assert not done.failed


@pytest.mark.parametrize("package", PUBLIC)
def test_every_public_callable_has_an_example(package):
    callables = {name: one for name, one in names_of(package).items() if callable(one)}
    written = {name: f"{one.__doc__}{vars(one).get('__init__', one).__doc__}" for name, one in callables.items()}
    assert not [name for name, text in written.items() if ">>> " not in text]
