"""What is shipped: the source distribution holds all that a build needs, the wheel no source of the native core."""

import subprocess
import sys
import tarfile
import zipfile

import pytest

from tests.installed import ROOT, built, shared_folder

pytestmark = pytest.mark.long


def tracked(*patterns: str) -> set[str]:
    """Return the files that git tracks; the test is skipped outside a checkout."""
    done = subprocess.run(["git", "ls-files", *patterns], capture_output=True, text=True, cwd=ROOT)
    if done.returncode or not done.stdout:
        pytest.skip("this is no git checkout")
    return set(done.stdout.split("\n")) - {""}


def test_the_source_distribution_holds_every_source_and_nothing_built(tmp_path_factory):
    wanted = tracked("octmip", "femlib", "pyproject.toml", "README.md", "LICENSE")
    (source,) = built(shared_folder(tmp_path_factory)).glob("*.tar.gz")
    with tarfile.open(source) as archive:
        held = {name.partition("/")[2] for name in archive.getnames()}
    assert any(name.endswith(".rs") for name in wanted)
    assert wanted <= held, wanted - held
    strangers = held - tracked()
    assert strangers == {"PKG-INFO"}, strangers


@pytest.mark.parametrize(
    "check", [("twine", "check", "--strict"), ("check_wheel_contents", "--toplevel", "octmip,femlib")]
)
def test_what_a_registry_would_check_passes(tmp_path_factory, check):
    (wheel,) = built(shared_folder(tmp_path_factory)).glob("*.whl")
    done = subprocess.run([sys.executable, "-m", *check, str(wheel)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_wheel_names_its_rust_parts(tmp_path_factory):
    (wheel,) = built(shared_folder(tmp_path_factory)).glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        (name,) = [name for name in archive.namelist() if "/sboms/" in name]
        assert b"pyo3" in archive.read(name)
