"""What was found is kept: a solve that was killed goes on to the same answer, and nothing foreign is believed."""

import base64
import json
import struct
import zlib
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from octmip import Limits, Options, Problem, SearchOptions, SquaredError, Stop, solve
from octmip.errors import DataError
from octmip.trees.encoding import integer_costs
from octmip.trees.evidence.proof import check_proof
from octmip.trees.methods.checkpoint.entry import Entry
from octmip.trees.methods.checkpoint.file import first_line, summed
from octmip.trees.methods.checkpoint.search_state import grid_digest
from octmip.trees.methods.options import ExactOptions
from octmip.trees.question.losses import ClassCosts
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import random_problem
from tests.oracles.wide_problems import wide_problem

LINES = {"depth": 2, "split": "hyperplane", "split_size": 2}
COSTS = ClassCosts(np.array([[0, 0.1, 0.2], [0.1, 0, 0.1], [0.3, 0.2, 0]]))


def hard(seed=0, **options):
    rng = np.random.default_rng([61, seed])
    return Problem(rng.integers(0, 90, (200, 5)), rng.integers(0, 3, 200), **{"depth": 3} | options)


def small(**options):
    rng = np.random.default_rng(81)
    return Problem(rng.integers(0, 9, (60, 3)), rng.integers(0, 3, 60), **{"depth": 2} | options)


def lines(n=40, p=3, **options):
    rng = np.random.default_rng([63, n, p])
    return Problem(rng.normal(size=(n, p)), rng.integers(0, 3, n), **LINES | options)


def numbers(**options):
    rng = np.random.default_rng(64)
    return Problem(rng.normal(size=(60, 3)), rng.normal(size=60), depth=2, loss=SquaredError(), **options)


