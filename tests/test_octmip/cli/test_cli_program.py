"""The octmip command as a program: help, doctor, progress, streams that close, Ctrl-C."""

import json
import subprocess
import sys

import pytest

from octmip.interfaces.cli import doctor, main
from octmip.interfaces.cli.answer import ProgressLine
from octmip.interfaces.cli.options import frontier as options
from octmip.interfaces.cli.program import COMMANDS
from octmip.trees.answer.solution import Progress
from octmip.trees.methods.options import all_options
from octmip.trees.tradeoff.frontier import OVERS


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
        assert main([name, "--help"]) == 0


@pytest.mark.parametrize("word", ["--help", "--no-such-option"])
def test_help_and_errors_of_arguments_wait_for_no_heavy_package(word):
    asked = [[word], *([name, word] for name in COMMANDS)]
    code = (
        "import sys; from octmip.interfaces.cli import main\n"
        f"for words in {asked}: main(words)\n"
        "print(*sys.modules, sep='\\n')"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "octmip.interfaces.cli.options.solve" in out.splitlines()
    heavy = {"pandas", "sklearn", "matplotlib", "pyomo", "scipy", "joblib", "highspy", "octmip.trees.tradeoff"}
    assert not heavy & set(out.splitlines())


def test_a_plain_solve_waits_for_no_package_that_it_does_not_need(tmp_path):
    (tmp_path / "t.csv").write_text("a,b,class\n" + "".join(f"{i},{i * i % 7},{i > 4}\n" for i in range(12)))
    code = (
        "import sys; from octmip.interfaces.cli import main\nmain(sys.argv[1:])\n"
        "print({'sklearn', 'scipy', 'joblib'} & {*sys.modules})"
    )
    words = ["solve", str(tmp_path / "t.csv"), "--label", "class", "--depth", "2"]
    out = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, check=True).stdout
    assert "proven optimal" in out
    assert out.splitlines()[-1] == "set()"


def test_the_settings_of_a_frontier_are_those_of_the_library():
    assert options.OVERS == OVERS


def test_progress_shows_on_a_terminal_only(capsys, monkeypatch):
    for is_terminal in (False, True):
        monkeypatch.setattr(sys.stderr, "isatty", lambda shown=is_terminal: shown)
        with ProgressLine() as line:
            line(Progress(1.0, 10.0, 5.0, 100))
            line(Progress(1.01, 9.0, 5.0, 101))
        err = capsys.readouterr().err
        assert ("objective 10  bound 5  gap 50 %  nodes 100" in err) == is_terminal
        assert "objective 9" not in err  # not again within a tenth of a second


@pytest.mark.parametrize("name", ["solve", "certify", "predict", "compare", "frontier", "doctor"])
def test_every_help_ends_with_examples_that_the_parser_takes(capsys, name):
    assert main([name, "--help"]) == 0
    out = capsys.readouterr().out
    examples = out.partition("examples:\n")[2].strip().splitlines()
    assert examples
    assert all(f"octmip {name}" in example for example in examples)
    assert out.splitlines()[0].startswith(f"usage: octmip {name}")
    assert len(out.splitlines()[0]) < 100


def test_doctor_finds_this_installation_in_order(run):
    code, out, err = run("doctor")
    assert (code, err) == (0, "")
    assert "solved a problem of 4 samples and certified it" in out
    assert out.splitlines()[-1] == "This installation works."
    found = json.loads(run("doctor", "--json")[1])
    assert found["is_healthy"]
    assert found["unknown"]["search of numbers"][0] == "takes_missing"
    assert {"python", "numpy", "HiGHS", "native core", "octmip[plot]"} <= {line["name"] for line in found["findings"]}


def test_doctor_names_what_is_absent_and_what_is_broken(run, monkeypatch):
    monkeypatch.setattr(doctor.importlib.util, "find_spec", lambda name: None if name == "pyarrow" else object())
    code, out, _ = run("doctor")
    assert code == 0
    assert "tables in Parquet files; without pyarrow it is not there; install octmip[parquet]" in out

    def broken(*_, **__):
        raise OSError("no such symbol")

    monkeypatch.setattr("octmip.trees.solver.solve", broken)
    code, out, _ = run("doctor")
    assert code == 1
    assert "FAULT   native core" in out
    assert "does not work (OSError: no such symbol)" in out
    assert out.splitlines()[-1].startswith("This installation does not work")


@pytest.mark.long("pandas")
@pytest.mark.parametrize("module", ["octmip.trees._native", "pandas"])
def test_doctor_works_where_the_installation_does_not(module):
    code = f"import sys; sys.modules['{module}'] = None; from octmip.interfaces.cli import main\n"
    code += "sys.exit(main(['doctor']))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr == ""
    assert "FAULT" in done.stdout
    assert module in done.stdout


LONG = ("solve", "compare", "near-optimal", "sensors", "frontier")
"""Commands with more options than a screen takes."""


def shown_options(text):
    """Return the options that a help describes, each by its name."""
    return {line.split()[0].rstrip(",") for line in text.splitlines() if line.startswith("  -")}


@pytest.mark.parametrize("command", LONG)
def test_the_rest_of_a_long_help_is_shown_when_asked(run, command):
    usual, whole = (shown_options(run(command, option)[1]) for option in ("--help", "--help-all"))
    assert usual < whole
    assert len(usual) <= 20


def test_doctor_and_the_classes_name_the_same_options(run):
    methods = json.loads(run("doctor", "--json")[1])["methods"]
    assert {name for options in methods.values() for name in options} == set(all_options())
    assert "cluster" not in methods["cart"]


def test_an_option_of_the_methods_goes_to_those_compared_that_take_it(data, run, refused):
    words = ["compare", data, "--label", "y", "--depth", 1, "--features", "a", "--methods", "cart,search"]
    rows = json.loads(run(*words, "--option", "restarts=2", "--json")[1])["rows"]
    assert ["error" in row for row in rows] == [False, False]
    said = refused(*words, "--option", "start=search")
    assert "--option names 'start'; expected what one of the methods takes: cluster, perturbations, restarts" in said
