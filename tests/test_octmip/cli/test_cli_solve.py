"""octmip solve, compare and frontier: what they print and what they write."""

import json
import math

import highspy
import numpy as np
import pandas as pd
import pytest

from octmip import Leaf, Problem, Solution, Stop, solve
from octmip.errors import SolverError
from octmip.formats.tree_file import read_tree_file
from octmip.interfaces.cli.arguments import Parser
from octmip.interfaces.cli.gap_times import GapTimes
from octmip.interfaces.cli.options import solve as options
from octmip.interfaces.cli.samples.table_problem import read_problem
from octmip.trees import solver
from octmip.trees.answer.solution import Progress
from octmip.trees.runs import registry


def test_solve_json_is_one_object_and_nothing_else(data, run):
    code, out, err = run("solve", data, "--label", "y", "--depth", 1, "--method", "search", "--json")
    answer = json.loads(out)
    assert code == 0
    assert err == ""
    assert out.count("\n") == 1
    wanted = "objective errors bound gap is_optimal stop seconds n_nodes method depth n_splits sensors tree"
    assert set(wanted.split()) <= set(answer)
    assert answer["errors"] == answer["objective"] == 1
    assert answer["sensors"] == ["a"]
    assert answer["bound"] is None
    assert answer["tree"]["feature"] == "a"
    assert answer["tree"]["left"] == {"label": "low"}


def test_every_setting_reaches_the_problem(data, run, tmp_path):
    (tmp_path / "costs.csv").write_text("true,low,high\nlow,0,5\nhigh,2,0\n")
    (tmp_path / "sensors.csv").write_text("feature,sensor,cost\na,left,3\nb,right,1\n")
    words = ["--features", "b,a", "--split-size", 2, "--leaf-size", 3, "--leaf-penalty", 0.5, "--weights", "w"]
    words += ["--costs", tmp_path / "costs.csv", "--sensor-cost", tmp_path / "sensors.csv", "--budget", 2]
    out_file = tmp_path / "t.json"
    words += ["--method", "cart", "--seed", 7, "--out", out_file]
    code, _, err = run("solve", data, "--label", "y", "--depth", 2, *words)
    assert code == 0, err
    file = read_tree_file(out_file)
    settings = file.settings
    assert file.feature_names == ("b", "a")
    assert file.class_names == ("high", "low")
    assert file.solution.seed == 7
    assert (settings["split"], settings["split_size"], settings["leaf_size"]) == ("hyperplane", 2, 3)
    assert settings["loss"]["costs"] == [[0, 2], [5, 0]]
    assert settings["leaf_penalty"] == 0.5
    assert settings["depth"] == 2
    assert settings["sensor_cost"] == {"right": 1, "left": 3}
    assert settings["sensor_budget"] == 2
    assert run("certify", out_file, data)[0] == 0


def test_an_incumbent_is_taken_up(data, run, refused, tree):
    words = ["solve", data, "--label", "y", "--depth", 1, "--method", "search", "--incumbent", tree]
    assert "if a <= 11.5" in run(*words, "--features", "b,a")[1]
    assert "names the feature 'a', which is not among" in refused(*words, "--features", "b")
    assert "incumbent is no tree of this problem: leaf 0" in refused(*words, "--features", "a,b", "--leaf-size", 15)


def test_compare_shows_every_method_and_the_gap_to_the_best_bound(data, run, monkeypatch):
    def proves(problem, **_):
        leaf = registry.REGISTRY["classes", "axis"]["cart"].load()(
            problem, limits=solver.Limits(), incumbent=None, seed=0, n_jobs=1, progress=None
        )
        return Solution(leaf.tree, leaf.objective, 1.0, Stop.OPTIMAL, 0.0, 1, "exact", "1", 0)

    def fails(problem, **_):
        raise SolverError("out of luck")

    load = registry.Registration.load
    replaced = {"octmip.trees.methods.exact": proves, "octmip.trees.mip.oct": fails}
    monkeypatch.setattr(registry.Registration, "load", lambda self: replaced.get(self.module) or load(self))
    words = ["compare", data, "--label", "y", "--depth", 1, "--features", "a", "--methods", "cart,exact,oct"]
    code, out, _ = run(*words)
    assert code == 0
    assert "| cart " in out
    assert "oct: out of luck" in out
    answer = json.loads(run(*words, "--json")[1])
    assert [row.get("gap_to_best_bound") for row in answer["rows"]] == [0.0, 0.0, None]
    assert [row.get("gap") for row in answer["rows"]] == [None, 0.0, None]
    reached = [row.get("seconds_to_gap", {}).get("1 %") is not None for row in answer["rows"]]
    assert reached == [False, True, False]


def test_frontier_shows_what_samples_held_out_cost_and_chooses(data, run, refused):
    words = ["frontier", data, "--label", "y", "--features", "a,b", "--depth", 2, "--over"]
    found = json.loads(run(*words, "depth", "--folds", 2, "--json")[1])
    assert all(0 <= row["held_out"] <= 1 for row in found["rows"])
    assert found["chosen"]["held_out"] <= min(row["held_out"] for row in found["rows"])
    code, out, _ = run(*words, "penalty", "--folds", 2, "--method", "cart")
    assert code == 0
    assert "held out" in out
    assert out.splitlines()[-1].startswith("chosen: depth")
    assert "--folds chooses a depth and a penalty" in refused(*words, "budget", "--folds", 2)
    assert "folds is 1" in refused(*words, "depth", "--folds", 1)


