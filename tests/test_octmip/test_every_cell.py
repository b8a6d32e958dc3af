"""Every cell of the registry by the same checks: whatever is registered keeps what a Solution promises."""

import math
import pickle
from dataclasses import fields

import numpy as np
import pytest

from octmip import ExactOptions, Leaf, Limits, Problem, Split, Stop, ValueLeaf, certify, near_optimal, solve
from octmip.errors import ProblemError
from octmip.formats.tree_file import read_tree_file, record_tree, tree_for, write_tree_file
from octmip.interfaces.report.html import tree_page
from octmip.trees.methods.options import OPTIONS
from octmip.trees.nodes.tree import depth
from octmip.trees.question.losses import SPELLINGS, ClassCosts, number_loss
from octmip.trees.question.problem_file import encode, question_digest
from octmip.trees.question.shape import Shape
from octmip.trees.runs.registry import CAPABILITIES, DEEP_LINES, REGISTRY, SHAPED, SPARSE

CELLS = [(*cell, method) for cell, solvers in REGISTRY.items() for method in solvers]
LOSSES = {"classes": ClassCosts(), **{number_loss(spelling).name: number_loss(spelling) for spelling in SPELLINGS}}
N = 12
RNG = np.random.default_rng(17)
FEATURES = RNG.integers(0, 5, (N, 3)).astype(float)
TARGETS = RNG.integers(0, 3, N)
TARGETS[:3] = 0, 1, 2
WEIGHTS = RNG.integers(1, 3, N).astype(float)


def problem(loss: str, split: str, rows=slice(None), **more) -> Problem:
    """Return a problem of a loss and a split: small whole numbers, of which every sum is exact."""
    given = {"depth": 2, "split": split, "weights": WEIGHTS[rows], "features": FEATURES[rows]}
    if split == "hyperplane":
        given |= {"split_size": 2, "depth": 1}
    given |= more
    if loss == "classes":
        given["class_names"] = (0, 1, 2)
    return Problem(targets=TARGETS[rows], loss=LOSSES[loss], **given)


SETTINGS = {
    "any_depth": {"depth": None, "leaf_penalty": 1.0},
    "max_splits": {"max_splits": 1},
    "monotone": {"monotone": [1, 0, 0]},
    "fixed_splits": {"fixed_splits": {"ROOT": "x2<=1.5"}},
    "path_rules": {"path_rules": [("root-only", "x0")]},
    "max_changes": {"old_tree": Leaf(0), "max_changes": 1},
    "leaf_weight": {"leaf_weight": 3.0},
}
"""Of settings that some methods do not know, one that asks for each."""


@pytest.fixture(params=CELLS, ids=" ".join)
def cell(request):
    return request.param


KNOWN_TO_ALL = "depth split split_size leaf_size leaf_penalty sensor_of_feature sensor_cost allowed_splits ridge"
"""Fields of a shape that every solver knows."""


def test_every_field_of_a_shape_has_a_row_unless_all_know_it_and_rows_name_solvers_that_there_are():
    names = {one.name for one in fields(Shape)} - {"sensors", "sensor_index", "sensor_costs", "old_tree"}
    assert names - set(CAPABILITIES) == set(KNOWN_TO_ALL.split())
    solvers = {solver.name for solvers in REGISTRY.values() for solver in solvers.values()}
    lacking = {who for row in CAPABILITIES.values() for who in row.lacking}
    assert lacking <= {*solvers, SHAPED.name, SPARSE.name, DEEP_LINES.name, "levels", "numbers"}


def is_one_optimum(method: str, solution) -> bool:
    """Whether the objective is that of the best tree, and so the same however samples are laid out."""
    return solution.is_optimal or method == "cart"


