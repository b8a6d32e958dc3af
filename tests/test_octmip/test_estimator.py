"""OptimalTreeClassifier keeps scikit-learn's contract and says what was proven."""

import json
import math
import os
import subprocess
import sys
from dataclasses import replace

import joblib
import numpy as np
import pandas as pd
import pytest
from sklearn.datasets import load_iris
from sklearn.exceptions import ConvergenceWarning, NotFittedError

import octmip
from octmip import ClassCosts, OptimalTreeClassifier, OptimalTreeRegressor, Problem, Stop, solve
from octmip.errors import ProblemError, SolverError
from octmip.interfaces.estimator import fitted as fitted_tree
from octmip.interfaces.estimator.settings import seed_of, threads_of

IRIS = load_iris(return_X_y=True)
CHECKS = """
import json, os, sys, warnings
os.environ["SCIPY_ARRAY_API"] = "1"  # scipy reads it when it is imported; without it some checks are skipped
from sklearn.utils.estimator_checks import check_estimator
from octmip import OptimalTreeClassifier, OptimalTreeRegressor
warnings.simplefilter("ignore")
found = check_estimator(eval(sys.argv[1]), on_skip=None, on_fail=None)
print(json.dumps([(one["check_name"], one["status"], str(one["exception"])) for one in found]))
"""


# Without time CART's prunings alone are chosen among, which is the same for every run.
@pytest.mark.long("OptimalTreeRegressor(seconds=0.0)")
@pytest.mark.parametrize("estimator", ["OptimalTreeClassifier(max_depth=2)", "OptimalTreeRegressor(seconds=0.0)"])
def test_classifier_and_regressor_pass_all_of_scikit_learns_own_checks(estimator):
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", CHECKS, estimator]
    results = json.loads(subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout)
    assert len(results) > 45
    assert not [found for found in results if found[1] != "passed"]


def test_importing_octmip_imports_neither_scikit_learn_nor_pandas():
    code = "import octmip, sys; print('OptimalTreeClassifier' in dir(octmip), {'sklearn', 'pandas'} & {*sys.modules})"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout == "True set()\n"
    with pytest.raises(AttributeError, match="no attribute 'OptimalTree'"):
        _ = octmip.OptimalTree


def test_shares_are_those_of_the_training_weight_in_the_leaf():
    plain = OptimalTreeClassifier(max_depth=1, method="cart", smoothing=0)
    fitted = plain.fit([[0], [0], [1], [1]], [0, 0, 0, 1], [1, 1, 1, 3])
    assert fitted.predict_proba([[0], [1]]).tolist() == [[1, 0], [0.25, 0.75]]
    assert fitted.predict_log_proba([[0], [1]]).tolist() == [[0, -math.inf], [math.log(0.25), math.log(0.75)]]


def test_a_frame_of_costs_and_a_series_of_priors_go_by_the_names_of_the_classes():
    features, labels = [[0.0], [0.0], [0.0], [1.0]], ["a", "a", "b", "b"]
    costs = pd.DataFrame([[0, 1], [5, 0]], index=["a", "b"], columns=["a", "b"])
    truth = OptimalTreeClassifier(max_depth=1, method="cart", costs=costs.to_numpy()).fit(features, labels)
    for turned in (costs, costs.loc[["b", "a"], ["a", "b"]], costs.loc[["b", "a"], ["b", "a"]]):
        model = OptimalTreeClassifier(max_depth=1, method="cart", costs=turned).fit(features, labels)
        assert model.objective_ == truth.objective_ == 2.0
        assert Problem(features, labels, depth=1, loss=ClassCosts(turned)).objective(model.tree_) == 2.0
    told = truth.predict_proba([[0.0]], [0.9, 0.1])
    for prior in (pd.Series({"b": 0.1, "a": 0.9}), {"b": 0.1, "a": 0.9}):
        assert (truth.predict_proba([[0.0]], prior) == told).all()
    with pytest.raises(ProblemError, match="prior names a, z; expected each of the classes a, b once"):
        truth.predict_proba([[0.0]], {"a": 0.9, "z": 0.1})


def test_a_class_weight_that_is_none_is_refused():
    for wrong in ("heavy", {"z": 2.0}):
        with pytest.raises(ValueError, match="class"):
            OptimalTreeClassifier(class_weight=wrong).fit([[0.0], [1.0]], ["a", "b"])


def test_threads_and_seeds_are_what_scikit_learn_means_by_them():
    assert (threads_of(None), threads_of(3), threads_of(-1)) == (1, 3, joblib.cpu_count())
    with joblib.parallel_config(n_jobs=2):
        assert threads_of(None) == 2
    assert seed_of(7) == 7
    assert seed_of(np.random.RandomState(0)) == seed_of(np.random.RandomState(0)) != seed_of(None)
    fitted = OptimalTreeClassifier(max_depth=1, random_state=np.random.RandomState(3), n_jobs=-1).fit(*IRIS)
    assert fitted.solution_.seed == seed_of(np.random.RandomState(3))


