"""The octmip command: what it prints, what it writes, and that bad input ends in one line and exit code 2."""

import json
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest

from benchmarks.oracles.proof_log import proof_log
from octmip import Problem, Solution, Stop, solver
from octmip.cli import COMMANDS, main
from octmip.cli.answer import ProgressLine
from octmip.formats.tree_file import read_tree_file
from octmip.solution import Progress


@pytest.fixture
def data(tmp_path):
    """Return a table with features a and b, label y and weight w; a splits y up to one sample."""
    rng = np.random.default_rng(0)
    a, b = np.arange(30.0), rng.random(30).round(3)
    frame = pd.DataFrame({"a": a, "b": b, "w": 1 + np.arange(30) % 3, "y": np.where(a < 12, "low", "high")})
    frame.loc[20, "y"] = "low"
    frame.to_csv(tmp_path / "data.csv", index=False)
    return tmp_path / "data.csv"


@pytest.fixture
def run(capsys):
    """Return a function that runs the command and returns exit code, standard output and standard error."""

    def call(*words):
        code = main([str(word) for word in words])
        out, err = capsys.readouterr()
        return code, out, err

    return call


@pytest.fixture
def tree(data, run, tmp_path):
    """Return a tree file of the table."""
    path = tmp_path / "tree.json"
    assert (
        run("solve", data, "--label", "y", "--depth", 1, "--method", "cart", "--features", "a,b", "--out", path)[0] == 0
    )
    return path


def test_solve_says_objective_tree_and_where_it_is_written(data, run, tmp_path):
    out_file = tmp_path / "t.json"
    code, out, err = run("solve", data, "--label", "y", "--depth", 1, "--method", "cart", "--out", out_file)
    assert code == 0
    assert err == ""
    assert "1 of 30 samples wrong" in out
    assert "if a <= 11.5" in out
    assert str(out_file) in out
    assert read_tree_file(out_file).label_column == "y"


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
    (tmp_path / "groups.txt").write_text("b\n\na, b\n")
    words += ["--allowed-splits", tmp_path / "groups.txt"]
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
    assert settings["costs"] == [[0, 2], [5, 0]]
    assert settings["leaf_penalty"] == 0.5
    assert settings["depth"] == 2
    assert settings["allowed_splits"] == [[0], [0, 1]]
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


def test_certify_accepts_what_solve_wrote(data, run, tree):
    code, out, err = run("certify", tree, data)
    assert code == 0
    assert out.startswith("certified")
    assert err == ""
    answer = json.loads(run("certify", tree, data, "--label", "y", "--json")[1])
    assert answer["is_certified"]
    assert answer["errors"] == 1
    assert answer["bound"] is None


def broken(tree, change):
    content = json.loads(tree.read_text())
    change(content)
    tree.write_text(json.dumps(content))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda file: file["tree"].update(threshold=3.5), "claims objective 1.0 but the tree's own"),
        (lambda file: file["tree"].update(left={"label": "high"}), "claims objective 1.0 but the tree's own"),
        (lambda file: file["solution"].update(objective=0.0), "claims objective 0.0 but the tree's own"),
        (lambda file: file["solution"].update(bound=2.0), "claims that no tree is below 2.0"),
        (lambda file: file["solution"].update(stop="optimal"), "says optimal but its bound"),
        (lambda file: file["problem"].update(leaf_size=15), "leaf_size is 15"),
        (lambda file: file["training"].update(sha256="0" * 64), "is not the table"),
    ],
)
def test_certify_refutes_a_file_changed_by_hand(data, run, tree, change, sentence):
    broken(tree, change)
    code, out, err = run("certify", tree, data)
    assert code == 1
    assert out == ""
    assert sentence in err
    assert err.count("\n") == 1


def test_certify_refutes_other_data(data, run, tree):
    frame = pd.read_csv(data)
    frame.loc[3, "a"] += 1e-9
    frame.to_csv(data, index=False)
    code, _, err = run("certify", tree, data)
    assert code == 1
    assert "is not the table" in err