def test_a_solution_is_certified_survives_its_file_and_has_a_page(cell, tmp_path):
    loss, split, method = cell
    asked = problem(loss, split, leaf_size=2, leaf_penalty=0.5)
    solution = solve(asked, method)
    certificate = certify(asked, solution)
    assert depth(solution.tree) <= asked.shape.depth
    assert solution.bound <= solution.objective == asked.objective(solution.tree)
    assert math.isclose(certificate.objective, solution.objective, rel_tol=1e-12)
    written = record_tree(asked, solution)
    write_tree_file(tmp_path / "tree.json", written)
    read = read_tree_file(tmp_path / "tree.json")
    assert tree_for(asked, read) == solution.tree
    assert (read.solution.objective, read.solution.bound) == (solution.objective, solution.bound)
    page = tree_page(read, "tree.json")
    assert page == tree_page(written, "tree.json")
    assert "<html" in page


def test_a_weight_of_two_is_a_sample_twice_and_the_order_of_samples_and_features_is_nothing(cell):
    loss, split, method = cell
    rng = np.random.default_rng(3)
    once = solve(problem(loss, split), method)
    rows = rng.permutation(np.repeat(np.arange(N), WEIGHTS.astype(int)))
    columns = np.arange(3) if method == "cart" else rng.permutation(3)  # CART takes the first of equal features
    features = FEATURES[rows][:, columns]
    often = solve(problem(loss, split, rows, weights=np.ones(len(rows)), features=features), method)
    if is_one_optimum(method, once) and is_one_optimum(method, often):
        assert once.objective == pytest.approx(often.objective, rel=1e-12)


def sent(value):
    """Return a copy as another process receives it: arrays that begin at any byte of what came."""
    parts = []
    words = pickle.dumps(value, protocol=5, buffer_callback=parts.append)
    return pickle.loads(words, buffers=[memoryview(b"-" + part.raw().tobytes())[1:] for part in parts])


def test_a_problem_that_another_process_sent_has_the_same_answer(cell):
    loss, split, method = cell
    asked = problem(loss, split)
    assert not sent(FEATURES).flags.aligned
    received = sent(asked)
    found = solve(received, method)
    assert found.objective == solve(asked, method).objective
    certify(received, found)


def test_threads_change_nothing_and_a_known_tree_or_a_limit_leaves_what_is_true(cell):
    loss, split, method = cell
    asked = problem(loss, split)
    best = solve(asked, method)
    threads = solve(asked, method, n_jobs=3)
    assert (threads.objective, threads.bound) == (best.objective, best.bound)
    assert threads.tree == best.tree or REGISTRY[loss, split][method].is_mixed_integer  # HiGHS takes any best tree
    for limits in (Limits(seconds=0.0), Limits(nodes=0)):
        early = solve(asked, method, limits)
        assert certify(asked, early).bound <= best.objective or not best.is_optimal
    poor = solve(problem(loss, split, depth=1), "cart").tree
    assert solve(asked, method, Limits(nodes=0), incumbent=poor).objective <= asked.objective(poor)


def test_ctrl_c_ends_every_search_with_what_is_true(cell):
    loss, split, method = cell
    asked, told = problem(loss, split), []

    def interrupt(state):
        told.append(state)
        raise KeyboardInterrupt

    early = solve(asked, method, progress=interrupt)
    assert certify(asked, early).bound <= early.objective
    may_end = not told or REGISTRY[loss, split][method].is_mixed_integer  # HiGHS may have ended by then
    assert early.stop in (Stop.INTERRUPTED, *((Stop.FINISHED, Stop.OPTIMAL) if may_end else ()))


OF_SOLVE = {"checkpoint", "every", "start", "write"}
"""Options that `solve` reads, and the checkpoint that it opens."""


def test_an_option_that_a_solver_takes_is_read(cell):
    loss, split, method = cell
    solver, read = REGISTRY[loss, split][method], set()

    class Seen(OPTIONS[method]):
        __slots__ = ()

        def __getattribute__(self, name):
            read.add(name)
            return super().__getattribute__(name)

    options = Seen()
    read.clear()
    given = {"limits": Limits(), "incumbent": None, "seed": 0, "n_jobs": 1, "progress": None}
    solver.load()(problem(loss, split), **given, options=options)
    assert {*OPTIONS[method].names()} - {*solver.without} - OF_SOLVE <= read


