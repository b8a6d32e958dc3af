"""The octmip command on bad input: one line on standard error, exit code 2, nothing written."""

import pandas as pd
import pytest

BAD_TABLES = {
    "no label column": ("a,z\n1,2\n", "no column 'y'"),
    "nothing in a feature": ("a,b,y\n,1,u\n,2,v\n", "1 of 2 columns cannot be used: 'a' has no value in any row"),
    "empty label": ("a,y\n1,u\n2,\n", "line 3, column 'y': the label is empty"),
    "one class": ("a,y\n1,u\n2,u\n", "one class only"),
    "a word among numbers": (
        "a,y\n" + "".join(f"{k},u\n" for k in range(30)) + "ten,v\n",
        "'a' holds the word 'ten' among numbers",
    ),
    "infinity": ("a,y\n1,u\ninf,v\n", "'a' is inf in row 2; expected finite numbers"),
    "empty file": ("", "is empty"),
    "header only": ("a,y\n", "0 rows"),
    "column named twice": ("a,a,y\n1,1,u\n", "column 'a' 2 times"),
    "ragged": ("a,y\n1,u\n2,v,3\n", "Expected 2 fields in line 3"),
    "label only": ("y\nu\nv\n", "no column beside 'y'; expected at least one"),
    "decimal commas and points": ("a;y\n1,5;u\n2.5;v\n", "save the table with points"),
    "not text": ("a,y\n1,\xff\x81\n", "is not UTF-8"),
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
    "a proof of no depth": (["--proof", "log"], "--proof is given without --depth"),
    "unknown option": (["--depth", 1, "--dept", 2], "unrecognized arguments: --dept"),
    "unknown method": (["--depth", 1, "--method", "magic"], "invalid choice: 'magic'"),
    "negative budget": (["--depth", 1, "--budget", -1], "sensor_budget is -1.0"),
    "leaf size beyond the samples": (["--depth", 1, "--leaf-size", 99], "leaf_size is 99"),
    "negative penalty": (["--depth", 1, "--leaf-penalty", -0.5], "leaf_penalty is -0.5"),
    "negative seconds": (["--depth", 1, "--seconds", -3], "limit seconds is -3"),
    "NaN seconds": (["--depth", 1, "--seconds", "nan"], "limit seconds is nan"),
    "assistance without HiGHS": (
        ["--depth", 1, "--option", "assist=exact"],
        "method 'exact' takes no option 'assist'; expected some of: checkpoint, cluster, every, proof, solves;",
    ),
    "unknown assistant": (
        ["--depth", 1, "--method", "oct", "--option", "assist=luck"],
        "assist is ('luck',); expected a tuple of some of exact, search",
    ),
    "option without a value": (["--depth", 1, "--option", "restarts"], "--option is 'restarts'; expected NAME=VALUE"),
    "file as an option": (["--depth", 1, "--option", "proof=iris.csv"], "--option is 'proof=iris.csv'; expected NAME="),
    "restarts of text": (
        ["--depth", 1, "--method", "search", "--option", "restarts=many"],
        "restarts is 'many'; expected a whole number, 1 or more",
    ),
    "no threads": (["--depth", 1, "--threads", 0], "--threads is 0"),
    "negative seed": (["--depth", 1, "--seed", -1], "--seed is -1"),
    "split size on axis splits": (["--depth", 1, "--split", "axis", "--split-size", 2], "split is 'axis'"),
    "label among the features": (["--depth", 1, "--features", "a,y"], "--features names 'y'"),
    "feature named twice": (["--depth", 1, "--features", "a,a"], "--features names 'a' twice"),
    "unknown feature": (
        ["--depth", 1, "--features", "a,q"],
        "no column 'q', which --features names; expected some of its 4 columns",
    ),
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


@pytest.mark.parametrize("place", [("certify",), ("predict",), ("report",), ("solve", "--incumbent")])
def test_a_table_in_the_place_of_a_tree_file_is_named_as_what_it_is(data, run, place):
    solve = (data, "--label", "y", "--depth", 1)
    code, out, err = run(place[0], *(solve if place[1:] else ()), *place[1:], data, *(() if place[1:] else (data,)))
    assert (code, out) == (2, "")
    sentence = "begins with 'a,b,w,y'; expected JSON: a tree file, as octmip solve --out writes it; give that file"
    assert err == f"octmip {place[0]}: {data} {sentence}\n"