@pytest.mark.parametrize(
    "ask",
    [
        *(lambda e, name=name: getattr(e, name) for name in ("tree_", "gap_", "bound_", "objective_", "is_optimal_")),
        *(lambda e, name=name: getattr(e, name)(IRIS[0]) for name in ("predict", "predict_proba", "predict_log_proba")),
        *(lambda e, name=name: getattr(e, name)(IRIS[0]) for name in ("apply", "decision_path", "report")),
        *(lambda e, name=name: getattr(e, name)() for name in ("get_depth", "export_text", "plot", "to_sklearn")),
        lambda e: e.sensors_,
    ],
)
def test_what_is_not_fitted_says_so(ask):
    with pytest.raises(NotFittedError):
        ask(OptimalTreeClassifier())


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"max_depth": 0}, "max_depth is 0; expected a whole number from 1 to 30"),
        ({"max_depth": None}, "max_depth is None"),
        ({"min_samples_leaf": 0}, "min_samples_leaf is 0"),
        ({"min_samples_leaf": 1.5}, r"min_samples_leaf is 1\.5"),
        ({"random_state": -1}, "random_state is -1"),
    ],
)
def test_a_wrong_parameter_is_refused_by_its_own_name(wrong, message):
    with pytest.raises(ProblemError, match=message):
        OptimalTreeClassifier(**wrong).fit(*IRIS)


HARD = np.random.default_rng(0).random((200, 8)), np.random.default_rng(1).integers(0, 2, 200)


def test_estimators_take_leaves():
    features, labels = HARD[0][:40, :3], HARD[1][:40]
    tree = OptimalTreeClassifier(max_depth=4, max_leaf_nodes=3).fit(features, labels)
    assert tree.objective_ == solve(Problem(features, labels, depth=4, max_splits=2)).objective
    numbers = OptimalTreeRegressor(max_depth=3, max_leaf_nodes=2, method="search").fit(features, features[:, 1])
    assert numbers.get_n_leaves() == 2
    for wrong, message in (
        ({"max_depth": 2, "max_leaf_nodes": 0}, "max_leaf_nodes is 0"),
        ({"max_leaf_nodes": 3}, "max_leaf_nodes is 3 with max_depth='auto'"),
        ({"max_depth": 2, "split": "hyperplane", "max_leaf_nodes": 3}, "max_leaf_nodes is 3 but split is 'hyperplane'"),
    ):
        with pytest.raises(ProblemError, match=message):
            OptimalTreeClassifier(**wrong).fit(features, labels)


def test_a_proof_that_a_limit_ends_warns_with_the_gap():
    with pytest.warns(ConvergenceWarning, match=r"at its limit of 0 s: the objective is .* \(gap_ 1\)") as caught:
        fitted = OptimalTreeClassifier(max_depth=4, seconds=0.0).fit(*HARD)
    assert caught[0].filename == __file__
    assert fitted.gap_ == 1


def stopped(monkeypatch, **changes):
    """Let every solve return what it finds with some fields changed."""
    found = fitted_tree.solve_run
    monkeypatch.setattr(fitted_tree, "solve_run", lambda *given, **named: replace(found(*given, **named), **changes))


@pytest.mark.parametrize(
    ("stop", "bound", "words"),
    [
        (Stop.TIME, 3.0, "at its limit of 60 s: the objective is 6, and no tree is below 3 (gap_ 0.5); "),
        (Stop.MEMORY, 3.0, "at its limit of memory: "),
        (Stop.NUMERICS, 3.0, "scale weights and costs to whole numbers"),
        (Stop.NODES, -math.inf, "ended early: the objective is 6, and no bound above 0 is proven (gap_ inf)"),
    ],
)
def test_the_warning_says_why_the_proof_ended_and_what_holds(monkeypatch, stop, bound, words):
    stopped(monkeypatch, stop=stop, bound=bound)
    with pytest.warns(ConvergenceWarning) as caught:
        OptimalTreeClassifier(max_depth=2).fit(*IRIS)
    assert words in str(caught[0].message)


def test_an_interrupt_is_raised_and_leaves_the_best_tree(monkeypatch):
    stopped(monkeypatch, stop=Stop.INTERRUPTED, bound=3.0)
    asked = OptimalTreeClassifier(max_depth=2)
    with pytest.raises(KeyboardInterrupt):
        asked.fit(*IRIS)
    assert asked.gap_ == 0.5
    assert (asked.predict(IRIS[0]) != IRIS[1]).sum() == 6


def test_no_tree_at_all_is_an_error(monkeypatch):
    stopped(monkeypatch, tree=None, objective=math.inf, stop=Stop.TIME)
    with pytest.raises(SolverError, match="give it more seconds"):
        OptimalTreeClassifier(max_depth=2).fit(*IRIS)
