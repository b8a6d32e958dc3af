"""A study of many solves makes each once: stopped and started again it ends with the results of one that never was."""

import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from octmip import Limits, Options, Study, solve
from octmip.errors import DataError
from octmip.interfaces.cli import main
from octmip.trees.tradeoff.choice import choose_tree
from octmip.trees.tradeoff.frontier import trace_frontier
from tests.test_octmip.test_checkpoint import numbers, small


def answers(points):
    def answer(solution):
        details = {name: value for name, value in solution.details.items() if name != "kept"}
        return solution.tree, solution.objective, solution.bound, solution.stop, solution.n_nodes, details

    return [answer(point.solution) for point in points]


@pytest.mark.long("penalty-asked5")
@pytest.mark.parametrize(
    ("over", "asked"),
    [(over, small()) for over in ("depth", "budget", "penalty")]
    + [(over, small(split="hyperplane")) for over in ("depth", "budget", "penalty")]
    + [("depth", numbers()), ("penalty", numbers())],
)
def test_a_frontier_makes_no_solve_twice(over, asked, tmp_path, monkeypatch):
    path = tmp_path / "kept"
    plain, first = trace_frontier(asked, over), trace_frontier(asked, over, options=Options(checkpoint=path))
    entries = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(entries[: len(entries) // 2 + 1]))
    again = trace_frontier(asked, over, options=Options(checkpoint=path), n_jobs=2)
    assert answers(first) == answers(again) == answers(plain)
    assert len(path.read_bytes().splitlines()) == len(entries)
    monkeypatch.setattr("octmip.trees.solver._result", None)  # no solve is made any more
    last = trace_frontier(asked, over, options=Options(checkpoint=path))
    assert answers(last) == answers(plain)
    assert all(point.solution.details["kept"] for point in last)


def test_cross_validation_makes_no_solve_twice(tmp_path, monkeypatch):
    asked, options = small(), Options(checkpoint=tmp_path / "kept")
    plain, first = choose_tree(asked, folds=3), choose_tree(asked, folds=3, n_jobs=2, options=options)  # two processes
    monkeypatch.setattr("octmip.trees.solver._result", None)
    again = choose_tree(asked, folds=3, options=options)
    assert plain.tree == first.tree == again.tree
    assert plain.chosen == first.chosen == again.chosen


def test_a_study_has_an_entry_for_each_question_and_leaves_what_a_limit_ended(tmp_path):
    options = Options(checkpoint=Study(tmp_path / "kept"))
    runs = [({}, {}), ({"depth": 3}, {}), ({}, {"seed": 1}), ({}, {"limits": Limits(nodes=10)})]
    for again in (False, True):
        for changes, run in runs:
            assert ("kept" in solve(small(**changes), "exact", **run, options=options).details) is again
    with pytest.raises(DataError, match="it has other limits and start of one solve of a study"):
        solve(small(), "exact", options=Options(checkpoint=tmp_path / "kept"))


def test_a_study_in_the_file_of_one_solve_and_that_solve_leave_each_other_alone(tmp_path):
    path = tmp_path / "kept"
    for options in (Options(checkpoint=path), Options(checkpoint=Study(path))) * 2:
        last = solve(small(), "exact", options=options)
        solve(small(), "exact", Limits(gap=0.5), options=options)
    assert last.details["kept"]
    assert len(path.read_bytes().splitlines()) == 4


def test_the_command_goes_on_after_a_kill(tmp_path, capsys):
    rng, table, kept = np.random.default_rng(5), tmp_path / "table.csv", tmp_path / "kept"
    rows = np.column_stack([rng.normal(size=(90, 5)).round(2), rng.integers(0, 3, 90)])
    table.write_text("a,b,c,d,e,y\n" + "\n".join(",".join(map(str, row)) for row in rows))
    words = ["frontier", str(table), "--label", "y", "--depth", "3", "--over", "budget", "--json"]
    command = [sys.executable, "-c", "import sys; from octmip.interfaces.cli import main; main(sys.argv[1:])", *words]
    with subprocess.Popen([*command, "--checkpoint", str(kept)], stdout=subprocess.DEVNULL) as running:
        while running.poll() is None and (not kept.exists() or kept.read_bytes().count(b"\n") < 3):
            time.sleep(0.01)
        running.send_signal(signal.SIGKILL)
    found = []
    for more in ([], ["--checkpoint", str(kept)]):
        assert main([*words, *more]) == 0
        found.append(json.loads(capsys.readouterr().out)["rows"])
    keys = ("budget", "objective", "bound", "stop", "tree")
    assert [[row.get(key) for key in keys] for row in found[1]] == [[row.get(key) for key in keys] for row in found[0]]
