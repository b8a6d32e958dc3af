"""A proof that is killed goes on from its checkpoint: the same optimum, little lost, nothing foreign believed."""

import hashlib
import json
import random
import signal
import subprocess
import sys
import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from benchmarks.oracles.enumeration import optimum
from benchmarks.oracles.strategies import random_problem
from benchmarks.oracles.wide_problems import wide_problem
from octmip import Limits, Problem, certify
from octmip.errors import DataError
from octmip.trees.methods.checkpoint import file
from octmip.trees.methods.checkpoint.file import FIRST
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.solution import Stop


def hard(seed=0, **options):
    rng = np.random.default_rng([61, seed])
    return Problem(rng.integers(0, 90, (200, 5)), rng.integers(0, 3, 200), depth=3, **options)


def resumed(problem, path, n_jobs=1):
    """Return the solutions of searches that end when somebody first looks, one after the other, to the end."""
    found = []
    while not found or found[-1].stop is not Stop.OPTIMAL:
        # Somebody looks every 20 ms. Where a cut of the root takes more, it is lost when the search ends.
        limits = Limits(nodes=float(4000 * (len(found) // 10))) if found else Limits(seconds=0)
        found.append(branch_and_bound(problem, limits=limits, n_jobs=n_jobs, options=ExactOptions(checkpoint=path)))
        certify(problem, found[-1])
        assert len(found) < 200
    return found


@pytest.fixture
def often(monkeypatch):
    """Write a checkpoint whenever somebody looks."""
    monkeypatch.setattr(file, "CHECKPOINT_SECONDS", 0.0)


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize(
    ("options", "n_jobs"), [({}, 2), ({"leaf_penalty": 1.0}, 1), ({"leaf_size": 4}, 1), ({"sensor_budget": 3}, 2)]
)
def test_a_search_in_pieces_ends_where_one_search_does(options, n_jobs, tmp_path):
    problem = hard(**options)
    whole = branch_and_bound(problem)
    pieces = resumed(problem, tmp_path / "kept", n_jobs)
    assert (pieces[-1].objective, pieces[-1].bound) == (whole.objective, whole.bound)
    bounds = [piece.bound for piece in pieces]
    assert bounds == sorted(bounds)
    assert "resumed_from" not in pieces[0].details
    spent = pieces[-1].details["resumed_from"]
    assert 0 < spent["seconds"] <= sum(piece.seconds for piece in pieces[:-1])
    assert spent["nodes"] == sum(piece.n_nodes for piece in pieces[:-1])


@pytest.mark.usefixtures("often")
def test_small_problems_of_every_kind_have_the_optimum_of_enumeration_after_a_pause(tmp_path):
    for seed in range(40):
        rng = np.random.default_rng([62, seed])
        problem = (wide_problem if seed % 2 else random_problem)(rng)
        path = tmp_path / str(seed)
        first = branch_and_bound(
            problem, limits=Limits(nodes=float(rng.integers(0, 9))), options=ExactOptions(checkpoint=path)
        )
        second = branch_and_bound(problem, options=ExactOptions(checkpoint=path))
        once = branch_and_bound(problem)
        certify(problem, second)
        assert first.bound <= second.bound, f"seed {seed}"
        assert second.stop is once.stop, f"seed {seed}"
        best = optimum(problem)
        assert Fraction(second.bound) <= Fraction(best.objective) * (1 + Fraction(1, 2**51)), f"seed {seed}"
        assert second.objective <= best.objective * (1 + 1e-12) + second.tolerance, f"seed {seed}"


@pytest.mark.usefixtures("often")
def test_a_finished_search_is_not_made_again(tmp_path):
    problem = hard()
    first, second = (branch_and_bound(problem, options=ExactOptions(checkpoint=tmp_path / "kept")) for _ in range(2))
    assert (second.objective, second.bound, second.stop) == (first.objective, first.bound, Stop.OPTIMAL)
    assert second.n_nodes == 0 < first.n_nodes


CHILD = """
import sys
import numpy as np
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
rng = np.random.default_rng(3)
problem = Problem(rng.normal(size=(200, 6)), rng.integers(0, 3, 200), depth=3)
print("ready", flush=True)
solution = branch_and_bound(problem, options=ExactOptions(checkpoint=sys.argv[1], every=0.02))
print(solution.objective, solution.bound, solution.stop, bool(solution.details.get("resumed_from")))
"""


def killed_and_gone_on(child, kept):
    """Return what a program prints that was killed three times, each some moments after its checkpoint was there."""
    command, moments = [sys.executable, "-c", child, str(kept)], random.Random(0)
    for _ in range(3):
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
            running.stdout.readline()
            while not kept.exists():
                time.sleep(0.01)
            time.sleep(moments.uniform(0.03, 0.15))
            running.send_signal(signal.SIGKILL)
    assert kept.exists()
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()[1:]


def test_a_search_killed_at_any_moment_goes_on_to_the_same_optimum(tmp_path):
    """SIGKILL gives no time to clean up: the file is the last whole one."""
    rng = np.random.default_rng(3)
    whole = branch_and_bound(Problem(rng.normal(size=(200, 6)), rng.integers(0, 3, 200), depth=3))
    last = killed_and_gone_on(CHILD, tmp_path / "kept")
    assert last == [str(whole.objective), str(whole.bound), "optimal", "True"]


@pytest.fixture
def kept(tmp_path):
    """Return a problem and the checkpoint of a search of it that was cut off."""
    path, nodes = tmp_path / "kept", 1.0
    while not path.exists() or b'"known":null' in path.read_bytes():
        branch_and_bound(hard(), limits=Limits(nodes=nodes), options=ExactOptions(checkpoint=path))
        nodes *= 2
    return hard(), path


def test_every_damage_is_found(kept):
    problem, path = kept
    content = path.read_bytes()
    for place in range(0, len(content) - 1, max(1, len(content) // 60)):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        with pytest.raises(
            DataError, match=r"checkpoint .* is (damaged|no checkpoint): line 1 .*; give another file, or"
        ):
            branch_and_bound(problem, options=ExactOptions(checkpoint=path))
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(DataError, match="is damaged"):
        branch_and_bound(problem, options=ExactOptions(checkpoint=path))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"weights": np.full(200, 2.0)}, "samples, labels and weights"),
        ({"depth": 4}, "depth, costs, limits and sensors"),
        ({"sensor_budget": 2.0}, "depth, costs, limits and sensors"),
    ],
)
def test_a_checkpoint_of_another_problem_is_refused(kept, change, complaint):
    problem, path = kept
    with pytest.raises(DataError, match=f"belongs to another search: it has the {complaint}"):
        branch_and_bound(replace(problem, **change), options=ExactOptions(checkpoint=path))