def test_certify_checks_a_proof_log_of_the_tree(data, run, tree, tmp_path):
    frame = pd.read_csv(data)
    names = ("a", "b")
    problem = Problem(frame[list(names)].to_numpy(), frame["y"].to_numpy(), depth=1, feature_names=names)
    broken(tree, lambda file: file["solution"].update(bound=1.0, stop="optimal"))
    log = tmp_path / "proof.log"
    log.write_text(proof_log(problem))
    code, out, err = run("certify", tree, data, "--proof", log)
    assert code == 0 and "proof: no tree costs less than 1; " in out, err
    assert json.loads(run("certify", tree, data, "--proof", log, "--json")[1])["proof"]["bound"] == 1
    log.write_text(proof_log(problem)[:-20])
    code, out, err = run("certify", tree, data, "--proof", log)
    assert code == 1
    assert out == ""
    assert "proof is refused" in err
    assert err.count("\n") == 1
    code, _, err = run("certify", tree, data, "--proof", tmp_path / "none.log")
    assert code == 2
    assert "none.log cannot be read" in err


def test_predict_writes_one_line_for_each_row(data, run, tree, tmp_path):
    code, out, err = run("predict", tree, data)
    assert code == 0
    assert out.splitlines() == ["prediction"] + ["low"] * 12 + ["high"] * 18
    assert err == ""
    code, out, err = run("predict", tree, data, "--label", "y", "--out", tmp_path / "p.csv", "--probabilities")
    assert code == 0
    assert out == ""
    assert "1 of 30 samples wrong" in err
    shares = pd.read_csv(tmp_path / "p.csv")
    assert list(shares.columns) == ["prediction", "share of high", "share of low"]
    assert shares.iloc[-1, 1] == pytest.approx(17 / 18)
    answer = json.loads(run("predict", tree, data, "--label", "y", "--json")[1])
    assert answer["errors"] == 1
    assert len(answer["predictions"]) == 30


def test_predict_needs_only_the_features_that_the_tree_reads(run, tree, tmp_path):
    (tmp_path / "new.csv").write_text("a\n3\n20\n")
    assert run("predict", tree, tmp_path / "new.csv")[1].split() == ["prediction", "low", "high"]
    (tmp_path / "new.csv").write_text("b\n3\n")
    code, _, err = run("predict", tree, tmp_path / "new.csv")
    assert code == 2
    assert "no column 'a'" in err


def test_compare_shows_every_method_and_the_gap_to_the_best_bound(data, run, monkeypatch):
    def proves(problem, **_):
        leaf = solver.REGISTRY["cart"].load()(
            problem, limits=solver.Limits(), incumbent=None, seed=0, n_jobs=1, progress=None
        )
        return Solution(leaf.tree, leaf.objective, 1.0, Stop.OPTIMAL, 0.0, 1, "exact", "1", 0)

    def fails(problem, **_):
        raise solver.SolverError("out of luck")

    load = solver.Registration.load
    replaced = {"octmip.methods.exact": proves, "octmip.mip.oct": fails}
    monkeypatch.setattr(solver.Registration, "load", lambda self: replaced.get(self.module) or load(self))
    words = ["compare", data, "--label", "y", "--depth", 1, "--features", "a", "--methods", "cart,exact,oct"]
    code, out, _ = run(*words)
    assert code == 0
    assert "| cart " in out
    assert "oct: out of luck" in out
    answer = json.loads(run(*words, "--json")[1])
    assert [row.get("gap_to_best_bound") for row in answer["rows"]] == [0.0, 0.0, None]
    assert [row.get("gap") for row in answer["rows"]] == [None, 0.0, None]


@pytest.mark.parametrize("kind", ["html", "md", "dot", "txt", "svg", "png", "pdf"])
def test_report_writes_every_kind(run, tree, tmp_path, kind):
    assert run("report", tree, "--out", tmp_path / f"r.{kind}")[0] == 0
    assert (tmp_path / f"r.{kind}").stat().st_size > 100


def test_report_prints_words(run, tree):
    assert "if a <= 11.5" in run("report", tree)[1]


