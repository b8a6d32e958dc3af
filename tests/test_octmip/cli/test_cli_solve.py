"""octmip solve, compare and frontier: what they print and what they write."""

import json

from octmip import Solution, Stop
from octmip.errors import SolverError
from octmip.formats.tree_file import read_tree_file
from octmip.trees import solver
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


def test_an_incumbent_is_taken_up(data, run, tree):
    words = ["solve", data, "--label", "y", "--depth", 1, "--method", "search", "--incumbent", tree]
    assert "if a <= 11.5" in run(*words, "--features", "b,a")[1]
    code, _, err = run(*words, "--features", "b")
    assert code == 2
    assert "names the feature 'a', which is not among" in err
    code, _, err = run(*words, "--features", "a,b", "--leaf-size", 15)
    assert code == 2
    assert "incumbent is no tree of this problem: leaf 0" in err


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


def test_frontier_shows_what_samples_held_out_cost_and_chooses(data, run):
    words = ["frontier", data, "--label", "y", "--features", "a,b", "--depth", 2, "--over"]
    found = json.loads(run(*words, "depth", "--folds", 2, "--json")[1])
    assert all(0 <= row["held_out"] <= 1 for row in found["rows"])
    assert found["chosen"]["held_out"] <= min(row["held_out"] for row in found["rows"])
    code, out, _ = run(*words, "penalty", "--folds", 2, "--method", "cart")
    assert code == 0
    assert "held out" in out
    assert out.splitlines()[-1].startswith("chosen: depth")
    code, _, err = run(*words, "budget", "--folds", 2)
    assert code == 2
    assert "--folds chooses a depth and a penalty" in err
    code, _, err = run(*words, "depth", "--folds", 1)
    assert code == 2
    assert "folds is 1" in err


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
