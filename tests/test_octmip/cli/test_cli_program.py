"""The octmip command as a program: help, progress, streams that close, Ctrl-C."""

import subprocess
import sys

import pytest

from octmip.cli import COMMANDS, main
from octmip.cli.answer import ProgressLine
from octmip.solution import Progress


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
