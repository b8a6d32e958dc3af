"""`octmip-check` reads mangled logs and problem files: refused in one line, or accepted for what is true."""

import shutil

import pytest

from benchmarks.cases.fuzz.check_command import built, corrupted

pytestmark = pytest.mark.skipif(shutil.which("cargo") is None, reason="cargo, which builds octmip-check, is missing")

FEATURES, LABELS = [[0.0], [1.0], [2.0], [3.0]], ["a", "b", "a", "b"]


@pytest.fixture(scope="module")
def command():
    return built()


@pytest.mark.parametrize("first", [0])
def test_no_mangled_pair_of_files_is_accepted_for_more_than_is_true(first, command):
    outcomes = {seed: corrupted(seed, command)[1] for seed in range(first, first + 30)}
    assert not {seed: outcome for seed, outcome in outcomes.items() if outcome not in ("refused", "true")}