LEAVES = [{"label": 0}, {"label": 0}]


def cut(feature: int, rank: int, left: int, right: int) -> dict[str, int]:
    return {"feature": feature, "cut": rank, "left": left, "right": right}


def rewritten(path, edit):
    """Change the content of a checkpoint and make its sum right again."""
    content = json.loads(path.read_bytes().split(b"\n")[1])
    edit(content)
    line = json.dumps(content).encode()
    path.write_bytes(f"{FIRST} {hashlib.sha256(line).hexdigest()}\n".encode() + line + b"\n")


@pytest.mark.parametrize(
    ("edit", "complaint"),
    [
        (lambda c: c.update(version="0.0"), "belongs to another search: it has the version of octmip"),
        (lambda c: c.update(grid="0"), "holds costs on another grid"),
        (lambda c: c.update(bound=(1e9).hex()), "claims the bound .* above its tree's"),
        (lambda c: c.update(tree=[cut(77, 0, 1, 2), *LEAVES]), "holds"),
        (lambda c: c.update(tree=[{"label": 99}]), "holds a tree that is none of this problem"),
        (lambda c: c.update(tree=[cut(0, 0, 1, 1), *LEAVES[:1]]), "rows are no tree"),
        (lambda c: c.update(tree=[cut(0, 999, 1, 2), *LEAVES]), "holds"),
        (lambda c: c.update(tree=[{"label": 0, "left": 1}]), "holds something else"),
        (lambda c: c.update(known="nothing"), "holds something else"),
        (lambda c: c.update(nodes=2**80), "holds something else"),
        (lambda c: c.update(seconds="nan"), "holds something else"),
        (lambda c: c.pop("known"), "holds something else"),
        (lambda c: c["known"].__setitem__(0, 9), "holds what cannot be proven: known: level 9"),
        (lambda c: c["known"].__setitem__(1, 900), "holds what cannot be proven: known: bounds 900"),
        (lambda c: c["known"][4].append([0, 1, 5, 0]), "holds what cannot be proven: known: "),
        (lambda c: c["known"][4].append([99, 1, 0, 0]), "holds what cannot be proven: known: feature 99 of 5"),
        (lambda c: c["known"][4].append([0, 10**6, 0, 0]), "holds what cannot be proven: known: feature 0 has no cut"),
        (lambda c: c["known"].__setitem__(7, [[[True], [False]]]), "holds what cannot be proven: known: a set"),
    ],
)
def test_what_cannot_be_is_refused(kept, edit, complaint):
    problem, path = kept
    rewritten(path, edit)
    with pytest.raises(DataError, match=complaint):
        branch_and_bound(problem, options=ExactOptions(checkpoint=path))


def test_a_place_that_cannot_be_written_is_refused_before_the_search(tmp_path):
    with pytest.raises(DataError, match="there is no folder"):
        branch_and_bound(hard(), options=ExactOptions(checkpoint=tmp_path / "none" / "kept"))