@pytest.mark.parametrize(
    ("problem", "n_jobs"),
    [
        (hard(), 2),
        (hard(leaf_penalty=1.0), 1),
        (hard(leaf_size=4), 1),
        (hard(sensor_budget=3), 2),
        (small(leaf_penalty=4.0, depth=None), 1),
        (hard(loss=ClassCosts([[7, 27, 47], [20, 0, 20], [60, 40, 0]])), 1),
        (lines(), 2),
        (lines(leaf_penalty=0.75), 1),
        (lines(sensor_budget=2), 1),
        (lines(loss=COSTS), 2),
    ],
)
def test_a_proof_in_pieces_ends_where_one_proof_does(problem, n_jobs, tmp_path):
    whole = solve(problem, "exact")
    pieces, options = [], ExactOptions(checkpoint=tmp_path / "kept", every=0.0)
    while not pieces or pieces[-1].stop in (Stop.NODES, Stop.TIME):
        # Somebody looks every 20 ms. Where a cut of the root takes more, it is lost when the search ends.
        limits = Limits(nodes=max(1.0, whole.n_nodes // 5 * (1 + len(pieces) // 10))) if pieces else Limits(seconds=0)
        pieces.append(solve(problem, "exact", limits, n_jobs=n_jobs, options=options))
        assert len(pieces) < 200
    last = pieces[-1]
    assert len(pieces) > 1
    assert (last.tree, last.objective, last.bound, last.stop) == (whole.tree, whole.objective, whole.bound, whole.stop)
    bounds = [piece.bound for piece in pieces]
    assert bounds == sorted(bounds)
    assert "resumed_from" not in pieces[0].details
    spent = last.details["resumed_from"]
    assert spent["nodes"] == sum(piece.n_nodes for piece in pieces[:-1])
    if problem.shape.split == "hyperplane":
        assert spent["nodes"] + last.n_nodes == whole.n_nodes


def test_small_problems_of_every_kind_have_the_optimum_of_enumeration_after_a_pause(tmp_path):
    for seed in range(20):
        rng = np.random.default_rng([62, seed])
        problem = (wide_problem if seed % 2 else random_problem)(rng)
        options = ExactOptions(checkpoint=tmp_path / str(seed), every=0.0)
        first = solve(problem, "exact", Limits(nodes=float(rng.integers(0, 9))), options=options)
        second = solve(problem, "exact", options=options)
        assert first.bound <= second.bound, f"seed {seed}"
        assert second.stop is solve(problem, "exact").stop, f"seed {seed}"
        best = optimum(problem)
        assert Fraction(second.bound) <= Fraction(best.objective) * (1 + Fraction(1, 2**51)), f"seed {seed}"
        assert second.objective <= best.objective * (1 + 1e-12) + second.tolerance, f"seed {seed}"


EVERY_KIND = [
    (hard(), "exact"),
    (hard(max_splits=3), "exact"),
    (hard(leaf_weight=5.0), "exact"),
    (hard(depth=2, loss=ClassCosts(np.random.default_rng(0).integers(0, 5, (200, 3)), per_sample=True)), "exact"),
    (lines(), "exact"),
    (lines(20, depth=1), "exact"),
    (lines(), "search"),
    (hard(), "cart"),
    (hard(depth=1), "benders"),
    (hard(depth=1), "flow"),
    (numbers(), "exact"),
    (numbers(leaf_model="linear"), "search"),
]


@pytest.mark.long("problem11-search")
@pytest.mark.parametrize(("problem", "method"), EVERY_KIND)
def test_what_has_ended_is_not_made_again(problem, method, tmp_path, monkeypatch):
    options = Options(checkpoint=tmp_path / "kept")
    first = solve(problem, method, options=options)
    plain = solve(problem, method)
    monkeypatch.setattr("octmip.trees.solver._result", None)
    again = solve(problem, method, n_jobs=2, options=options)
    for other in (plain, again):
        assert (other.tree, other.objective, other.bound) == (first.tree, first.objective, first.bound)
        assert (other.stop, other.n_nodes) == (first.stop, first.n_nodes)
    assert again.details == {**first.details, "kept": True}


@pytest.mark.parametrize(("problem", "method"), [EVERY_KIND[k] for k in (1, 2, 3, 5, 8, 9, 10)])
def test_a_proof_without_a_state_goes_on_from_its_tree_and_bound(problem, method, tmp_path):
    options = Options(checkpoint=tmp_path / "kept")
    found = solve(problem, method, options=options)
    bound = 0.9 * found.objective
    rewritten(options.checkpoint, lambda content: content["solution"].update(bound=bound, stop="time"))
    less = solve(problem, method, Limits(seconds=0), options=options)
    assert (less.objective, less.details["resumed_from"]["nodes"]) == (found.objective, found.n_nodes)
    assert less.bound >= bound
    last = solve(problem, method, options=options)
    assert (last.objective, last.bound, last.stop) == (found.objective, found.bound, found.stop)


def test_a_tree_that_is_better_than_what_has_ended_is_taken_up(tmp_path):
    options = SearchOptions(checkpoint=tmp_path / "kept", restarts=1, perturbations=0)
    best = solve(hard(depth=6), "search")
    assert solve(hard(depth=6), "search", options=options).objective > best.objective
    for start in (best.tree, None):
        assert solve(hard(depth=6), "search", incumbent=start, options=options).objective == best.objective


def test_a_smaller_gap_and_a_log_are_still_worked_for(tmp_path):
    options = ExactOptions(checkpoint=tmp_path / "kept")
    objective = solve(hard(), "exact", options=options).objective
    rewritten(options.checkpoint, lambda content: content["solution"].update(bound=0.2 * objective, stop="gap"))
    assert solve(hard(), "exact", Limits(gap=0.95), options=options).details["kept"]
    found = solve(hard(), "exact", options=options)
    assert found.is_optimal
    logged = solve(hard(), "exact", options=replace(options, proof=tmp_path / "log"))
    assert check_proof(hard(), tmp_path / "log", bound=logged.bound).bound == found.bound


def found_in(path):
    """Return what was found in the one entry of a checkpoint."""
    return json.loads(path.read_bytes().split(b"\n")[1].split(b" ", 2)[2])


def cut_off(problem, path):
    """Make the checkpoint of a proof that was killed, with its state, and return the options that go on from it."""
    options, nodes = ExactOptions(checkpoint=path), 200.0
    while not path.exists() or not any(found_in(path)["state"].get(name) for name in ("known", "packed")):
        solve(problem, "exact", Limits(nodes=nodes), options=options)
        nodes *= 2
    rewritten(path, lambda content: content.update(solution=None))
    return options


def test_a_proof_that_is_killed_again_has_spent_the_nodes_of_its_state_once(tmp_path, monkeypatch):
    options = replace(cut_off(lines(), tmp_path / "kept"), every=0.0)
    monkeypatch.setattr(Entry, "keep", lambda self, solution: solution)
    before = found_in(options.checkpoint)["nodes"]
    solve(lines(), "exact", Limits(nodes=2.0 * before), options=options)
    found = found_in(options.checkpoint)
    assert before < found["nodes"] == found["state"]["numbers"][2]


def rewritten(path, edit):
    """Change what a checkpoint's first entry has found and make its sum right again."""
    first, line, *others = path.read_bytes().split(b"\n")
    _, asked, content = line.split(b" ", 2)
    found = json.loads(content)
    edit(found)
    path.write_bytes(b"\n".join([first, summed(asked + b" " + json.dumps(found).encode()), *others]))


def test_every_damage_is_found(tmp_path):
    path = tmp_path / "kept"
    options = cut_off(hard(), path)
    content = path.read_bytes()
    damaged = [content[: len(content) // 2], content[:-1], content + b"x"]
    for place in range(0, len(content), max(1, len(content) // 60)):
        damaged.append(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    for one in damaged:
        path.write_bytes(one)
        with pytest.raises(
            DataError, match=r"checkpoint .* is (damaged: line \d|none of this version).*; give another file, or"
        ):
            solve(hard(), "exact", options=options)


@pytest.mark.parametrize(
    ("change", "run", "complaint"),
    [
        ({"weights": np.full(200, 2.0)}, {}, "other samples, labels and weights"),
        ({"depth": 4}, {}, "other depth, costs, limits and sensors"),
        ({"sensor_budget": 2.0}, {}, "other depth, costs, limits and sensors"),
        ({"loss": COSTS}, {}, "other depth, costs, limits and sensors"),
        ({"sensor_cost": [1, 1, 1, 1, 2]}, {}, "other depth, costs, limits and sensors"),
        ({"max_splits": 5}, {}, "other depth, costs, limits and sensors"),
        ({}, {"seed": 1}, "the seed '0'; expected '1'"),
        ({}, {"method": "cart"}, "the method 'exact'; expected 'cart'"),
    ],
)
def test_the_checkpoint_of_another_question_is_refused_by_name(change, run, complaint, tmp_path):
    options = Options(checkpoint=cut_off(hard(), tmp_path / "kept").checkpoint)
    with pytest.raises(DataError, match=f"belongs to another search: it has {complaint}"):
        solve(hard().replace(**change), **{"method": "exact"} | run, options=options)


def test_options_and_kinds_of_lines_are_other_questions(tmp_path):
    path = tmp_path / "kept"
    solve(lines(), "search", options=SearchOptions(checkpoint=path, restarts=2))
    for problem, options in (
        (lines(), SearchOptions(checkpoint=path, restarts=3)),
        (lines(integer_normals=3), SearchOptions(checkpoint=path, restarts=2)),
    ):
        with pytest.raises(DataError, match="belongs to another search"):
            solve(problem, "search", options=options)


LEAVES = {"left": {"label": 0}, "right": {"label": 0}}


def split(feature, **entries):
    return {"feature": feature, "threshold": 0.5} | LEAVES | entries


def changed(**entries):
    return lambda content: content["state"].update(entries)


def known(place, value):
    return lambda content: content["state"]["known"].__setitem__(place, value)


def cut(*row):
    return lambda content: content["state"]["known"][4].append(row)


def numbered(edit):
    """Return a change of the numbers in a two-feature proof's nodes."""

    def change(content):
        state = zlib.decompress(base64.b85decode(content["state"]["packed"]))
        values = list(struct.unpack(f"<{len(state) // 8}q", state))
        edit(values)
        packed = zlib.compress(struct.pack(f"<{len(values)}q", *values))
        content["state"]["packed"] = base64.b85encode(packed).decode()

    return change


@pytest.mark.parametrize(
    ("problem", "edit", "complaint"),
    [
        (hard(), changed(grid="0"), "holds costs on another grid"),
        (hard(), changed(bound=1e9), "claims the bound .* above that of its tree"),
        (hard(), changed(tree=split(77)), "holds something else"),
        (
            hard(sensor_budget=1),
            changed(tree=split(0, threshold=40.5, left=split(1, threshold=40.5))),
            "holds a tree that is none of this problem",
        ),
        (hard(), lambda content: content.update(nodes="many"), "holds something else"),
        (hard(), lambda content: content["state"].pop("known"), "holds something else"),
        (hard(), known(3, 1), "holds what cannot be proven: failed to extract field"),
        (hard(), known(0, 9), "holds what cannot be proven: level 9"),
        (hard(), known(1, 900), "holds what cannot be proven: bounds 900"),
        (hard(), cut(0, 1, 5, 0), "holds what cannot be proven: "),
        (hard(), cut(99, 1, 0, 0), "holds what cannot be proven: feature 99 of 5"),
        (hard(), known(6, [[[True], [False]]]), "holds what cannot be proven: a set"),
        (hard(), cut(0, 10**6, 0, 0), "holds what cannot be proven: feature 0 has no cut"),
        (lines(), numbered(lambda values: values.append(0)), "holds "),
        (lines(), numbered(lambda values: values.__setitem__(5, 2**62)), "holds "),
        (lines(), changed(packed="no bytes"), "holds something else"),
        (lines(), changed(**{"grid tree": split(0, left=split(1, left=split(2)))}), "holds a tree"),
        (lines(), lambda content: content["state"].pop("packed"), "holds something else"),
    ],
)
def test_what_no_search_wrote_is_refused(problem, edit, complaint, tmp_path):
    options = cut_off(problem, tmp_path / "kept")
    rewritten(options.checkpoint, edit)
    with pytest.raises(DataError, match=f"checkpoint .*kept {complaint}.*; give another file, or remove this one"):
        solve(problem, "exact", options=options)


@pytest.mark.parametrize(
    "entries",
    [
        {"objective": "many"},
        {"bound": float("nan")},
        {"seconds": None},
        {"details": 7},
        {"tree": {"label": 99}},
        {"tree": {"label": 0}},  # costs more than it says
        {"tree": []},
        {"stop": "bored"},
    ],
)
def test_what_no_solve_wrote_is_refused(entries, tmp_path):
    options = Options(checkpoint=tmp_path / "kept")
    solve(hard(), "exact", options=options)
    rewritten(options.checkpoint, lambda content: content["solution"].update(entries))
    with pytest.raises(DataError, match="kept holds something else than a solve of this problem writes"):
        solve(hard(), "exact", options=options)


def test_a_file_of_another_version_and_a_place_without_a_folder_are_refused(tmp_path):
    path = tmp_path / "kept"
    path.write_bytes(first_line() + b".1\n")
    with pytest.raises(DataError, match="is none of this version of octmip: line 1 is 'octmip-checkpoint"):
        solve(hard(), options=Options(checkpoint=path))
    with pytest.raises(DataError, match="there is no folder"):
        solve(hard(), options=Options(checkpoint=tmp_path / "none" / "kept"))


def test_what_needs_more_memory_than_there_is_is_refused(tmp_path):
    options = cut_off(lines(), tmp_path / "kept")
    with pytest.raises(DataError, match="tables of 64 slope intervals, and memory for"):
        solve(lines(), "exact", Limits(memory=10_000), options=options)


@pytest.mark.parametrize("changed", [{"exponent": 9}, {"penalty": 9}])
def test_costs_on_another_grid_have_another_digest(changed):
    costs = integer_costs(small(leaf_penalty=0.5))
    assert grid_digest(replace(costs, **changed)) != grid_digest(costs) == grid_digest(replace(costs))
