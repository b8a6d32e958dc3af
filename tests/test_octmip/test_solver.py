"""solve: which solver answers, what it starts from, and that nothing leaves it uncertified."""

import dataclasses
import functools
import math
import threading

import numpy as np
import pytest

from octmip import Leaf, Limits, Problem, Solution, Split, Stop, certify, solve
from octmip.errors import ProblemError, SolverError
from octmip.trees import solver
from octmip.trees.answer import interruption
from octmip.trees.methods.options import ExactOptions, SearchOptions
from octmip.trees.question.losses.errors_of_numbers import SquaredError
from octmip.trees.runs import registry

STRIPES = Problem([[0.0], [1.0], [2.0], [3.0]], [0, 1, 1, 0], depth=2)
ZERO_ERRORS = Split(0, 0.5, Leaf(0), Split(0, 2.5, Leaf(1), Leaf(0)))


def answering(**changes):
    """Return a solver that answers with the error-free tree of STRIPES, some of its claims changed."""

    def answer(problem, *, limits, incumbent, seed, n_jobs, progress, options, **study):
        call = {"limits": limits, "incumbent": incumbent, "seed": seed, "n_jobs": n_jobs, "options": options}
        answer.calls.append(call)
        solution = Solution(ZERO_ERRORS, 0.0, 0.0, Stop.OPTIMAL, 0.0, 1, "answering", "1", seed)
        return dataclasses.replace(solution, **changes)

    answer.calls = []
    return answer


def test_a_logger_takes_each_certified_solution_and_is_silent_unless_asked(caplog):
    solve(STRIPES)
    assert not caplog.records
    with caplog.at_level("INFO", logger="octmip"):
        found = solve(STRIPES)
    assert caplog.messages[-1] == repr(found)
    assert "objective 0, bound 0: proven optimal" in caplog.messages[-1]


@pytest.fixture
def registered(monkeypatch):
    """Return a function that puts a solver in the registry's place of a method."""

    def register(name, function, proves=True, split="axis"):
        registration = dataclasses.replace(registry.REGISTRY["classes", split][name], proves=proves)
        monkeypatch.setitem(registry.REGISTRY["classes", split], name, registration)
        previous = registry.Registration.load
        monkeypatch.setattr(
            registry.Registration, "load", lambda self: function if self is registration else previous(self)
        )
        return function

    return register


def test_auto_is_exact_for_axis_and_search_for_hyperplanes():
    assert solver.chosen_method(STRIPES, "auto") == "exact"
    hyperplane = Problem(STRIPES.samples.features, STRIPES.samples.targets, depth=1, split="hyperplane")
    assert solver.chosen_method(hyperplane, "auto") == "search"
    with pytest.raises(ProblemError, match=r"method 'oct' finds no hyperplane trees .*; expected one of auto, cart"):
        solver.chosen_method(hyperplane, "oct")


def test_a_proof_starts_from_a_tree_of_search(registered):
    exact = registered("exact", answering())
    registered("search", answering(bound=-math.inf, stop=Stop.FINISHED), proves=False)
    solve(STRIPES.replace(depth=5), limits=Limits(seconds=100), seed=3, n_jobs=2)
    call = exact.calls[0]
    assert call["incumbent"] == ZERO_ERRORS
    assert call["seed"] == 3
    assert call["n_jobs"] == 2
    assert 98 < call["limits"].seconds < 99  # one is left to a search


@pytest.mark.parametrize(
    ("method", "seconds", "given", "restarts"),
    [
        ("auto", 100.0, 85.0, None),  # so deep a proof hardly ends: a search has all but the rest
        ("auto", math.inf, math.inf, 4),
        ("exact", 100.0, 20.0, 4),
    ],
)
def test_a_search_before_a_deep_proof_has_its_share(registered, method, seconds, given, restarts):
    registered("exact", answering())
    search = registered("search", answering(bound=-math.inf, stop=Stop.FINISHED), proves=False)
    solve(STRIPES.replace(depth=5), method, Limits(seconds=seconds))
    assert search.calls[0]["limits"].seconds == pytest.approx(given, rel=0.01)
    assert search.calls[0]["options"].restarts == restarts


@pytest.mark.parametrize("incumbent", [None, Split(0, 0.5, Leaf(0), Leaf(1))])
def test_a_shallow_exact_proof_starts_at_once_from_the_users_tree_if_there_is_one(registered, incumbent):
    exact = registered("exact", answering())
    search = registered("search", answering(), proves=False)
    solve(STRIPES, incumbent=incumbent)
    assert not search.calls
    assert exact.calls[0]["incumbent"] == incumbent