BAD_TABLES = {
    "no label column": ("a,z\n1,2\n", "no column 'y'"),
    "NaN in a feature": ("a,y\n1,u\n,v\n", "line 3, column 'a': the feature is empty"),
    "empty label": ("a,y\n1,u\n2,\n", "line 3, column 'y': the label is empty"),
    "one class": ("a,y\n1,u\n2,u\n", "one class only"),
    "text in a feature": ("a,y\n1,u\nten,v\n", "line 3, column 'a': 'ten' is no number"),
    "infinity": ("a,y\n1,u\ninf,v\n", "not finite"),
    "empty file": ("", "is empty"),
    "header only": ("a,y\n", "0 rows"),
    "column named twice": ("a,a,y\n1,1,u\n", "column 'a' 2 times"),
    "ragged": ("a,y\n1,u\n2,v,3\n", "Expected 2 fields in line 3"),
    "label only": ("y\nu\nv\n", "no column beside 'y'"),
    "semicolons": ("a;y\n1;u\n", "separate columns by commas"),
    "not text": ("a,y\n1,\xff\n", "is not UTF-8"),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_a_bad_table_ends_in_one_line_and_nothing_written(run, tmp_path, name):
    text, sentence = BAD_TABLES[name]
    (tmp_path / "bad.csv").write_bytes(text.encode("latin-1"))
    code, out, err = run(
        "solve", tmp_path / "bad.csv", "--label", "y", "--depth", 1, "--method", "cart", "--out", tmp_path / "t.json"
    )
    assert code == 2
    assert out == ""
    assert sentence in err
    assert err.count("\n") == 1
    assert not (tmp_path / "t.json").exists()


BAD_WORDS = {
    "depth 0": (["--depth", 0], "depth is 0; expected a whole number from 1"),
    "depth text": (["--depth", "two"], "--depth: invalid int value: 'two'"),
    "no depth": ([], "required: --depth"),
    "unknown option": (["--depth", 1, "--dept", 2], "unrecognized arguments: --dept"),
    "unknown method": (["--depth", 1, "--method", "magic"], "invalid choice: 'magic'"),
    "negative budget": (["--depth", 1, "--budget", -1], "sensor_budget is -1.0"),
    "leaf size beyond the samples": (["--depth", 1, "--leaf-size", 99], "leaf_size is 99"),
    "negative penalty": (["--depth", 1, "--leaf-penalty", -0.5], "leaf_penalty is -0.5"),
    "negative seconds": (["--depth", 1, "--seconds", -3], "limit seconds is -3"),
    "NaN seconds": (["--depth", 1, "--seconds", "nan"], "limit seconds is nan"),
    "assistance without HiGHS": (["--depth", 1, "--assist", "exact"], "needs a mixed-integer method, not 'auto'"),
    "unknown assistant": (["--depth", 1, "--method", "oct", "--assist", "luck"], "invalid choice: 'luck'"),
    "no threads": (["--depth", 1, "--threads", 0], "--threads is 0"),
    "negative seed": (["--depth", 1, "--seed", -1], "--seed is -1"),
    "split size on axis splits": (["--depth", 1, "--split", "axis", "--split-size", 2], "split is 'axis'"),
    "label among the features": (["--depth", 1, "--features", "a,y"], "--features names 'y'"),
    "feature named twice": (["--depth", 1, "--features", "a,a"], "twice a feature"),
    "unknown feature": (["--depth", 1, "--features", "a,q"], "no column 'q'; expected the feature"),
    "text as weight": (["--depth", 1, "--features", "a", "--weights", "y"], "a weight holds numbers only"),
    "unknown weights": (["--depth", 1, "--weights", "q"], "no column 'q'"),
    "costs missing": (["--depth", 1, "--costs", "none.csv"], "none.csv cannot be read"),
    "sensor costs missing": (["--depth", 1, "--sensor-cost", "none.csv"], "none.csv cannot be read"),
    "incumbent missing": (["--depth", 1, "--incumbent", "none.json"], "none.json cannot be read"),
    "nowhere to write": (["--depth", 1, "--out", "/none/such/t.json"], "there is no folder /none/such"),
    "a folder to write": (["--depth", 1, "--out", "/"], "is a folder"),
}


@pytest.mark.parametrize("name", BAD_WORDS)
def test_a_bad_command_line_ends_in_one_line(data, run, name):
    words, sentence = BAD_WORDS[name]
    words = words if "--features" in words else [*words, "--features", "a,b"]
    code, out, err = run("solve", data, "--label", "y", *words)
    assert code == 2
    assert out == ""
    assert sentence in err
    assert err.count("\n") == 1


def test_negative_weights_are_refused(data, run):
    frame = pd.read_csv(data)
    frame.loc[4, "w"] = -2
    frame.to_csv(data, index=False)
    code, _, err = run("solve", data, "--label", "y", "--depth", 1, "--weights", "w")
    assert code == 2
    assert "weights[4] is -2.0" in err


@pytest.mark.parametrize("command", ["certify", "predict", "report"])
@pytest.mark.parametrize("content", ["", "{", "[]", '{"format": "pmml"}', '{"format": "octmip-tree", "version": 2}'])
def test_a_bad_tree_file_ends_in_one_line(data, run, tmp_path, command, content):
    (tmp_path / "bad.json").write_text(content)
    words = [] if command == "report" else [data]
    code, out, err = run(command, tmp_path / "bad.json", *words)
    assert code == 2
    assert out == ""
    assert "bad.json" in err
    assert err.count("\n") == 1


def test_labels_unseen_at_training_are_refused(data, run, tree):
    data.write_text(data.read_text().replace("low", "lower"))
    for command in (["certify", tree, data], ["predict", tree, data, "--label", "y"]):
        code, _, err = run(*command)
        assert code == 2
        assert "line 2, column 'y': label 'lower' was not seen at training" in err


def test_an_unknown_command_hints_at_the_near_one(run):
    assert "did you mean solve?" in run("solv")[2]
    assert "expected one of solve" in run("xyz")[2]
    assert run()[0] == 2


def test_help_names_every_command(run):
    code, out, _ = run("--help")
    assert code == 0
    assert all(name in out for name in COMMANDS)
    assert run("--version")[1].startswith("octmip ")
    for name in COMMANDS:
        with pytest.raises(SystemExit) as leaving:
            main([name, "--help"])
        assert leaving.value.code == 0


def test_help_does_not_wait_for_heavy_packages():
    code = "import sys; from octmip.cli import main; main(['--help']); print(*sys.modules, sep='\\n')"
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "octmip.cli" in out
    assert not {"pandas", "sklearn", "matplotlib", "pyomo", "scipy"} & set(out.splitlines())


def test_progress_shows_on_a_terminal_only(capsys, monkeypatch):
    for is_terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda shown=is_terminal: shown)
        with ProgressLine() as line:
            line(Progress(1.0, 10.0, 5.0, 100))
            line(Progress(1.01, 9.0, 5.0, 101))
        err = capsys.readouterr().err
        assert ("objective 10  bound 5  gap 50 %  nodes 100" in err) == is_terminal
        assert "objective 9" not in err  # not again within a tenth of a second


