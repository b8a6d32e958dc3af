"""The first sentence of a diagnosis, for every kind of verdict: what an engineer is told to do."""

import dataclasses
import re

import numpy as np
import pytest

from octmip.gap import CHAIN, Recorded, diagnose, function_twin, gathered
from octmip.gap.campaign.campaign import Fault
from octmip.gap.causes import ConfoundedEffects
from octmip.gap.effects.simple import SimpleEffect
from octmip.gap.effects.words import effect_words, words_at
from octmip.gap.shrinkage import Shrinkage
from octmip.interfaces.report.diagnosis.phrases import about, closed_words, interval_words, size_of
from octmip.interfaces.report.diagnosis.recommendation import Verdict, recommend, verdict_of
from octmip.interfaces.report.diagnosis.words import page_of_words
from tests.test_octmip.beam_twin import Beam, Field, both, effect, measured

TWIN = Beam()
COMMISSIONING = measured(1000)


def diagnosed(change=None, seed=7, library=None, **settings):
    return diagnose(measured(seed, change, **settings), TWIN, library, COMMISSIONING)


@pytest.fixture(scope="module")
def gain():
    """A gain where nothing of its likes is in the library."""
    return diagnosed(effect("gauge_gain", 4.1, "g05"), library={"gauge_gain": CHAIN["gauge_gain"], **TWIN.effects})


def test_one_cause_says_what_to_do_its_size_its_interval_and_how_sure(gain):
    assert verdict_of(gain) is Verdict.CAUSE
    sentence = recommend(gain)
    assert re.match(
        r"Recalibrate gauge g05: it reads 4\.\d % too high \(90 %: [34]\.\d to [45]\.\d %\), probability", sentence
    )
    assert sentence.endswith("; nothing else is needed.")
    assert re.search(r"probability (9\d(\.\d)?|over 99\.9) %", sentence)
    assert page_of_words(gain).replace("\n", " ").startswith(sentence)


def test_a_negative_size_is_said_without_its_sign():
    low = diagnosed(effect("gauge_bias", -40.0, "g09"))
    assert recommend(low).startswith("Set gauge g09 to zero again: it reads ")
    assert "microstrain too low at every load (90 %: 3" in recommend(low)


def test_what_remains_beside_a_cause_is_said(gain):
    assert 0.85 < gain.shrinkage.low < gain.shrinkage.closed < gain.shrinkage.high < 1.15
    worse = dataclasses.replace(gain, shrinkage=dataclasses.replace(gain.shrinkage, p_after=1e-9))
    assert recommend(worse).endswith("; something smaller remains that no effect of the library describes.")


def test_what_reads_alike_but_is_improbable_is_said_in_the_first_sentence(gain):
    alike = ConfoundedEffects(("gauge_gain", "alignment"), ("g05", "g05"), (0.0,), (1.0, 0.01), ("a", "b"), "", ())
    first = dataclasses.replace(gain.which[0], confounded=(alike,))
    tied = dataclasses.replace(gain, which=(first, *gain.which[1:]))
    assert verdict_of(tied) is Verdict.CAUSE
    assert recommend(tied).endswith("; far less probably b, which these readings cannot tell from it.")


def test_a_pair_is_two_actions():
    pair = diagnosed(both(effect("gauge_bias", 50.0, "g09"), effect("temperature_uniform", -8.0)), seed=3)
    assert verdict_of(pair) is Verdict.CAUSE
    assert "; and " in recommend(pair)
    assert "gauge g09 to zero again" in recommend(pair)
    assert "dd temperature uniform to the twin: size of the field -8" in recommend(pair)


def test_what_is_there_or_not_has_no_size():
    swapped = diagnosed(effect("swapped_pair", 1.0, "g06/g07"))
    assert recommend(swapped).startswith(
        "Exchange the wires of gauges g06 and g07: each shows the strain of the other, probability "
    )


def test_effects_that_cannot_be_told_apart_come_with_the_test_that_separates_them():
    scale = diagnosed(effect("modulus", 3.0), seed=5)
    assert verdict_of(scale) is Verdict.AMBIGUOUS
    sentence = recommend(scale)
    assert sentence.startswith("Cannot be told: ")
    for name in ("modulus", "error of the load factor", "gain common to all gauges"):
        assert name in sentence
    assert sentence.endswith(f"; the next test that separates them: {scale.next_test[0].words}.")