def test_a_two_feature_proof_starts_from_the_best_axis_aligned_tree():
    rng = np.random.default_rng(0)
    features = rng.normal(size=(300, 12))
    labels = (features[:, 0] + features[:, 1] > 0) + 2 * (features[:, 2] - features[:, 3] > 0.5)
    axis = solve(Problem(features, labels, depth=2))
    stopped = solve(Problem(features, labels, depth=2, split="hyperplane", split_size=2), "exact", Limits(nodes=0))
    assert axis.is_optimal
    assert stopped.objective <= axis.objective


@pytest.mark.parametrize(("bound", "stop"), [(0.0, Stop.OPTIMAL), (-1.0, Stop.TIME)])
def test_the_better_of_incumbent_and_proof_comes_back_and_is_optimal_where_the_bound_meets_it(registered, bound, stop):
    registered("exact", answering(tree=Leaf(0), objective=2.0, bound=bound, stop=Stop.TIME))
    solution = solve(STRIPES, incumbent=ZERO_ERRORS)
    assert (solution.tree, solution.objective, solution.stop) == (ZERO_ERRORS, 0.0, stop)
    assert solution.is_optimal == (stop is Stop.OPTIMAL)


@pytest.mark.parametrize(
    "changes", [{"objective": 1.0}, {"bound": 0.5}, {"tree": Leaf(0)}, {"tree": Leaf(0), "objective": 1.0}]
)
def test_a_solution_that_its_certificate_refutes_never_leaves(registered, changes):
    registered("exact", answering(**changes))
    registered("search", answering(), proves=False)
    for incumbent in (None, ZERO_ERRORS):  # a better tree to return is no excuse for a wrong claim
        with pytest.raises(SolverError, match="certificate refutes"):
            solve(STRIPES, incumbent=incumbent)


def test_ctrl_c_in_a_proof_returns_the_incumbent(registered):
    def interrupted(problem, **_):
        raise KeyboardInterrupt

    registered("exact", interrupted)
    solution = solve(STRIPES, incumbent=ZERO_ERRORS)
    assert solution.tree == ZERO_ERRORS
    assert solution.stop is Stop.INTERRUPTED
    assert solution.bound == -math.inf


def test_ctrl_c_in_the_search_returns_a_tree_without_starting_the_proof(registered):
    def interrupted(problem, **_):
        raise KeyboardInterrupt

    registered("search", interrupted, proves=False)
    exact = registered("exact", answering())
    solution = solve(STRIPES.replace(depth=5))
    assert not exact.calls
    assert solution.stop is Stop.INTERRUPTED
    certify(STRIPES, solution)


def test_progress_counts_from_the_start_of_solve(registered):
    seen = []

    def reporting(problem, *, progress, **_):
        progress(solver.Progress(0.0, 0.0, 0.0, 1))
        return answering()(problem, progress=None, limits=None, incumbent=None, seed=0, n_jobs=1, options=None)

    registered("exact", reporting)
    solution = solve(STRIPES, incumbent=ZERO_ERRORS, progress=seen.append)
    assert len(seen) == 1
    assert 0 < seen[0].seconds <= solution.seconds


@pytest.mark.parametrize(
    ("method", "asked", "lacked"),
    [
        ("exact", {"sensor_budget": 0.0, "max_splits": 1}, "sensor_budget"),
        ("search", {"old_tree": Leaf(0), "max_changes": 0}, "max_changes"),
        ("benders", {"max_splits": 0}, "max_splits"),
    ],
)
def test_a_limit_of_nothing_is_a_limit(method, asked, lacked):
    problem = Problem([[0.0], [1.0], [2.0], [3.0]], [0, 0, 1, 1], depth=2, **asked)
    with pytest.raises(ProblemError, match=f"does not know the problem's {lacked}"):
        solve(problem, method)
    certify(problem, solve(problem, "auto"))


def test_an_option_that_the_solver_does_not_take_is_refused():
    with pytest.raises(
        ProblemError,
        match="takes no option 'proof'; expected some of: checkpoint, cluster, perturbations, restarts;",
    ):
        solve(STRIPES, method="search", options=ExactOptions(proof="log"))
    assert solve(STRIPES, method="search", options=SearchOptions(restarts=2)).objective == 0


def test_options_of_no_class_are_refused_with_the_class_that_is_meant():
    with pytest.raises(ProblemError, match=r"options is a dict; .*; write options=SearchOptions\(restarts=2\)"):
        solve(STRIPES, method="search", options={"restarts": 2})


def test_a_solver_that_is_not_installed_says_so(registered, monkeypatch):
    missing = dataclasses.replace(registry.REGISTRY["classes", "axis"]["oct"], module="octmip.no_such_module")
    monkeypatch.setitem(registry.REGISTRY["classes", "axis"], "oct", missing)
    with pytest.raises(SolverError, match=r"needs the module octmip\.no_such_module"):
        solve(STRIPES, method="oct", incumbent=ZERO_ERRORS)


