"""Two twins that are no wing: each in under 20 lines of its page, and what is drawn blindly is named."""

import re

import pytest

from benchmarks.cases.gap import others

MOST_LINES = 20


@pytest.mark.parametrize("name", others.LOADS)
def test_a_twin_takes_under_twenty_lines_of_its_page(name):
    code = re.search(r"```python\n(.*?)```", (others.PAGES / f"{name}.md").read_text(), re.DOTALL)[1]
    assert len([line for line in code.splitlines() if line.strip()]) < MOST_LINES


@pytest.mark.parametrize("name", others.LOADS)
def test_what_is_drawn_blindly_is_among_what_is_named(name):
    twin = others.twin_of(name)
    lines = [others.drawn(name, twin, seed) for seed in (2, 3)]
    assert all(line["is_among"] for line in lines), lines  # a leak of the rod looks like an error of its power
    n_right = sum(line["is_right"] for line in lines)
    assert f"| {name} | 2 | {n_right} |" in others.summary(lines)
