"""The shells' benchmark cases at sizes that take a second: their lines and their tables."""

from benchmarks.cases import fem_shells
from benchmarks.shells.case import DIAGONALS
from benchmarks.shells.problems import CONVERGING, STRIPS


def test_shell_lines_make_tables():
    roof, hook = "Scordelis-Lo roof", "Raasch's hook"
    problems = {roof: CONVERGING[roof], hook: lambda n: STRIPS[hook](n // 4)}
    lines = [*fem_shells.compared(problems, (4,)), *fem_shells.beams(), fem_shells.panels(2, 8, DIAGONALS[0])]
    table = fem_shells.summary(lines)
    assert f"| {roof} | 4 x 4 | 1.047 | " in table
    assert f"| {hook} | 9 x 1 | 0.906 | " in table
    assert "| rectangular, in plane | 0.993 |" in table
    assert "2 random panels, first diagonal, 8 a side: " in table