@pytest.mark.parametrize("loss", [None, SquaredError()], ids=["classes", "numbers"])
def test_a_signal_ends_a_proof_in_another_thread(loss):
    random = np.random.default_rng(0)
    features, label = random.normal(size=(3000, 8)), random.integers(0, 2, size=3000)
    given = {"targets": label} if loss is None else {"targets": label * 1.0, "loss": loss}
    problem, begun, found = Problem(features, **given, depth=5), threading.Event(), []

    def work():
        found.append(solve(problem, "exact", incumbent=problem.best_leaf(), progress=lambda state: begun.set()))

    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    assert begun.wait(60)
    interruption.note()
    thread.join(60)
    assert found[0].stop is Stop.INTERRUPTED


RNG = np.random.default_rng(8)
TABLE, HALVES = RNG.normal(size=(30, 3)), RNG.integers(0, 2, 30)


@pytest.mark.parametrize(
    "asked",
    [
        Problem(TABLE, HALVES, depth=5),
        Problem(TABLE, HALVES, depth=2, split="hyperplane", split_size=2),
        Problem(TABLE, HALVES, depth=1, split="hyperplane"),
        Problem(TABLE, HALVES, depth=2, monotone=[1, 0, 0]),
        Problem(TABLE, TABLE[:, 0] ** 2, depth=2, loss=SquaredError()),
        Problem(TABLE, TABLE[:, 0] ** 2, depth=2, loss=SquaredError(), monotone=[1, 0, 0]),
    ],
)
def test_no_solver_is_given_more_seconds_than_are_left(asked, monkeypatch):
    given, load = [], registry.Registration.load

    def watched(registration):
        function = load(registration)

        @functools.wraps(function)
        def answer(*arguments, limits, **named):
            given.append(limits.seconds)
            return function(*arguments, limits=limits, **named)

        return answer

    monkeypatch.setattr(registry.Registration, "load", watched)
    solve(asked, limits=Limits(seconds=100.0))
    assert 0 < max(given) <= 100


@pytest.mark.parametrize(
    ("method", "states", "n_searches"),
    [
        ("auto", [(10.0, 0.0)], 0),  # too soon
        ("auto", [(20.0, 0.5)], 0),  # the bound is a greater share of 2.0 than the time of 100 s
        ("auto", [(20.0, 0.0), (20.1, 0.0)], 2),  # as long as the search took, which is 0 s here
        ("auto", [(20.0, 0.3)], 1),
        ("exact", [(79.0, 0.0)], 0),
        ("exact", [(81.0, 0.0)], 1),
    ],
)
def test_a_proof_whose_bound_lags_behind_the_clock_pauses_for_a_search(registered, method, states, n_searches):
    def lagging(problem, *, progress, **study):
        for seconds, bound in states:
            progress(solver.Progress(seconds, 2.0, bound, 1))
        return answering(tree=Leaf(0), objective=2.0, bound=0.0, stop=Stop.NODES)(problem, progress=progress, **study)

    registered("exact", lagging)
    stump = answering(tree=Split(0, 0.5, Leaf(0), Leaf(1)), objective=1.0, bound=-math.inf, stop=Stop.FINISHED)
    search = registered("search", stump, proves=False)
    shown = []
    solution = solve(STRIPES, method, Limits(seconds=100), seed=3, progress=shown.append)
    assert len(search.calls) == n_searches
    assert len({call["seed"] for call in search.calls}) == n_searches
    assert solution.objective == (1.0 if n_searches else 2.0)
    assert solution.details["tree_by"] == ("answering" if n_searches else "exact")
    assert [state.objective for state in shown] == [2.0, 1.0][: len(states)]


def test_a_proof_over_two_features_pauses_too(registered):
    asked = Problem([[0, 1], [1, 0], [2, 1], [3, 0]], [0, 1, 1, 0], depth=2, split="hyperplane", split_size=2)

    def lagging(problem, *, progress, **study):
        progress(solver.Progress(90.0, 2.0, 0.0, 1))
        return answering(tree=Leaf(0), objective=2.0, bound=0.0, stop=Stop.NODES)(problem, progress=progress, **study)

    registered("exact", lagging, split="hyperplane")
    stump = answering(tree=Split(0, 0.5, Leaf(0), Leaf(1)), objective=1.0, bound=-math.inf, stop=Stop.FINISHED)
    registered("search", stump, proves=False, split="hyperplane")
    assert solve(asked, "exact", Limits(seconds=100)).objective == 1.0
