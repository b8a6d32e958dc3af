"""Parts of a tree that are asked for: proven against a list of all trees, recounted, kept by file and doors."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.kinds.shaped import PART_KINDS
from octmip import Leaf, Limits, Problem, Split, certify, solve
from octmip.errors import CertificateError, NoTreeError, ProblemError
from octmip.formats.tree_file import read_tree_file
from octmip.interfaces.cli import main
from octmip.interfaces.estimator import OptimalTreeClassifier
from octmip.interfaces.report.tree.evidence import gather
from octmip.trees.answer.solution import Stop
from octmip.trees.encoding.parts import with_given_thresholds
from octmip.trees.question.part_check import n_changes
from octmip.trees.question.parts import rules_of_columns
from octmip.trees.tradeoff import choose_tree, edits
from octmip.trees.tradeoff.edits import tree_edits
from tests.oracles.parts import least_cost_with_parts

RNG = np.random.default_rng(5)
FEATURES, LABELS = RNG.integers(0, 8, (60, 3)).astype(float), RNG.integers(0, 2, 60)
OLD = Split(0, 2.25, Leaf(0), Split(1, 3.75, Leaf(1), Leaf(0)))


def asked(**options: object) -> Problem:
    return Problem(FEATURES, LABELS, **({"depth": 2} | options))


def test_where_no_tree_of_a_list_of_all_has_the_parts_the_core_says_so():
    drawn = [kind.drawn(np.random.default_rng([kind.stream, k])) for kind in PART_KINDS.values() for k in range(8)]
    without = [problem for problem in drawn if least_cost_with_parts(problem) is None]
    assert len(without) > 3
    for problem in without:
        with pytest.raises(NoTreeError, match="no tree of depth"):
            solve(problem, "exact")


def test_a_split_that_must_stand_where_no_column_is_left_has_no_tree():
    with pytest.raises(NoTreeError, match="no tree of depth 5"):
        solve(Problem(FEATURES[:, :1], LABELS, depth=5, path_rules=[("root-only", 0)], fixed_splits={"L": 0}))


@pytest.mark.parametrize(
    ("parts", "tree", "message"),
    [
        ({"fixed_splits": {"ROOT": "x1"}}, OLD, "has not x1 at ROOT"),
        ({"fixed_splits": {"R": "x1<=3.5"}}, OLD, r"has not x1<=3\.5 at R,"),
        ({"fixed_splits": {"R": "leaf"}}, OLD, "has not leaf at R,"),
        ({"path_rules": [("not-below", "x1", "x0")]}, OLD, "splits x1 below x0"),
        ({"path_rules": [("apart", "x0", "x1")]}, OLD, "splits x1 below x0"),
        ({"path_rules": [("root-only", "x1")]}, OLD, "splits x1 below x0"),
        ({"old_tree": OLD, "max_changes": 1}, Leaf(0), "differs from old_tree at 2 places"),
    ],
)
def test_a_certificate_refutes_a_tree_without_the_part(parts, tree, message):
    free = solve(asked())
    problem = asked(**parts)
    cost = problem.objective(tree)
    claimed = type(free)(tree, cost, 0.0, free.stop.__class__.TIME, 0.0, 0, "x", "1", 0)
    with pytest.raises(CertificateError, match=message):
        certify(problem, claimed)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fixed_splits": {"TOP": "x0"}}, "names the address 'TOP'; expected ROOT, or a way"),
        (
            {"fixed_splits": {"ROOT": ("s", 1.0)}, "sensor_of_feature": ["s", "s", "t"]},
            "fixed_splits of ROOT names 's'",
        ),
        ({"fixed_splits": {"ROOT": "x9"}}, "fixed_splits of ROOT names 'x9'"),
        ({"fixed_splits": {"ROOT": "x0<=a"}}, "expected a number after <="),
        ({"fixed_splits": {"ROOT": "leaf", "L": "x0"}}, "nothing below a leaf"),
        ({"fixed_splits": {"LL": "x0"}}, "names LL but depth is 2; give a depth of 3"),
        ({"path_rules": [("above", "x0")]}, "expected one that begins with not-below, apart, root-only"),
        ({"path_rules": [("apart", "x0", "x0")]}, "expected 2 or more different features"),
        ({"path_rules": [("root-only", 7)]}, "names 7; expected one of the features"),
        ({"old_tree": OLD}, "old_tree and max_changes belong together"),
        ({"old_tree": Split(3, 0.0, Leaf(0), Leaf(1)), "max_changes": 1}, "old_tree reads feature 3"),
        ({"path_rules": [("apart", 0, 1)], "monotone": [1, 0, 0]}, "leave one of them out"),
    ],
)
def test_a_part_that_is_none_is_refused(options, message):
    with pytest.raises(ProblemError, match=message):
        asked(**options)


def test_given_and_old_thresholds_come_back_as_they_were_given():
    fixed = solve(asked(fixed_splits={"ROOT": ("x0", 2.125)})).tree
    assert (fixed.feature, fixed.threshold) == (0, 2.125)
    kept = solve(asked(old_tree=OLD, max_changes=0)).tree
    assert n_changes(kept, OLD) == 0


def test_a_given_threshold_beside_another_one_of_the_old_tree_is_a_change():
    moved = {"fixed_splits": {"ROOT": ("x0", 2.75)}, "old_tree": OLD}  # parts the rows as 2.25 does
    assert n_changes(solve(asked(**moved, max_changes=1)).tree, OLD) == 1
    with pytest.raises(NoTreeError, match="no tree of depth 2"):
        solve(asked(**moved, max_changes=0))


@pytest.mark.parametrize(
    ("price", "parts"),
    [
        (6.0, {"fixed_splits": {"ROOT": "x2"}}),
        (40.0, {"fixed_splits": {"LL": "x2"}}),
        (6.0, {"path_rules": [("apart", 0, 1)]}),
    ],
)
def test_without_a_depth_the_price_bounds_the_search_and_ends_it(price, parts):
    problem = asked(depth=None, leaf_penalty=price, **parts)
    found = solve(problem)
    assert (found.stop, found.objective) == (Stop.OPTIMAL, solve(problem.replace(depth=7)).objective)
    open_still = solve(problem.replace(depth=None, leaf_penalty=1.0), limits=Limits(nodes=100))
    assert open_still.stop is Stop.NODES
    assert len(parts.get("fixed_splits", ())) <= open_still.bound <= open_still.objective


def test_missing_readings_go_where_it_is_best_below_a_given_split():
    features = FEATURES.copy()
    features[::7, 0] = np.nan
    free = solve(Problem(features, LABELS, depth=1, allowed_splits=[["x0"]]))
    given = solve(Problem(features, LABELS, depth=1, fixed_splits={"ROOT": "x0"}))
    assert given.is_optimal
    assert given.objective == free.objective


def test_the_classifier_takes_rules_by_column_and_splits_by_feature():
    frame = pd.DataFrame(FEATURES, columns=["a", "b", "c"]).assign(d=np.where(FEATURES[:, 0] > 3, "u", "v"))
    tree = OptimalTreeClassifier(max_depth=2, path_rules=[("apart", "d", "a")], fixed_splits={"ROOT": "a"})
    tree.fit(frame, LABELS)
    assert 0 in {tree.tree_.feature}
    assert all(rule[0] == "apart" for rule in tree.problem_.shape.path_rules)
    with pytest.raises(ProblemError, match="with max_depth='auto'"):
        OptimalTreeClassifier(path_rules=[("root-only", "a")]).fit(frame, LABELS)


@pytest.fixture
def solved(tmp_path, capsys):
    table = tmp_path / "t.csv"
    pd.DataFrame(FEATURES, columns=["a", "b", "c"]).assign(y=LABELS).to_csv(table, index=False)
    tree = str(tmp_path / "tree.json")
    assert main(["solve", str(table), "--label", "y", "--depth", "2", "--out", tree]) == 0
    capsys.readouterr()
    return str(table), tree, str(tmp_path / "new.json")


def test_the_page_tells_the_proven_cost_of_other_columns_at_each_split(solved):
    table, tree, new = solved
    file = read_tree_file(tree)
    edits = gather(file, asked(feature_names=("a", "b", "c")), seconds=200.0).edits
    top, below = file.tree, file.tree.left
    names = ("a", "b", "c")
    assert {price.sensor for price in edits[""]} == set(names) - {names[top.feature]}
    above = f"{names[top.feature]}<={top.threshold!r}"
    for path, given in (("", {}), ("L", {"ROOT": above})):
        for price in edits[path]:
            there = {path or "ROOT": price.sensor}
            best = solve(asked(feature_names=names, fixed_splits=given | there))
            assert (price.objective, price.bound, price.stop) == (best.objective, best.objective, Stop.OPTIMAL)
    assert names[below.feature] not in {price.sensor for price in edits["L"]}
    assert main(["report", tree, table, "--out", new.replace("json", "html"), "--seconds", "200"]) == 0
    page = Path(new.replace("json", "html")).read_text()
    more = edits[""][0].objective - file.solution.objective
    assert f"{edits[''][0].objective:g} errors at the best, {f'{more:g} error' if more else 'no more'}" in page


def test_other_columns_are_those_that_lose_least_in_one_split():
    rng = np.random.default_rng(2)
    features, weights = rng.integers(0, 5, (60, 9)).astype(float), rng.integers(1, 9, 60)
    problem = Problem(features, rng.integers(0, 2, 60), depth=1, weights=weights)
    best = solve(problem).tree
    every = [solve(problem.replace(fixed_splits={"ROOT": f"x{j}"})).objective for j in range(9) if j != best.feature]
    found = [price.objective for price in tree_edits(problem, best, 60.0)[""]]
    assert found == sorted(every)[: edits.MOST_SENSORS]


def test_each_search_of_another_column_has_an_equal_share_of_the_seconds(monkeypatch):
    given = []

    def solved(problem, method, limits):
        given.append(limits.seconds)
        raise NoTreeError("none")

    monkeypatch.setattr(edits, "solve", solved)
    monkeypatch.setattr(edits.time, "perf_counter", lambda: sum(given))
    tree_edits(asked(), OLD, 12.0)
    assert given == pytest.approx([12.0 / 4] * 4)  # two columns at two splits


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--fix", "ROOT=kind is k"],
            "--fix of ROOT names 'kind is k'; did you mean kind is w or kind is v or kind is u?",
        ),
        (["--fix", "ROOT=kin"], "--fix of ROOT names 'kin'; did you mean kind?"),
        (["--path-rule", "apart=kinds,a"], "--path-rule names 'kinds'; did you mean kind?"),
        (["--max-changes", "1"], "--old-tree and --max-changes belong together"),
        (["--fix", "ROOT=a", "--proof", "p.log"], "a proof log has no lines for the bounds of given parts"),
    ],
)
def test_a_fault_names_the_option_and_the_nearest_columns(tmp_path, capsys, words, message):
    table = tmp_path / "t.csv"
    kind = np.array(["u", "v", "w"])[np.arange(60) % 3]
    pd.DataFrame(FEATURES, columns=["a", "b", "c"]).assign(kind=kind, y=LABELS).to_csv(table, index=False)
    command = ["solve", str(table), "--label", "y", "--depth", "2"]
    assert main([*command, *words]) == 2
    assert message in capsys.readouterr().err
    assert main([*command, "--categories", "subsets", "--fix", "ROOT=kind in {u, w}", "--fix", "L=a <= 3.5"]) == 0
    assert "if kind not in {v}\n    if a <= 3.5" in capsys.readouterr().out


def test_the_command_takes_every_part(solved, capsys):
    table, tree, new = solved
    words = ["--fix", "ROOT=b", "--path-rule", "apart=a,c", "--old-tree", tree, "--max-changes", "4", "--out", new]
    assert main(["solve", table, "--label", "y", "--depth", "3", *words]) == 0
    assert main(["certify", new, table]) == 0
    capsys.readouterr()
    assert main(["solve", table, "--label", "y", "--depth", "3", "--path-rule", "near=a"]) == 2
    assert "expected not-below, apart, root-only" in capsys.readouterr().err


@pytest.mark.parametrize("penalty", [1.5, 100.0])
@pytest.mark.parametrize("weight", [1.0, 0.1])
@pytest.mark.parametrize("parts", [
    {"fixed_splits": {"L": "x0", "ROOT": "x1"}},
    {"old_tree": Split(1, 0.5, Split(0, 0.5, Leaf(0), Leaf(0)), Leaf(0)), "max_changes": 0},
], ids=["given", "old"])  # fmt: skip
def test_the_price_of_splits_that_must_stand_is_paid_in_full(penalty, weight, parts):
    x = np.array([[0.0, 1, 0, 1, 0, 1, 1]]).T
    settings = {"weights": np.full(7, weight), "leaf_penalty": penalty, **parts}
    features = np.column_stack((x, [0.0, 0, 0, 0, 0, 1, 1]))
    for depth in (3, None):
        found = solve(Problem(features, np.array([0, 1, 0, 0, 1, 1, 0]), depth=depth, **settings), "exact")
        assert found.is_optimal
        assert found.objective == pytest.approx(2 * penalty + 3 * weight)


@pytest.mark.parametrize(("side", "changes"), [("right", 0), ("left", 1), (None, 0)])
def test_another_side_for_missing_readings_is_a_change(side, changes):
    assert (
        n_changes(Split(0, 1.5, Leaf(0), Leaf(0), missing=side), Split(0, 1.5, Leaf(0), Leaf(0), missing="right"))
        == changes
    )


def test_a_kept_split_keeps_its_side_for_missing_readings():
    old = Split(0, 1.5, Leaf(0), Leaf(0), missing="right")
    rows = np.array([[0.0], [1.0], [1.0], [2.0]])
    for gap in ([], [[np.nan]]):
        features = np.array([*rows.tolist(), *gap])
        settings = {"depth": 1, "takes_missing": [True], "old_tree": old, "max_changes": 0}
        found = solve(Problem(features, np.arange(len(features)) % 2, **settings), "exact")
        assert found.tree.missing == "right"


@pytest.mark.parametrize(("old", "new", "threshold"), [
    ("left", "left", 2.25), ("left", "right", 2.5), (None, "right", 2.25), ("left", None, 2.25), (None, None, 2.25),
])  # fmt: skip
def test_a_threshold_of_the_old_tree_comes_back_unless_its_split_has_another_side_for_missing(old, new, threshold):
    problem = asked(old_tree=Split(0, 2.25, Leaf(0), Leaf(1), missing=old), max_changes=3)
    found = with_given_thresholds(problem, Split(0, 2.5, Leaf(0), Leaf(1), missing=new))
    assert found == Split(0, threshold, Leaf(0), Leaf(1), missing=new)
    assert with_given_thresholds(problem, Split(0, 3.5, Leaf(0), Leaf(1))).threshold == 3.5  # parts others
    assert with_given_thresholds(problem, Split(1, 2.5, Leaf(0), Leaf(1))).threshold == 2.5


def test_a_rule_of_one_column_is_refused():
    for rule in (["apart", "a"], ["not-below", "a", "a"]):
        with pytest.raises(ProblemError, match="2 or more different columns"):
            rules_of_columns([rule], ["a", "b"])
    with pytest.raises(ProblemError, match=r"one of the columns a, b$"):
        rules_of_columns([["root-only", "z"]], ["a", "a", "b"])


@pytest.mark.parametrize("most", range(4))
def test_a_leaf_has_the_parts_of_an_old_tree_where_every_split_may_go(most):
    assert asked(old_tree=OLD, max_changes=most).shape.is_leaf_allowed == (most >= 2)


@pytest.mark.parametrize("order", [1, -1])
def test_rules_of_columns_are_those_of_each_rule(order):
    columns, rules = ["a", "a", "b"], [["apart", "a", "b"], ["not-below", "a", "b"], ["root-only", "b"]][::order]
    assert rules_of_columns(rules, columns) == [one for rule in rules for one in rules_of_columns([rule], columns)]


@pytest.mark.parametrize("parts", [{"fixed_splits": {"ROOT": 0}}, {"old_tree": OLD, "max_changes": 0}])
def test_a_choice_among_prices_names_the_part_that_allows_no_leaf(parts):
    with pytest.raises(ProblemError, match=f"{list(parts)[-1]} allows no leaf"):
        choose_tree(asked(**parts))
