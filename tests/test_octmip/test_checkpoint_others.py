"""Two-feature proofs in pieces: the tree, bound and nodes of the run that never stopped."""

import base64
import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest

from octmip import Limits, Problem, certify
from octmip.errors import DataError, ProblemError
from octmip.trees.losses import ClassCosts
from octmip.trees.methods.exact import branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.solution import Stop
from tests.test_octmip.test_checkpoint import killed_and_gone_on, rewritten


def lines(n=40, p=3, **options):
    rng = np.random.default_rng([63, n, p])
    shape = {"depth": 2, "split": "hyperplane", "split_size": 2} | options
    return Problem(rng.normal(size=(n, p)), rng.integers(0, 3, n), **shape)


def in_pieces(run, problem, options, seconds, **more):
    """Return the last solution of searches that a clock ends, each going on from the one before, and their number."""
    for number in range(1, 200):
        found = run(problem, options=options, limits=Limits(seconds=seconds * number), **more)
        if found.stop is not Stop.TIME:
            return found, number
    raise AssertionError("no end")


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"leaf_penalty": 0.75},
        {"sensor_budget": 2},
        {"loss": ClassCosts(np.array([[0, 0.1, 0.2], [0.1, 0, 0.1], [0.3, 0.2, 0]]))},
    ],
)
def test_a_two_feature_proof_in_pieces_makes_the_nodes_of_one_proof(options, tmp_path):
    problem = lines(**options)
    whole = two_feature_branch_and_bound(problem)
    kept = ExactOptions(checkpoint=tmp_path / "kept", every=0.0)
    last, n_pieces = in_pieces(two_feature_branch_and_bound, problem, kept, whole.seconds / 6, n_jobs=2)
    assert n_pieces > 1
    assert (last.tree, last.objective, last.bound) == (whole.tree, whole.objective, whole.bound)
    assert (last.stop, last.details["resumed_from"]["nodes"] + last.n_nodes) == (whole.stop, whole.n_nodes)
    certify(problem, last)


CHILD = """
import sys
import numpy as np
from octmip.trees.methods.two_feature import two_feature_branch_and_bound
from octmip.trees.methods.options import ExactOptions
from octmip.trees.problem import Problem
rng = np.random.default_rng([63, 70, 3])
problem = Problem(rng.normal(size=(70, 3)), rng.integers(0, 3, 70), depth=2, split="hyperplane", split_size=2)
print("ready", flush=True)
solution = two_feature_branch_and_bound(problem, options=ExactOptions(checkpoint=sys.argv[1], every=0.02))
print(solution.objective, solution.bound, solution.n_nodes + solution.details["resumed_from"]["nodes"])
"""


def test_a_two_feature_proof_killed_at_any_moment_goes_on_to_the_same_nodes(tmp_path):
    whole = two_feature_branch_and_bound(lines(70))
    last = killed_and_gone_on(CHILD, tmp_path / "kept")
    assert last == [str(whole.objective), str(whole.bound), str(whole.n_nodes)]


@pytest.fixture
def kept(tmp_path):
    """Return a problem and the checkpoint of a two-feature proof of it that was cut off."""
    path = tmp_path / "kept"
    two_feature_branch_and_bound(lines(), limits=Limits(nodes=200), options=ExactOptions(checkpoint=path))
    return lines(), path


def test_a_checkpoint_of_another_run_is_refused(kept, tmp_path):
    problem, path = kept
    for change, complaint in (({"leaf_penalty": 1.0}, "depth, costs"), ({"weights": np.full(40, 2.0)}, "samples")):
        with pytest.raises(DataError, match=f"belongs to another search: it has the {complaint}"):
            two_feature_branch_and_bound(replace(problem, **change), options=ExactOptions(checkpoint=path))
    with pytest.raises(DataError, match="belongs to another search: it has the options of the search"):
        two_feature_branch_and_bound(problem, seed=1, options=ExactOptions(checkpoint=path))
    with pytest.raises(DataError, match="belongs to another search: it has the method 'two-feature exact'"):
        branch_and_bound(replace(problem, split="axis", split_size=None), options=ExactOptions(checkpoint=path))
    with pytest.raises(DataError, match="holds tables of 64 slope intervals, and memory for"):
        two_feature_branch_and_bound(problem, limits=Limits(memory=10_000), options=ExactOptions(checkpoint=path))
    with pytest.raises(ProblemError, match="of which nothing can be kept"):
        two_feature_branch_and_bound(replace(problem, depth=1), options=ExactOptions(checkpoint=tmp_path / "one"))


def with_numbers(edit):
    """Return a change of the numbers in a two-feature checkpoint's nodes."""

    def change(content):
        state = zlib.decompress(base64.b85decode(content["nodes"][0]))
        numbers = list(struct.unpack(f"<{len(state) // 8}q", state))
        edit(numbers)
        content["nodes"][0] = base64.b85encode(zlib.compress(struct.pack(f"<{len(numbers)}q", *numbers))).decode()

    return change


@pytest.mark.parametrize(
    "edit",
    [
        with_numbers(lambda numbers: numbers.pop()),
        with_numbers(lambda numbers: numbers.append(0)),
        with_numbers(lambda numbers: numbers.__setitem__(0, -1)),
        with_numbers(lambda numbers: numbers.__setitem__(5, 2**62)),
        with_numbers(lambda numbers: numbers.__setitem__(6, 2**40)),
        lambda content: content["nodes"].__setitem__(0, "no bytes"),
        lambda content: content["nodes"].__setitem__(1, -3),
        lambda content: content["nodes"].__setitem__(2, [0, [[0, 0, 0, 0, 0, 1, [], 0.0]]]),
        lambda content: content.update({"grid tree": [[0, 0, 0, 0, 0, 77, [], 0.0]]}),
        lambda content: content.update(grid="0"),
        lambda content: content.pop("nodes"),
    ],
)
def test_nodes_that_cannot_be_are_refused(kept, edit):
    problem, path = kept
    rewritten(path, edit)
    with pytest.raises(DataError, match=f"checkpoint {path} (holds|claims) .*; give another file, or remove this one"):
        two_feature_branch_and_bound(problem, options=ExactOptions(checkpoint=path))
