"""The wheel and the source distribution as a stranger gets them: built once, installed into empty environments.

The Rust build is that of `make`: cargo's target folder (CARGO_TARGET_DIR) is used again, so that a wheel takes seconds.
Packages of others that this environment holds, in the version that pip chose, are linked instead of unpacked again.
"""

import fcntl
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MATURIN = Path(sys.executable).with_name("maturin")
OFFLINE = ("Retrying (", "Temporary failure in name resolution", "NewConnectionError")
"""What pip says where it reaches no package index."""


@dataclass(frozen=True, slots=True)
class Installed:
    """An environment outside the checkout that holds octmip, installed from a built distribution.

    Attributes
    ----------
    python
        its interpreter; `bin` has the `octmip` command.
    wheel
        the wheel that was installed.
    downloads
        every wheel that pip fetched for it, octmip's own included.
    """

    python: Path
    wheel: Path
    downloads: Path

    @property
    def bin(self) -> Path:
        """Return the folder of its programs."""
        return self.python.parent

    @property
    def packages(self) -> Path:
        """Return its site-packages."""
        (found,) = self.python.parents[1].glob("lib/python*/site-packages")
        return found

    def run(self, *words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
        """Run a program of the environment in a folder outside the checkout and return what it said."""
        program = [str(self.bin / words[0]), *words[1:]]
        return subprocess.run(program, capture_output=True, text=True, cwd=cwd, env=stranger(self.bin))


def stranger(programs: Path | None = None) -> dict[str, str]:
    """Return the variables of a shell that knows nothing of this checkout; `programs` come first in PATH."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    return kept if programs is None else kept | {"PATH": f"{programs}{os.pathsep}{kept['PATH']}"}


def shared_folder(factory: pytest.TempPathFactory) -> Path:
    """Return the folder that all workers of one test run share."""
    own = factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "installed"
    folder.mkdir(exist_ok=True)
    return folder


def built(folder: Path) -> Path:
    """Return the folder with the wheel and the source distribution, built by the first who asks."""
    if not MATURIN.exists() or shutil.which("cargo") is None:
        pytest.skip("maturin or cargo is missing: no wheel can be built")
    dist = folder / "dist"
    with _first(folder, "dist") as is_first:
        if is_first:
            _built(MATURIN, "build", "--release", "--interpreter", sys.executable, "--out", dist)
            _built(MATURIN, "sdist", "--out", dist)
    return dist


def installed(folder: Path, extras: str = "") -> Installed:
    """Return an environment that holds the built wheel with some extras ("plot", "plot,wing"), and nothing else.

    What the wheel needs without extras is installed once: an environment with extras sees it, and adds its own.
    """
    (wheel,) = built(folder).glob("*.whl")
    place = folder / f"environment-{extras.replace(',', '-') or 'core'}"
    found = Installed(place / "bin" / "python", wheel, place / "downloads")
    core = installed(folder) if extras else None
    with _first(folder, place.name) as is_first:
        if is_first:
            empty_environment(place)
            if core is None:
                pip("download", "--dest", found.downloads, wheel)
                link_packages(found, (file.name.split("-")[:2] for file in found.downloads.glob("*.whl")))
                pip("--python", found.python, "install", "--no-index", "--find-links", found.downloads, "octmip")
            else:
                pip("--python", found.python, "install", "--no-deps", wheel)
                see_packages(found, core)
                left = link_packages(found, chosen(found, f"octmip[{extras}]", place / "report.json"))
                if left:
                    pip("--python", found.python, "install", "--no-deps", *left)
    return found


def chosen(environment: Installed, wanted: str, report: Path) -> list[tuple[str, str]]:
    """Return name and version of every package that pip would add to an environment."""
    pip("--python", environment.python, "install", "--dry-run", "--report", report, wanted)
    added = (one["metadata"] for one in json.loads(report.read_text())["install"])
    return [(one["name"], one["version"]) for one in added]


def link_packages(environment: Installed, packages: Iterable[Sequence[str]]) -> list[str]:
    """Link the packages that this environment holds in the same version; return the others as pip wants them."""
    left = []
    for name, version in packages:
        parts = parts_of(name, version)
        for part in parts:
            place = environment.packages / part.name
            if not place.is_symlink():  # two packages may share a folder
                place.symlink_to(part)
        if not parts:
            left.append(f"{name}=={version}")
    return left


def parts_of(name: str, version: str) -> list[Path]:
    """Return the folders and files of a package in this environment; none where it has another version or none."""
    try:
        own = distribution(name)
    except PackageNotFoundError:
        return []
    if own.version != version or name == "octmip" or not own.files:
        return []
    here = Path(str(own.locate_file("")))
    return [here / part for part in {file.parts[0] for file in own.files} - {"..", "__pycache__"}]


def see_packages(environment: Installed, other: Installed) -> None:
    """Let an environment import the packages of another one, after its own."""
    (environment.packages / "other.pth").write_text(f"{other.packages}\n")


def empty_environment(place: Path) -> None:
    """Make an environment that holds not even pip."""
    done = subprocess.run([sys.executable, "-m", "venv", "--without-pip", place], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def pip(*words: str | Path) -> None:
    """Run this environment's pip; the test is skipped where no package index is reached."""
    quiet = {"PIP_QUIET": "1", "PIP_NO_COMPILE": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "pip", *words],
        capture_output=True,
        text=True,
        cwd=ROOT.parent,
        env=stranger() | quiet,
    )
    if done.returncode and any(sign in done.stderr for sign in OFFLINE):
        pytest.skip("pip reaches no package index: nothing that is shipped was installed, NOTHING OF IT IS TESTED")
    assert done.returncode == 0, done.stderr


def _built(*words: str | Path) -> None:
    done = subprocess.run(list(words), capture_output=True, text=True, cwd=ROOT, env=os.environ)
    assert done.returncode == 0, done.stderr


@contextmanager
def _first(folder: Path, name: str) -> Iterator[bool]:
    """Whether nobody has made this part yet; others wait until the first is done, and a failed one is tried again."""
    mark = folder / f"{name}.made"
    with (folder / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        is_first = not mark.exists()
        yield is_first
        mark.touch()
