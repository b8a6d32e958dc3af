"""octmip solve --read-solution: another solver's answer becomes a certified tree, or is refused in a sentence."""

import json

import highspy
import pytest

from octmip.formats.tree_file import read_tree_file


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
