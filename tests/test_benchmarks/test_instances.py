"""The instances: the command writes files that HiGHS reads back, and the table says no more than is known."""

import io
import json
import re
from pathlib import Path

import highspy
import pytest

from benchmarks import as_csv
from benchmarks.instances.__main__ import main
from benchmarks.instances.catalogue import INSTANCES
from benchmarks.instances.known import known, markdown, tree_key

KNOWN = Path(__file__).parents[2] / "docs/results/data/instances/known.csv"


def test_a_file_read_back_has_the_size_in_the_table_and_the_optimum(tmp_path):
    assert main(["--out", str(tmp_path), "--only", "^flow-iris-d1$"]) == 0
    reader = highspy.Highs()
    reader.setOptionValue("output_flag", False)
    reader.readModel(str(tmp_path / "flow-iris-d1.mps"))
    sizes = json.loads((tmp_path / "sizes.json").read_text())
    assert sizes == {"flow-iris-d1": known()["sizes"]["flow-iris-d1"]}
    assert (reader.getNumRow(), reader.getNumCol()) == (
        sizes["flow-iris-d1"]["rows"],
        sizes["flow-iris-d1"]["columns"],
    )
    reader.run()
    assert reader.getInfo().objective_function_value == pytest.approx(known()["trees"]["iris-d1"]["errors"])


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--out", "FILE"], "FILE is a file; expected a folder"),
        (["--out", "FILE/new", "--only", "^flow-iris-d1$"], "FILE/new cannot be made .*choose another place"),
        (["--out", "new", "--only", "["], r"--only '\[' is no regular expression"),
        (["--out", "new", "--only", "no such"], "--only 'no such' names none of the"),
    ],
)
def test_words_that_write_nothing_are_refused_in_one_sentence(words, told, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "FILE").touch()
    with pytest.raises(SystemExit):
        main(words)
    assert re.search(told, capsys.readouterr().err)


def test_every_instance_has_a_size_and_a_best_tree_that_its_bound_does_not_exceed():
    content = known()
    assert set(content["sizes"]) == {instance.name for instance in INSTANCES}
    assert set(content["trees"]) == {tree_key(instance) for instance in INSTANCES}
    assert all(best["bound"] <= best["errors"] for best in content["trees"].values())


def test_a_run_that_contradicts_a_known_tree_is_refused(monkeypatch, tmp_path):
    content = known()
    content["runs"].append(content["runs"][0] | {"bound": 51})
    wrong = tmp_path / "known.json"
    wrong.write_text(json.dumps(content))
    monkeypatch.setattr("benchmarks.instances.known.FILE", wrong)
    with pytest.raises(ValueError, match="above a known tree"):
        known()


def test_the_data_file_is_the_table_of_the_command(capsys, monkeypatch):
    assert main(["--table"]) == 0
    printed = capsys.readouterr().out
    assert printed == markdown(known()) + "\n"
    monkeypatch.setattr("sys.stdin", io.StringIO(printed))
    as_csv.main([])
    assert capsys.readouterr().out == KNOWN.read_text()