def test_effects_of_one_gauge_that_cannot_be_told_apart_send_to_that_gauge():
    own = diagnosed(effect("gauge_gain", 4.0, "g05"))
    assert verdict_of(own) is Verdict.AMBIGUOUS
    sentence = recommend(own)
    assert sentence.startswith("Check gauge g05: gain of gauge g05 (4.")
    words = r"or crosstalk from gauge g0[46] into gauge g05, which these readings cannot tell apart"
    assert re.search(words, sentence)
    assert sentence.endswith("; the next test that separates them: shunt-calibrate the bridges.")


def test_what_is_certain_beside_an_ambiguity_is_said_too():
    mixed = diagnosed(both(effect("modulus", 4.0), effect("gauge_bias", 60.0, "g09")), seed=5)
    assert verdict_of(mixed) is Verdict.AMBIGUOUS
    assert "; certain beside it: set gauge g09 to zero again: it reads " in recommend(mixed)


def test_a_cause_of_little_probability_is_not_acted_on(gain):
    first = dataclasses.replace(gain.which[0], probability=0.6)
    nothing = dataclasses.replace(first, effects=(), parameters=(), probability=0.38)
    open_ = dataclasses.replace(gain, which=(first, nothing))
    assert verdict_of(open_) is Verdict.AMBIGUOUS
    assert recommend(open_) == (
        "Cannot be told: gain of gauge g05 (probability 60 %) or no effect (probability 38 %); to separate them: "
        "repeat the test with more readings."
    )


def test_a_difference_without_a_run_is_not_nothing_to_do():
    """The twin was 9 mm off at p = 1.8e-5, and nothing was to be done."""
    alone = diagnose(measured(4), TWIN)
    assert verdict_of(alone) is Verdict.SOUND
    off = dataclasses.replace(alone, where=dataclasses.replace(alone.where, p_value=1.8e-5))
    assert verdict_of(off) is Verdict.UNMEASURED
    assert recommend(off).startswith("Cannot be told: readings and twin differ by ")
    assert "(p-value 1.8e-05)" in recommend(off)
    assert "bring a run of the sound asset" in recommend(off)
    beside = dataclasses.replace(diagnosed(seed=4), where=off.where)
    assert verdict_of(beside) is Verdict.SOUND
    assert recommend(beside).startswith("Nothing to do: no effect larger than the detectable sizes below (prob")


def test_what_the_library_lacks_stops_and_says_where_to_look():
    odd = 12 * np.sin(9 * np.arange(20))
    unknown = diagnosed(lambda state, load, time: load * odd, seed=2)
    assert verdict_of(unknown) is Verdict.UNEXPLAINED
    sentence = recommend(unknown)
    assert sentence.startswith("Stop: the gap is explained by nothing in the library (probability ")
    assert unknown.where.gauges[0].name in sentence
    assert sentence.endswith("before relying on the twin.")
    looks = "a rough field, proportional to the load, of about 3 % of the readings"  # 2 %, of sizes that triple
    assert unknown.posterior.unknown_words == looks


def test_an_effect_too_small_to_name_waits_for_more_readings(gain):
    faint = dataclasses.replace(gain, which=(dataclasses.replace(gain.which[0], is_identifiable=False),))
    assert verdict_of(faint) is Verdict.TOO_SMALL
    assert recommend(faint).startswith("Nothing to do yet: some effect is there (probability ")
    assert recommend(faint).endswith("the next test: repeat the test with more readings.")
    assert "gain of one gauge, or another" in page_of_words(faint)


def test_a_damage_that_could_be_the_cause_is_named_beside_it():
    unknown = diagnosed(effect("temperature_uniform", -8.0), seed=11, states=((0.35, 0.55),), known=False)
    assert verdict_of(unknown) is Verdict.CAUSE  # the damage is told from the cause
    hidden = dataclasses.replace(
        unknown, refused={"temperature_uniform": "correlated 0.97 with an unknown damage: ..."}
    )
    assert verdict_of(hidden) is Verdict.HIDDEN
    assert recommend(hidden) == (
        "Cannot be told: temperature uniform or a damage of the structure; the next test that separates them: a "
        "healthy commissioning run at zero and several other loads."
    )


@pytest.mark.parametrize("name", ["stuck", "clipped"])
def test_channels_that_say_nothing_are_repaired_first(gain, name):
    sound = diagnosed(seed=4)
    fault = Fault(name, "g03", np.arange(3), "", 1500.0, 0)
    beginning = {
        "stuck": "Repair the channel of gauge g03, whose readings do not follow the load; ",
        "clipped": "Widen the range of the channel of gauge g03: g03 ends at 1500 microstrain; ",
    }[name]
    ends = {sound: "nothing else to do: no effect", gain: "recalibrate gauge g05: it reads"}
    for diagnosis, end in ends.items():
        changed = dataclasses.replace(diagnosis, noise=dataclasses.replace(diagnosis.noise, faults=(fault,)))
        assert recommend(changed).startswith(beginning + end)