def test_a_least_weight_of_leaves_counts_the_weights_of_rows_and_classes(data, run, tmp_path):
    out_file = tmp_path / "t.json"
    words = ["--label", "y", "--depth", 2, "--weights", "w", "--leaf-weight", 150, "--out", out_file]
    code, _, err = run("solve", data, *words)
    assert (code, "--leaf-weight is 150 but all samples together weigh 60" in err) == (2, True)
    code, out, err = run("solve", data, *words, "--class-weight", "low=9,high=4")
    assert code == 0, err
    assert "with a weight of 150 or more in each leaf, has" in out
    assert read_tree_file(out_file).settings["leaf_weight"] == 150
    assert run("certify", out_file, data)[0] == 0


def test_the_first_report_within_a_gap_counts_and_the_end_closes_the_rest():
    shown: list[Progress] = []
    times = GapTimes(shown.append)
    for seconds, bound in ((1.0, -math.inf), (2.0, 95.0), (3.0, 96.0)):
        times(Progress(seconds, 100.0, bound, 0))
    times.end(Solution(Leaf(0), 100.0, 97.0, Stop.TIME, 4.0, 1, "exact", "1", 0))
    assert times.reached() == {"10 %": 2.0, "1 %": None, "0 %": None}
    assert times.gaps == [(2.0, 0.05), (3.0, 0.04), (4.0, 0.03)]
    assert len(shown) == 3


def test_a_parquet_file_of_float32_columns_makes_no_float64_table(tmp_path):
    rng = np.random.default_rng(5)
    features = rng.normal(size=(60, 3)).astype(np.float32)
    labels = (features.sum(axis=1) > 0).astype(int)
    frame = pd.DataFrame(features, columns=["a", "b", "c"])
    path = tmp_path / "table.parquet"
    frame.assign(y=labels).to_parquet(path)
    parser = Parser("octmip solve", None)
    options.add_arguments(parser)
    problem = read_problem(parser.parse_args([str(path), "--label", "y", "--depth", "2"])).problem
    assert problem.samples.features.dtype == np.float32
    wide = Problem(features.astype(np.float64), labels, depth=2)
    assert solve(problem, "exact").objective == solve(wide, "exact").objective


@pytest.fixture
def files(data, run, tmp_path):
    """Return a model's file that the command wrote, and the solution that HiGHS by itself wrote of it."""
    model, solution = tmp_path / "m.lp", tmp_path / "m.sol"
    words = ["--label", "y", "--depth", 1, "--method", "flow", "--option", f"write={model}"]
    assert run("solve", data, *words)[0] == 0
    highs = highspy.Highs()
    highs.silent()
    highs.readModel(str(model))
    highs.run()
    highs.writeSolution(str(solution), 0)
    return model, solution


def test_a_solution_comes_back_certified_with_the_stated_bound(data, run, files, tmp_path):
    model, solution = files
    words = ["--label", "y", "--depth", 1, "--read-solution", solution, "--of-model", model]
    out_file = tmp_path / "t.json"
    code, out, err = run("solve", data, *words, "--stated-bound", 1.00001, "--json", "--out", out_file)
    answer = json.loads(out)
    assert (code, err) == (0, "")
    assert (answer["objective"], answer["bound"], answer["is_optimal"]) == (1, 1, True)
    assert read_tree_file(out_file).solution.bound == 1
    assert run("certify", out_file, data)[0] == 0
    code, out, _ = run("solve", data, *words, "--json")
    assert (code, json.loads(out)["bound"]) == (0, 0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--read-solution", "SOL"], "--read-solution is given with --method auto"),
        (["--read-solution", "SOL", "--method", "oct"], "give the method of the model that was solved"),
        (["--read-solution", "SOL", "--method", "flow", "--depth", 2], "which the model lacks"),
        (["--read-solution", "none.sol", "--method", "flow"], "cannot be read"),
        (["--read-solution", "DATA", "--method", "flow"], "gives no column of the model a value"),
        (["--read-solution", "SOL", "--of-model", "SOL"], "does not begin with 'octmip model'"),
        (["--read-solution", "SOL", "--of-model", "MODEL", "--method", "oct"], "is one of flow, but --method is oct"),
        (["--read-solution", "SOL", "--of-model", "MODEL", "--label", "w"], "give the same table and columns"),
        (["--read-solution", "SOL", "--of-model", "MODEL", "--stated-bound", "nan"], "expected a number"),
        (["--read-solution", "SOL", "--of-model", "MODEL", "--stated-bound", 2], "no tree is below 2"),
        (["--stated-bound", 2], "says something of --read-solution"),
    ],
)
def test_what_is_wrong_is_said_in_a_sentence(data, run, files, words, said):
    names = {"SOL": files[1], "MODEL": files[0], "DATA": data}
    given = [names.get(word, word) for word in words]
    label = [] if "--label" in words else ["--label", "y"]
    depth = [] if "--depth" in words else ["--depth", 1]
    code, out, err = run("solve", data, *label, *depth, *given)
    assert (code in (1, 2), out) == (True, "")  # 1: the answer is false, 2: the question is wrong
    assert err.count("\n") == 1
    assert said in err
