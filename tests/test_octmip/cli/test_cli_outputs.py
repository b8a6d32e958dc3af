"""Files that a command writes: none takes the place of an input or of another output, and a failure loses no result."""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from octmip import Problem, solve
from octmip.input.files import is_same_file
from octmip.interfaces.cli.samples.file_arguments import use_of
from octmip.trees.answer.solution import ProofError
from octmip.trees.methods.options import ExactOptions

Run = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("predict", "tree.json", "data.csv", "--out", "data.csv"), "DATA"),
        (("predict", "tree.json", "data.csv", "--out", "./tree.json"), "TREE.json"),
        (("report", "tree.json", "data.html", "--out", "data.html"), "DATA"),
        (
            ("frontier", "data.csv", "--label", "y", "--depth", "1", "--over", "depth", "--checkpoint", "data.csv"),
            "DATA",
        ),
        (("sensors", "data.svg", "--label", "y", "--depth", "1", "--out", "data.svg"), "DATA"),
        (("diagnose", "data.csv", "--twin", "table:data.html", "--out", "data.html"), "--twin"),
        (
            ("diagnose", "data.csv", "--twin", "a:b", "--commissioning", "run.csv", "--out", "run.csv"),
            "--commissioning",
        ),
        (("solve", "data.csv", "--label", "y", "--depth", "1", "--test", "run.csv", "--out", "run.csv"), "--test"),
        (("solve", "data.csv", "--label", "y", "--depth", "1", "--costs", "c", "--out", "c"), "--costs"),
        (("solve", "data.csv", "--target", "a", "--depth", "1", "--proof", "data.csv"), "DATA"),
    ],
)
def test_no_output_of_any_command_overwrites_its_input(
    data: Path,
    tree: Path,
    refused: Callable[..., str],
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    named: str,
) -> None:
    monkeypatch.chdir(data.parent)
    for name in ("data.html", "data.svg", "run.csv"):
        shutil.copy(data, name)
    before = {path.name: path.read_bytes() for path in data.parent.iterdir()}
    assert f"is the file that {named} names" in refused(*words)
    assert {path.name: path.read_bytes() for path in data.parent.iterdir()} == before


def test_two_outputs_of_one_name_are_refused(data: Path, refused: Callable[..., str], tmp_path: Path) -> None:
    words = ["solve", data, "--label", "y", "--depth", 1, "--out", tmp_path / "new", "--proof", f"{tmp_path}/./new"]
    assert "--out and --proof both name" in refused(*words)
    assert not (tmp_path / "new").exists()


def test_a_device_may_be_named_twice(data: Path, run: Run) -> None:
    words = ["solve", data, "--label", "y", "--depth", 1, "--out", "/dev/null", "--proof", "/dev/null"]
    assert run(*words)[0] == 0


def test_names_are_compared_by_the_files_that_they_mean(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "new")
    (tmp_path / "old").write_text("1")
    (tmp_path / "hard").hardlink_to(tmp_path / "old")
    for one, other in (("new", "link"), ("old", "hard"), ("old", "./old"), ("new", "./link")):
        assert is_same_file(tmp_path / one, Path(os.path.relpath(tmp_path)) / other)
    assert not is_same_file(tmp_path / "new", tmp_path / "other")


def test_every_argument_that_ends_like_a_file_says_what_is_done_with_it() -> None:
    from octmip.interfaces.cli.arguments import Parser
    from octmip.interfaces.cli.program import COMMANDS, options_of

    for name in COMMANDS:
        parser = Parser(name, None)
        options_of(name).add_arguments(parser)
        for action in parser._actions:
            if isinstance(action.metavar, str) and ("." in action.metavar or action.metavar in ("FILE", "DATA", "LOG")):
                is_list = action.metavar.endswith("...")
                assert (use_of(action) is None) == is_list, (name, action.dest)


@pytest.fixture
def full(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """A disk on which nothing can be put into its place while `is_full`; counts the tries."""
    state: dict[str, Any] = {"is_full": True, "tries": 0}
    replace = os.replace

    def refused(*names: Any) -> None:
        state["tries"] += 1
        if state["is_full"]:
            raise OSError(28, "No space left on device")
        replace(*names)

    monkeypatch.setattr(os, "replace", refused)
    return state


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (("solve", "--label", "y", "--depth", "1"), "proven optimal"),
        (("solve", "--label", "y", "--depth", "1", "--json"), '"is_optimal": true'),
        (("solve", "--target", "b", "--features", "a", "--depth", "1"), "roven optimal"),
    ],
)
def test_a_tree_that_cannot_be_written_is_shown(
    data: Path, run: Run, full: dict[str, Any], words: tuple[str, ...], shown: str
) -> None:
    code, out, err = run(words[0], data, *words[1:], "--out", data.parent / "tree.json")
    assert code == 1
    assert shown in out
    assert "written to" not in out
    assert err.count("\n") == 1
    assert "tree.json cannot be written (No space left on device)" in err
    if "--json" in words:
        json.loads(out)


def test_a_proof_log_that_cannot_be_written_loses_no_tree(
    data: Path, run: Run, full: dict[str, Any], tmp_path: Path
) -> None:
    for words in (("--label", "y"), ("--target", "b", "--features", "a")):
        code, out, err = run("solve", data, *words, "--depth", 1, "--proof", data.parent / "log")
        assert code == 1
        assert "roven optimal" in out
        assert "log cannot be written (No space left on device)" in err
    problem = Problem(np.array([[0.0], [1.0]]), np.array([0, 1]), depth=1)
    with pytest.raises(ProofError, match="No space left") as raised:
        solve(problem, options=ExactOptions(proof=tmp_path / "log"))
    assert raised.value.solution.is_optimal


def test_a_checkpoint_that_cannot_be_written_warns_and_the_proof_goes_on(full: dict[str, Any], tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    problem = Problem(rng.normal(size=(60, 4)), rng.integers(0, 3, 60), depth=3)
    kept = tmp_path / "kept"
    with pytest.warns(UserWarning, match=r"kept cannot be written \(No space left.*the next time it is tried again"):
        found = solve(problem, "exact", options=ExactOptions(checkpoint=kept, every=0.0))
    assert found.is_optimal
    assert full["tries"] > 1
    full["is_full"] = False
    again = solve(problem, "exact", options=ExactOptions(checkpoint=kept, every=0.0))
    assert again.objective == found.objective
    assert kept.exists()


def test_a_reader_that_leaves_loses_no_tree(data: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(*_: object) -> None:
        raise BrokenPipeError

    monkeypatch.setattr("octmip.interfaces.cli.solve._show_words", gone)
    monkeypatch.setattr("sys.stderr.close", lambda: None, raising=False)
    tree = data.parent / "tree.json"
    assert run("solve", data, "--label", "y", "--depth", 1, "--out", tree)[0] == 0
    assert json.loads(tree.read_text())["format"]
