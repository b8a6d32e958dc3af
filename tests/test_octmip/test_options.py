"""Options: each is checked by its own class, read from words, and refused where a method does not take it."""

from dataclasses import fields

import numpy as np
import pytest

from octmip import ExactOptions, MipOptions, Options, Problem, SearchOptions, SquaredError, solve
from octmip.errors import ProblemError
from octmip.trees.methods.options import METHODS, OPTIONS
from octmip.trees.runs.registry import REGISTRY
from octmip.trees.solver import options_for

CLASSES = (Options, SearchOptions, ExactOptions, MipOptions)
WRONG = [
    (SearchOptions, {"restarts": 0}, "restarts is 0; expected a whole number, 1 or more; give one, or leave restarts"),
    (SearchOptions, {"restarts": True}, "restarts is True"),
    (SearchOptions, {"perturbations": -1}, "perturbations is -1; expected a whole number, 0 or more"),
    (ExactOptions, {"proof": 7}, "proof is 7; expected the name of a file"),
    (ExactOptions, {"every": float("nan")}, "every is nan; expected a finite number of seconds, 0 or more"),
    (MipOptions, {"mu": 0.0}, "mu is 0.0; expected a finite number above 0"),
    (MipOptions, {"start": "exact"}, "start is 'exact'; expected cart or search"),
    (
        MipOptions,
        {"write": "model.txt"},
        "write is 'model.txt'; expected the name of a file that ends with .mps",
    ),
]


@pytest.mark.parametrize(("kind", "given", "sentence"), WRONG)
def test_a_value_that_an_option_cannot_have_is_refused_with_those_that_it_can(kind, given, sentence):
    with pytest.raises(ProblemError, match=sentence):
        kind(**given)


def test_values_of_numpy_are_numbers_too():
    assert SearchOptions(restarts=np.int64(3)).given() == {"restarts": 3}


@pytest.mark.parametrize("kind", CLASSES)
def test_every_option_has_a_line_of_help_and_a_default_that_needs_no_value(kind):
    assert kind().given() == {}
    for option in fields(kind):
        assert 10 < len(option.metadata["help"]) < 100
        assert option.metadata["values"].words


def test_words_become_the_options_that_they_name():
    words = {"start": "search", "mu": "0.01", "write": "model.lp", "highs": "presolve=off,mip_rounding=False, seed=3"}
    highs = {"presolve": "off", "mip_rounding": False, "seed": 3}
    assert MipOptions.read(words, "flow") == MipOptions(start="search", mu=0.01, write="model.lp", highs=highs)


def test_options_of_highs_are_names_and_values():
    with pytest.raises(ProblemError, match="highs is 'presolve'; expected HiGHS's options by name, none of dual_"):
        MipOptions.read({"highs": "presolve"}, "flow")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"colour": "red"}, "search takes no option 'colour'; expected some of: checkpoint, cluster, perturbations"),
        ({"restarts": "many"}, "restarts is 'many'; expected a whole number, 1 or more"),
        ({"restarts": "-3"}, "restarts is -3; expected a whole number, 1 or more"),
        ({"restarts": "1.5"}, "restarts is '1.5'; expected a whole number, 1 or more"),
    ],
)
def test_words_that_say_nothing_are_refused(words, sentence):
    with pytest.raises(ProblemError, match=sentence):
        SearchOptions.read(words, "search", without=("restarts",) if "colour" in words else ())


def test_a_method_takes_the_options_of_its_class_less_those_that_its_cell_leaves_out():
    squares = Problem([[0.0], [1.0]], [0.0, 1.0], depth=1, loss=SquaredError())
    with pytest.raises(ProblemError, match="'exact' takes no option 'every'; expected some of: checkpoint, proof;"):
        solve(squares, "exact", options=ExactOptions(checkpoint="kept", every=1.0))
    classes = Problem([[0.0], [1.0]], [0, 1], depth=1)
    assert options_for(classes, "exact", ExactOptions(checkpoint="kept")) == ExactOptions(checkpoint="kept")
    assert options_for(classes, "exact", SearchOptions()) == ExactOptions()


def test_every_cell_of_the_registry_leaves_out_options_of_its_class_only():
    for solvers in REGISTRY.values():
        for method, solver in solvers.items():
            assert set(solver.without) <= set(OPTIONS[method].names())
    assert {"auto"}.union(*REGISTRY.values()) == set(METHODS)