def test_standard_output_that_cannot_be_written_ends_in_one_line(run, tree, monkeypatch):
    def full(arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("octmip.cli.report.run", full)
    code, _, err = run("report", tree)
    assert code == 1
    assert err == "octmip: standard output cannot be written (No space left on device)\n"


def test_ctrl_c_outside_a_solver_ends_with_130(run, monkeypatch):
    def interrupted(arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("octmip.cli.report.run", interrupted)
    code, _, err = run("report", "t.json")
    assert code == 130
    assert err == "octmip: interrupted\n"


def test_frontier_shows_one_row_for_each_value(data, run, tmp_path):
    words = ["frontier", data, "--label", "y", "--features", "a,b", "--depth", 3, "--over", "depth"]
    code, out, err = run(*words, "--out", tmp_path / "f.png")
    assert code == 0
    assert err == ""
    assert len(out.splitlines()) == 5
    assert (tmp_path / "f.png").stat().st_size > 1000
    rows = json.loads(run(*words, "--json", "--values", "1,2")[1])["rows"]
    assert [row["depth"] for row in rows] == [1, 2]
    code, _, err = run(*words, "--values", "1,x")
    assert code == 2
    assert "--values is '1,x'" in err


def test_frontier_shows_what_samples_held_out_cost_and_chooses(data, run):
    words = ["frontier", data, "--label", "y", "--features", "a,b", "--depth", 2, "--over"]
    found = json.loads(run(*words, "depth", "--folds", 2, "--json")[1])
    assert all(0 <= row["held_out"] <= 1 for row in found["rows"])
    assert found["chosen"]["held_out"] <= min(row["held_out"] for row in found["rows"])
    code, out, _ = run(*words, "penalty", "--folds", 2, "--method", "cart")
    assert code == 0
    assert "held_out" in out
    assert out.splitlines()[-1].startswith("chosen: depth")
    code, _, err = run(*words, "budget", "--folds", 2)
    assert code == 2
    assert "--folds chooses a depth and a penalty" in err
    code, _, err = run(*words, "depth", "--folds", 1)
    assert code == 2
    assert "folds is 1" in err