@pytest.mark.parametrize("name", sorted(CHAIN))
def test_every_effect_of_the_measuring_chain_has_its_words(name):
    chosen = CHAIN[name]
    place = chosen.places(TWIN)[0]
    named = words_at(chosen, TWIN, place)
    said = [effect_words(chosen), named.name, named.action, named.above, named.below, chosen.unit]
    said += [chosen.parameter, chosen.separated_by]
    assert [words for words in said if not words or "None" in words] == []
    assert not {"{", "}", "_"} & set(named.name + named.action)
    assert named.has_size == ("{size}" in named.above) == (name not in ("swapped_pair", "dead_gauge"))
    if place:
        assert "g01" in named.name


def test_an_effect_without_words_is_called_by_its_name():
    own = Field("lift_of_wake", np.zeros(20), 1, 1.0)
    assert effect_words(own) == effect_words(SimpleEffect(own.name, "%", 1.0, lambda r, size: r)) == "lift of wake"
    assert words_at(own, TWIN, "").action == "add lift of wake to the twin"
    assert words_at(own, TWIN, "0.3").name == "lift of wake at 0.3"


def test_a_brace_in_the_name_of_a_gauge_is_only_a_brace():
    twin = Beam(gauges=("{second}", *TWIN.gauges[1:]))
    assert words_at(CHAIN["crosstalk"], twin, "{second}<g02").name == "crosstalk from gauge g02 into gauge {second}"


def test_sizes_have_the_digits_that_their_interval_bears(gain):
    own = gain.which[0].parameters[0]

    def sized(size, low, high):
        parameter = dataclasses.replace(own, size=size, low=low, high=high)
        return size_of(parameter), interval_words(parameter)

    assert sized(4.1234, 3.2345, 5.0123) == ("4.1 %", "90 %: 3.2 to 5.0 %")
    assert sized(123.4, 99.0, 150.0) == ("123 %", "90 %: 99 to 150 %")
    assert sized(0.01234, 0.0121, 0.0126) == ("0.01234 %", "90 %: 0.01210 to 0.01260 %")
    assert sized(-0.001, -0.5, 0.5) == ("0.0 %", "90 %: -0.5 to 0.5 %")


def test_a_probability_is_never_rounded_to_certainty():
    assert [about(p) for p in (0.98, 0.994, 0.9999, 1.0, 0.004)] == [
        "98 %",
        "99.4 %",
        "over 99.9 %",
        "over 99.9 %",
        "0.4 %",
    ]


@pytest.mark.parametrize(
    ("closed", "low", "high", "end"),
    [
        (1.068, 0.93, 1.2, "So all of the gap has closed: the rest is no more than a sound asset may differ by."),
        (0.9, 0.8, 1.05, "So 90.0 % of its mean square has closed (90 %: 80.0 % to all of it)."),
        (0.3, -0.1, 0.6, "So 30.0 % of its mean square has closed (90 %: none of it to 60.0 %)."),
        (-0.2, -0.3, 0.0, "None of the gap has closed."),
        (float("nan"), 0.0, 0.0, "The gap is too small beside the noise to say which share of it closed."),
    ],
)
def test_no_share_of_a_gap_is_above_one_or_below_nothing(gain, closed, low, high, end):
    assert gain.shrinkage is not None
    changed: Shrinkage = dataclasses.replace(gain.shrinkage, closed=closed, low=low, high=high)
    assert end in closed_words(changed)


def test_an_instrument_that_is_no_bridge_is_told_from_the_machine_by_a_second_one_beside_it():
    rng = np.random.default_rng(5)
    ranges = {"k": (10.0, 5.0, 14.0, "N/mm")}
    spring = function_twin(lambda p, loads: [loads["f"] / p["k"], loads["f"]], {"a": "mm", "c": "N"}, ranges, ("f",))

    def read(k):
        rows = {f: np.array([f / k, f]) + 0.01 * rng.standard_normal((20, 2)) for f in (4.0, 8.0, 12.0)}
        return gathered(spring, [Recorded(readings, {"f": f}) for f, readings in rows.items()])

    found = diagnose(read(9.7), spring, commissioning=read(10.0))
    assert set(found.which[0].names[0]) == {"k", "gauge_gain"}
    assert [(test.name, test.gauge) for test in found.next_test] == [("second_instrument", "a")]
