"""Effects of a measuring chain on gauges of any name, and the answers that a cached twin keeps of effects."""

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import CHAIN, CachedTwin
from octmip.gap.inference.candidates import candidates_of
from octmip.gap.odds import Odds
from tests.test_octmip.beam_twin import Beam, Field

NAMES = ("a/b", "<", "x<y", "a", "b", "/", "y")
PLAIN = tuple(f"g{k}" for k in range(len(NAMES)))
PAIRS = ("swapped_pair", "crosstalk")


class Named:
    """A twin whose strains are 1, 2, 4, ... at gauges of any names."""

    parameters = ()
    effects: ClassVar[dict] = {}

    def __init__(self, gauges):
        self.gauges = gauges

    def predict(self, state, load_factor):
        return load_factor * 2.0 ** np.arange(len(self.gauges))


@pytest.mark.parametrize("name", PAIRS)
def test_gauges_of_any_name_are_paired_as_those_of_plain_names(name):
    named, plain = Named(NAMES), Named(PLAIN)
    for place, known in zip(CHAIN[name].places(named), CHAIN[name].places(plain), strict=True):
        expected = CHAIN[name].signature(plain, {}, 1.0, known)
        assert CHAIN[name].signature(named, {}, 1.0, place) == pytest.approx(expected, abs=0.0)


@pytest.mark.parametrize(
    ("name", "gauges", "place"),
    [
        ("swapped_pair", ("a", "b/c", "a/b", "c"), "a/b/c"),
        ("crosstalk", ("<", "<<"), "<<<<"),
    ],
)
def test_a_place_of_two_readings_is_refused(name, gauges, place):
    with pytest.raises(DataError, match=r"names 2 pairs of gauges.*rename"):
        CHAIN[name].signature(Named(gauges), {}, 1.0, place)


@pytest.mark.parametrize("name", PAIRS)
def test_a_place_of_no_gauges_is_refused(name):
    with pytest.raises(DataError, match="names 0 pairs of gauges"):
        CHAIN[name].signature(Named(PLAIN), {}, 1.0, "g0/g9<g1")


def test_gauges_that_were_not_read_have_no_candidates_whatever_they_are_called():
    read = tuple(name for name in NAMES if name not in ("a/b", "x<y"))
    effects = {name: CHAIN[name] for name in ("gauge_gain", *PAIRS)}
    found = candidates_of(effects, Named(NAMES), read, Odds())
    places = {name: {found.place for found in found if found.name == name} for name in effects}
    assert places["gauge_gain"] == set(read)
    assert places["swapped_pair"] == set(CHAIN["swapped_pair"].places(Named(read)))
    assert places["crosstalk"] == {"a<b", "b<a", "b</", "/<b", "/<y", "y</"}


def test_a_cached_twin_keeps_two_effects_of_one_name_apart():
    cached = CachedTwin(Beam())
    one = Field("soak", np.full(20, -1.0), 0, 10.0)
    other = replace(one, shape=np.full(20, -3.0))
    first, second = (cached.signatures(effect, ("",), {}, 1.0, 0.0) for effect in (one, other))
    assert (first == -1.0).all()
    assert (second == -3.0).all()
    assert cached.signatures(one, ("",), {}, 1.0, 0.0) is first
    assert cached.signatures(other, ("",), {}, 1.0, 0.0) is second