def test_a_tree_of_another_problem_is_no_incumbent(cell):
    loss, split, method = cell
    leaves = (Leaf(0), Leaf(1)) if loss == "classes" else (ValueLeaf(0.0), ValueLeaf(1.0))
    for tree in (
        Split(0, 99.0, *leaves),
        Split(7, 0.5, *leaves),
        Split(0, 0.5, leaves[0], Split(0, 1.5, leaves[1], Split(0, 2.5, *leaves))),
        Leaf(9),
    ):
        with pytest.raises(ProblemError, match=r"incumbent|depth"):
            solve(problem(loss, split), method, incumbent=tree)


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_setting_is_kept_or_refused_by_name(cell, setting):
    loss, split, method = cell
    of_axis_trees = setting in ("any_depth", "monotone") and split != "axis"
    if of_axis_trees or setting in REGISTRY[loss, split][method].cannot:
        with pytest.raises(ProblemError, match="depth (of|is) None" if setting == "any_depth" else setting):
            solve(problem(loss, split, **SETTINGS[setting]), method)
    else:
        asked = problem(loss, split, **{"depth": 2, **SETTINGS[setting]})
        found = solve(asked, method)
        certify(asked, found)
        # A tree that a method pruned to fit, as it knows nothing of the setting, would end as FINISHED.
        assert found.stop is Stop.OPTIMAL or not REGISTRY[loss, split][method].proves


@pytest.mark.parametrize("setting", SETTINGS)
def test_a_setting_is_another_question_comes_back_from_its_file_and_is_refused_where_none_knows_it(setting, tmp_path):
    asked = problem("classes", "axis", **SETTINGS[setting])
    write_tree_file(tmp_path / "tree.json", record_tree(asked, solve(asked)))
    file = read_tree_file(tmp_path / "tree.json")
    again = file.problem(FEATURES, TARGETS, WEIGHTS)
    certify(again, file.solution)
    assert question_digest(again) == question_digest(asked) != question_digest(problem("classes", "axis"))
    with pytest.raises(ProblemError, match=f"near_optimal .*{'depth' if setting == 'any_depth' else setting}"):
        near_optimal(asked, within=1.0)
    with pytest.raises(ProblemError, match="proof"):
        solve(asked, "exact", options=ExactOptions(proof=tmp_path / "log"))
    if setting != "any_depth":
        with pytest.raises(ProblemError, match="of which a problem file says nothing"):
            encode(asked)


def test_a_budget_is_kept_and_the_sensors_are_those_of_the_certificate(cell):
    loss, split, method = cell
    asked = problem(loss, split, sensor_cost=[2.0, 1.0, 1.0], sensor_budget=1.0)
    solution = solve(asked, method)
    assert len(certify(asked, solution).sensors) <= 1
    assert asked.shape.sensor_cost_of(solution.tree) <= 1
    free = solve(asked.replace(sensor_budget=None), method)
    assert not (solution.is_optimal and free.is_optimal) or free.objective <= solution.objective


def test_missing_readings_are_split_upon_or_refused_by_name(cell):
    loss, split, method = cell
    features = FEATURES.copy()
    features[::4, 0] = np.nan
    if method == "cart" or (loss, split) == ("classes", "axis"):  # trees of CART read one feature a split
        asked = problem(loss, split, features=features, takes_missing=True)
        certify(asked, solve(asked, method))
        return
    said = r"3 readings are missing \(NaN\), and .*; expected every reading; " if loss == "classes" else "missing"
    with pytest.raises(ProblemError, match=said):
        solve(problem(loss, split, features=features, takes_missing=True), method)
