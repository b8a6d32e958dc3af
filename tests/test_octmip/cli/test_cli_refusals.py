"""The octmip command on bad input: one line on standard error, exit code 2, nothing written."""

import pytest

BAD_TABLES = {
    "nothing in a feature": ("a,b,y\n,,u\n,,v\n", "2 of 2 columns cannot be used: 'a' has no value in any row"),
    "a word among numbers": (
        "a,y\n" + "".join(f"{k},u\n" for k in range(30)) + "ten,v\n",
        "'a' holds the word 'ten' among numbers",
    ),
    "a mark of overload among decimal commas": (
        "a;y\n" + "".join(f"{k},5;u\n" for k in range(30)) + ">>>>;v\n",
        "'a' holds the word '>>>>' among numbers",
    ),
    "infinity": ("a,y\n1,u\ninf,v\n", "'a' is inf in row 2; expected finite numbers"),
    "decimal commas and points": ("a;y\n1,5;u\n2.5;v\n", "save the table with points"),
    "not text": ("a,y\n1,\xff\x81\n", "is not UTF-8"),
}


@pytest.mark.parametrize("name", BAD_TABLES)
def test_a_bad_table_ends_in_one_line_and_nothing_written(refused, tmp_path, name):
    text, sentence = BAD_TABLES[name]
    (tmp_path / "bad.csv").write_bytes(text.encode("latin-1"))
    assert sentence in refused(
        "solve", tmp_path / "bad.csv", "--label", "y", "--depth", 1, "--method", "cart", "--out", tmp_path / "t.json"
    )
    assert not (tmp_path / "t.json").exists()


BAD_WORDS = {
    "depth 0": (["--depth", 0], "depth is 0; expected a whole number from 1"),
    "a proof of no depth": (["--proof", "log"], "--proof is given without --depth"),
    "unknown option": (["--depth", 1, "--dept", 2], "unrecognized arguments: --dept"),
    "depth in words": (["--depth", "two"], "--depth is 'two'; expected a whole number; correct it"),
    "unknown method": (["--depth", 1, "--method", "magic"], "invalid choice: 'magic'"),
    "a start of HiGHS without HiGHS": (
        ["--depth", 1, "--option", "start=search"],
        "method 'exact' takes no option 'start'; expected some of: checkpoint, cluster, every, proof;",
    ),
    "option without a value": (["--depth", 1, "--option", "restarts"], "--option is 'restarts'; expected NAME=VALUE"),
    "file as an option": (["--depth", 1, "--option", "proof=iris.csv"], "--option is 'proof=iris.csv'; expected NAME="),
    "no threads": (["--depth", 1, "--threads", 0], "--threads is 0"),
    "label among the features": (["--depth", 1, "--features", "a,y"], "--features names 'y'"),
    "feature named twice": (["--depth", 1, "--features", "a,a"], "--features names 'a' twice"),
    "unknown feature": (
        ["--depth", 1, "--features", "a,q"],
        "no column 'q', which --features names; expected some of its 4 columns",
    ),
    "text as weight": (["--depth", 1, "--features", "a", "--weights", "y"], "a weight holds numbers only"),
    "unknown weights": (["--depth", 1, "--weights", "q"], "no column 'q'"),
    "incumbent missing": (["--depth", 1, "--incumbent", "none.json"], "none.json cannot be read"),
    "nowhere to write": (["--depth", 1, "--out", "/none/such/t.json"], "there is no folder /none/such"),
    "a folder to write": (["--depth", 1, "--out", "/"], "is a folder"),
}


@pytest.mark.parametrize("name", BAD_WORDS)
def test_a_bad_command_line_ends_in_one_line(data, refused, name):
    words, sentence = BAD_WORDS[name]
    words = words if "--features" in words else [*words, "--features", "a,b"]
    assert sentence in refused("solve", data, "--label", "y", *words)


@pytest.mark.parametrize("place", [("certify",), ("predict",), ("report",), ("solve", "--incumbent")])
def test_a_table_in_the_place_of_a_tree_file_is_named_as_what_it_is(data, refused, place):
    solve = (data, "--label", "y", "--depth", 1)
    err = refused(place[0], *(solve if place[1:] else ()), *place[1:], data, *(() if place[1:] else (data,)))
    sentence = "begins with 'a,b,w,y'; expected JSON: a tree file, as octmip solve --out writes it; give that file"
    assert err == f"octmip {place[0]}: {data} {sentence}\n"
