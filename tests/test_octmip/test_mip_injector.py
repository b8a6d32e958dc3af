"""Trees handed to HiGHS while it runs."""

import pytest

from octmip import Leaf, Limits, Split, certify, solve
from octmip.trees.methods.options import MipOptions
from octmip.trees.mip.highs.injector import IncumbentInjector
from octmip.trees.mip.oct import solve_oct
from tests.test_octmip.test_mip import stop_at_six, uci


def test_an_injector_hands_trees_to_highs_while_it_runs():
    best = Split(3, 0.8, Leaf(0), Split(3, 1.75, Leaf(1), Leaf(2)))
    with IncumbentInjector(lambda turn: best, most_turns=1) as injector:
        poor = Split(0, 5.5, Leaf(0), Leaf(2))
        limits = Limits(seconds=120)
        solution = solve_oct(uci("iris", depth=2), limits=limits, incumbent=poor, inject=injector, progress=stop_at_six)
    assert solution.objective == 6


def test_what_the_source_of_an_injector_raises_comes_out():
    def source(turn):
        raise ValueError("the source is dry")

    with IncumbentInjector(source) as injector, pytest.raises(ValueError, match="dry"):
        solve_oct(uci("iris", depth=2), limits=Limits(seconds=20), inject=injector)


def test_the_exact_core_assists_with_its_bound():
    problem = uci("wine", depth=2)
    solution = solve(problem, "oct", Limits(seconds=60), options=MipOptions(assist=("exact",)))
    certify(problem, solution)
    assert solution.is_optimal
    assert solution.objective == 6 == solution.details["lower_bound_given"]
    assert solution.solver == "oct"
    assert solution.n_nodes <= 1


def test_the_search_assists_while_highs_runs(monkeypatch):
    turns = []
    monkeypatch.setattr("octmip.trees.methods.search.local_search", _counted(turns))
    solution = solve(
        uci("iris", depth=2),
        "oct",
        Limits(seconds=120),
        incumbent=Split(0, 5.5, Leaf(0), Leaf(2)),
        progress=stop_at_six,
        options=MipOptions(assist=("search",)),
    )
    assert solution.objective == 6
    assert len(turns) >= 1


def _counted(turns):
    from octmip.trees.methods.search import local_search

    def search(problem, **options):
        turns.append(options["seed"])
        return local_search(problem, **options)

    return search
