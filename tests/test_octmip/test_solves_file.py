"""A study of many solves makes each once: stopped and started again it ends with the results of one that never was."""

import hashlib
import json
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from octmip import Limits, Problem, solve
from octmip.errors import DataError
from octmip.interfaces.cli import main
from octmip.trees import solves_file
from octmip.trees.methods.options import Options, SearchOptions
from octmip.trees.solution import Stop
from octmip.trees.tradeoff.choice import choose_tree
from octmip.trees.tradeoff.frontier import trace_frontier


def problem(**options):
    rng = np.random.default_rng(81)
    return Problem(rng.integers(0, 9, (60, 3)).astype(float), rng.integers(0, 3, 60), **{"depth": 3} | options)


def without_seconds(solution):
    details = {name: value for name, value in solution.details.items() if name != "kept"}
    return solution.tree, solution.objective, solution.bound, solution.stop, solution.n_nodes, details


@pytest.mark.parametrize("over", ["depth", "budget", "penalty"])
@pytest.mark.parametrize("split", ["axis", "hyperplane"])
def test_a_frontier_makes_no_solve_twice(over, split, tmp_path, monkeypatch):
    asked, path = problem(split=split, depth=2), tmp_path / "solves"
    plain = trace_frontier(asked, over)
    first = trace_frontier(asked, over, options=Options(solves=path))
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[: len(lines) // 2 + 1]) + lines[-1][:-7])  # killed while a line was written
    again = trace_frontier(asked, over, options=Options(solves=path), n_jobs=2)
    for points in (first, again):
        assert [without_seconds(point.solution) for point in points] == [without_seconds(p.solution) for p in plain]
    assert len(path.read_bytes().splitlines()) == len(lines)
    monkeypatch.setattr("octmip.trees.solver._result", None)  # no solve is made any more
    last = trace_frontier(asked, over, options=Options(solves=path))
    assert [point.solution.tree for point in last] == [point.solution.tree for point in plain]
    assert all(point.solution.details["kept"] for point in last)


def test_cross_validation_makes_no_solve_twice(tmp_path, monkeypatch):
    asked, options = problem(depth=2), Options(solves=tmp_path / "solves")
    plain, first = choose_tree(asked, folds=3), choose_tree(asked, folds=3, options=options)
    monkeypatch.setattr("octmip.trees.solver._result", None)
    again = choose_tree(asked, folds=3, options=options)
    assert plain.tree == first.tree == again.tree
    assert plain.chosen == first.chosen == again.chosen


def test_another_question_is_another_solve(tmp_path):
    options = Options(solves=tmp_path / "solves")
    for changes, run in (({}, {}), ({"depth": 2}, {}), ({}, {"seed": 1}), ({}, {"limits": Limits(nodes=10)})):
        assert "kept" not in solve(problem(**changes), options=options, **run).details
    assert solve(problem(), options=options).details["kept"]
    assert solve(problem(), "search", options=SearchOptions(solves=options.solves, restarts=2)).stop is Stop.FINISHED
    assert "kept" not in solve(problem(), "search", options=SearchOptions(solves=options.solves, restarts=3)).details
    assert solve(problem(), "search", options=SearchOptions(solves=options.solves, restarts=3)).details["kept"]


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (lambda lines: [b"octmip-solves 1 0.0", *lines[1:]], "line 1 is 'octmip-solves 1 0.0'; expected"),
        (lambda lines: [lines[0], lines[1][:30] + b"7" + lines[1][31:]], "line 2 is damaged"),
        (lambda lines: [lines[0], summed(b"[1]")], "line 2 is no solve"),
        (lambda lines: [lines[0], changed(lines[1], floats=[1, 2])], "is no solution of its problem"),
        (lambda lines: [lines[0], changed(lines[1], tree={"label": 99})], "is no solution of its problem"),
        (lambda lines: [lines[0], changed(lines[1], stop="bored")], "is no solution of its problem"),
    ],
)
def test_what_no_solve_wrote_is_refused(edit, complaint, tmp_path):
    path = tmp_path / "solves"
    solve(problem(), options=Options(solves=path))
    path.write_bytes(b"\n".join([*edit(path.read_bytes().splitlines()), b""]))
    with pytest.raises(DataError, match=complaint):
        solve(problem(), options=Options(solves=path))


def summed(rest):
    return hashlib.sha256(rest).hexdigest()[: solves_file.N_DIGITS].encode() + b" " + rest


def changed(line, **entries):
    content = json.loads(line.partition(b" ")[2])
    content["solution"] |= entries
    return summed(json.dumps(content).encode())


def test_a_disk_that_is_full_leaves_whole_lines(tmp_path, monkeypatch):
    path, write = tmp_path / "solves", solves_file.os.write
    solve(problem(), options=Options(solves=path))
    before = path.read_bytes()
    monkeypatch.setattr(solves_file.os, "write", lambda file, line: write(file, line[:20]))
    with pytest.warns(UserWarning, match="cannot be written"):
        assert solve(problem(depth=2), options=Options(solves=path)).is_optimal
    assert path.read_bytes() == before


def test_the_command_goes_on_after_a_kill(tmp_path, capsys):
    rng, table, kept = np.random.default_rng(5), tmp_path / "table.csv", tmp_path / "solves"
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
