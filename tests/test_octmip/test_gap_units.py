"""Readings of other units than microstrain, several kinds in one campaign, and the sign that the twin states."""

import json
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from scipy import constants

from octmip.errors import DataError, TwinError
from octmip.formats.table.units import factor_between
from octmip.gap import CachedTwin, Recorded, diagnose, function_twin, gathered, read_campaign
from octmip.gap.campaign.noise_estimate import estimate_noise
from octmip.gap.doors.card import Range
from octmip.gap.doors.function import parameter_effect
from octmip.gap.effects import chain_of
from octmip.interfaces.report.diagnosis.as_json import as_object
from octmip.interfaces.report.diagnosis.page import report_page
from octmip.interfaces.report.diagnosis.phrases import amount
from octmip.interfaces.report.diagnosis.recommendation import recommend
from octmip.interfaces.report.diagnosis.words import page_of_words
from octmip.twin import units_of
from tests.test_octmip.beam_twin import Field

STATES = tuple(f"f{k}" for k in range(1, 5))


NAMED = {
    ("in", "m"): constants.inch, ("ft", "m"): constants.foot, ("lbf", "N"): constants.lbf, ("kgf", "N"): constants.g,
    ("bar", "Pa"): constants.bar, ("mbar", "Pa"): constants.bar / 1e3, ("psi", "Pa"): constants.psi,
    ("N/mm2", "MPa"): 1, ("min", "s"): constants.minute, ("h", "s"): constants.hour, ("d", "s"): constants.day,
    ("hours", "min"): 60, ("days", "h"): 24, ("minutes", "seconds"): 60, ("sec", "s"): 1,
    ("km/h", "m/s"): constants.kmh, ("kn", "m/s"): constants.knot, ("mm/s", "m/s"): 1e-3, ("mm/s2", "m/s^2"): 1e-3,
    ("g", "m/s**2"): constants.g, ("mg", "g"): 1e-3, ("t", "kg"): 1e3, ("uV/V", "mV/V"): 1e-3, ("mV/V", "V/V"): 1e-3,
    ("Volts", "V"): 1, ("°", "deg"): 1, ("°/s", "deg/s"): 1, ("deg", "rad"): constants.degree,
    ("deg/s", "rad/s"): constants.degree, ("%", "-"): 1e-2, ("pct", "%"): 1, ("‰", "um/m"): 1e3, ("1", "-"): 1,
    ("rpm", "1/min"): 1, ("1/min", "Hz"): 1 / 60, ("1/s", "Hz"): 1,
    ("kN·m", "N m"): 1e3, ("N-m", "Nm"): 1, ("kN cm", "Nm"): 10, ("lb-ft", "Nm"): constants.lbf * constants.foot,
    ("in-lb", "N·m"): constants.lbf * constants.inch, ("kgf/cm2", "Pa"): constants.kgf / 1e-4, ("uin/in", "um/m"): 1,
    ("m·s⁻²", "m/s^2"): None, ("m/s/s", "g"): 1 / constants.g, ("%RH", "%"): 1, ("Degrees C", "°C"): 1,
    ("N m", "Nm"): 1, ("N*m", "N·m"): 1, ("Nmm", "Nm"): 1e-3, ("kNm", "Nm"): 1e3, ("Ω", "Ohm"): 1, ("m/m", "strain"): 1,
    ("mm/m", "millistrain"): 1, ("nm/m", "um/m"): 1e-3, ("millistrain", "microstrain"): 1e3, ("ustrain", "µm/m"): 1,
    ("ustr", "ue"): 1, ("uε", "uepsilon"): 1, ("umm/mm", "m/m"): 1e-6, ("degC", "C"): 1, ("°F", "degF"): 1,
    ("K", "degC"): None, ("degF", "degC"): None, ("m", "s"): None,
}  # fmt: skip
PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "h": 1e2, "da": 10, "d": 0.1, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9}


@pytest.mark.parametrize(("given", "wanted"), NAMED)
def test_units_are_those_of_the_tables_of_scipy(given, wanted):
    size = NAMED[given, wanted]
    assert factor_between(given, wanted) == (size and pytest.approx(size, rel=1e-12))


def test_a_prefix_is_its_power_of_ten_before_every_unit():
    bases = ("m", "Hz", "Ohm")
    found = {(p, base): factor_between(p + base, base) for p in PREFIXES for base in bases if p + base != "min"}
    known = {key: size for key, size in found.items() if size is not None}
    assert known == pytest.approx({key: PREFIXES[key[0]] for key in known}, rel=1e-12)
    assert len(known) == 21  # of the table and of pint


class Softer(Field):
    """A spring softer than the model's: frequencies fall, displacements grow."""

    def signature(self, twin, state, load_factor, place="", time=0.0):
        return np.concatenate([[0.02, 0.03, 0.1, 0.2], -2e-5 * load_factor * np.linspace(0.2, 1.6, 5)])


SPRING = Softer("spring", np.zeros(9), None, 8.0)


@dataclass(frozen=True)
class Tower:
    """Four frequencies [Hz] and five displacements [m] under a force."""

    gauges: tuple = (*STATES, *(f"u{k}" for k in range(1, 6)))
    units: tuple = ("Hz",) * 4 + ("m",) * 5
    sign: str = "displacement positive with the force"
    loads: tuple = ("force",)
    parameters: tuple = ()
    effects: dict = field(default_factory=lambda: {"spring": SPRING})

    def predict(self, state, force):
        return np.concatenate([[2.0, 6.0, 11.0, 19.0], 2e-3 * force * np.linspace(0.2, 1.0, 5) ** 2])


def tower(seed, size=0.0, twin=Tower(), change=None):
    rng = np.random.default_rng(seed)
    force = np.repeat([1.0, 2.0, 3.0], 12)
    clean = np.array([twin.predict({}, f) + size * SPRING.signature(twin, {}, f) for f in force])
    readings = clean + rng.standard_normal(clean.shape) * np.array([0.01] * 4 + [2e-5] * 5)
    if change is not None:
        change(readings)
    return pulled(twin, force, readings)


def pulled(twin, force, readings):
    return gathered(twin, [Recorded(row, {"force": f}, "pull") for f, row in zip(force, readings, strict=True)])


def test_gauges_of_two_units_are_no_noisier_than_one_another():
    assert [estimate_noise(tower(seed)).findings for seed in range(3)] == [(), (), ()]


@pytest.fixture(scope="module")
def diagnosis():
    return diagnose(tower(0, 5.0), Tower())


def test_one_cause_is_found_in_readings_of_two_units(diagnosis):
    (found,) = diagnosis.which[0].parameters
    assert found.effect == "spring"
    assert found.size == pytest.approx(5.0, rel=0.04)
    assert diagnosis.shrinkage.after < 0.1 * diagnosis.shrinkage.before


def test_every_sentence_bears_the_readings_own_unit(diagnosis):
    said = page_of_words(diagnosis) + report_page(diagnosis) + json.dumps(as_object(diagnosis)["verdict"])
    assert "microstrain" not in said.lower()
    assert "load factor" not in said.lower()
    assert "compressi" not in said
    assert "Hz" in said
    found = as_object(diagnosis)
    assert found["units"]["u5"] == "m"
    assert set(found["noise"]["sd"]) == {"Hz", "m"}
    assert found["noise"]["sd"]["m"] == pytest.approx(2e-5, rel=0.2)
    assert found["where"]["unit"] == "standard deviations of one reading"


def test_an_offset_of_a_frequency_has_the_unit_of_the_frequency():
    def change(readings):
        readings[:, 1] += 1.0

    found = diagnose(tower(1, change=change), Tower())
    (bias,) = found.which[0].parameters
    assert (bias.effect, bias.place, bias.unit) == ("gauge_bias_hz", "f2", "Hz")
    assert bias.size == pytest.approx(1.0, abs=0.2)
    assert "f2" in recommend(found)


def test_only_readings_of_one_unit_can_be_exchanged_and_only_strain_gauges_turned():
    places = {name: effect.places(CachedTwin(Tower())) for name, effect in chain_of(Tower()).items()}
    assert all(a[0] == b[0] for a, b in (place.split("/") for place in places["swapped_pair"]))
    assert places["misalignment"] == ()
    assert set(places["gauge_gain"]) == set(Tower().gauges)
    assert "gauge_bias" not in places
    assert places["gauge_drift_hz"] == STATES


def test_readings_of_one_instrument_share_its_faults():
    @dataclass(frozen=True)
    class Cycle(Tower):
        channels: tuple = STATES + ("laser",) * 5

    twin = CachedTwin(Cycle())
    gain = chain_of(twin)["gauge_gain"]
    assert gain.places(twin) == (*STATES, "laser")
    assert gain.signature(twin, {}, 1.0, "laser")[4:] == pytest.approx(0.01 * twin.predict({}, 1.0)[4:])
    assert not any("u" in place for place in chain_of(twin)["swapped_pair"].places(twin))


@pytest.mark.parametrize(("unit", "factor"), [("strain", 1e-6), ("Hz", 1.0), ("kN", 1e3)])
def test_one_unit_for_all_readings_keeps_the_plain_names(unit, factor):
    @dataclass(frozen=True)
    class Plain(Tower):
        units: tuple = (unit,) * 9

        def predict(self, state, force):
            return factor * 100.0 * force * np.linspace(1.0, 2.0, 9)

    twin = Plain()
    rng, force = np.random.default_rng(3), np.repeat([0.0, 1.0, 2.0, 3.0], 20)
    readings = np.array([twin.predict({}, f) for f in force]) + factor * rng.standard_normal((80, 9))
    readings[:, 2] += 12.0 * factor
    found = diagnose(pulled(twin, force, readings), twin, chain_of(twin, {unit: 200 * factor}))
    assert found.which[0].effects == ("gauge_bias",)
    assert found.which[0].parameters[0].size == pytest.approx(12.0 * factor, rel=0.1)
    assert found.which[0].parameters[0].unit == unit
    assert found.noise.findings == ()


def written(tmp_path, campaign):
    lines = [",".join(["test", *campaign.load_names, *campaign.gauges])]
    for test, load, row in zip(campaign.test, campaign.applied, campaign.readings, strict=True):
        lines.append(",".join([test, *(f"{v:g}" for v in load), *(f"{v:.9g}" for v in row)]))
    path = tmp_path / "pull.csv"
    path.write_text("\n".join(lines))
    return path


REFUSED = {
    "millimetres": (slice(4, 9), 1e3, ["columns u1 to u5", "1e+03 times", "expected m; convert them"]),
    "one column in millimetres": (slice(6, 7), 1e3, ["column u3", "expected m in every column"]),
    "the other sign": (slice(4, 9), -1.0, ["columns u1 to u5", "expected displacement positive with the force"]),
    "rad/s": (slice(0, 4), 200.0, ["columns f1 to f4", "expected Hz"]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_wrong_unit_and_a_reversed_sign_are_one_sentence(tmp_path, case):
    columns, factor, told = REFUSED[case]

    def change(readings):
        readings[:, columns] *= factor

    with pytest.raises(DataError) as error:
        read_campaign(written(tmp_path, tower(4, change=change)), Tower())
    assert all(word in str(error.value) for word in told), error.value


def test_a_sound_file_of_several_units_is_read_as_it_is(tmp_path):
    read = read_campaign(written(tmp_path, tower(5)), Tower())
    assert read.units == units_of(Tower())
    assert read.notes == ()


@dataclass(frozen=True)
class Broken(Tower):
    """A tower whose model fails as models of others do."""

    fault: str = ""

    def predict(self, state, force):
        good = super().predict(state, force)
        if self.fault == "raises":
            return good / {}["modulus"]
        return {"short": good[:3], "nan": good * np.nan, "table": np.stack([good, good]), "words": ["low"] * 9}[
            self.fault
        ]


@pytest.mark.parametrize(
    ("fault", "told"),
    [
        ("raises", r"the twin Broken raised KeyError for the healthy state at force 1: 'modulus'; expected readings"),
        ("short", r"healthy state at force 1: shape \(3,\); expected 9 columns"),
        ("table", r"answers 2 rows"),
        ("nan", r"answers nan for reading f1"),
        ("words", r"no numbers"),
    ],
)
def test_what_goes_wrong_inside_a_twin_is_one_sentence(fault, told):
    with pytest.raises(TwinError, match=told):
        diagnose(tower(6), Broken(fault=fault))


def test_what_goes_wrong_inside_an_effect_is_one_sentence():
    with pytest.raises(TwinError, match=r"effect spring for place '': shape \(2,\)"):
        diagnose(tower(7), replace(Tower(), effects={"spring": Field("spring", np.zeros(2), 0, 8.0)}))


def test_units_that_are_not_one_each_are_refused():
    with pytest.raises(TwinError, match="2 units for 9 readings"):
        diagnose(tower(8), replace(Tower(), units=("Hz", "m")))
    with pytest.raises(TwinError, match="no unit for its reading 'f2'"):
        units_of(replace(Tower(), units={"f1": "Hz"}))


def test_a_load_in_another_unit_is_named_beside_the_readings_that_follow_it(tmp_path):
    twin = function_twin(
        lambda p, loads: [loads["force"] / p["k"], 12.0], {"tip": "mm", "f1": "Hz"}, {"k": (0.5, 0.4, 0.6)}, ("force",)
    )
    rng, lines = np.random.default_rng(0), ["test,force,tip,f1"]
    for force in np.repeat([50.0, 100.0, 200.0], 6):
        tip, f1 = twin.predict({}, force) * (1 + 1e-3 * rng.standard_normal(2))
        lines.append(f"pull,{1e3 * force},{tip},{f1}")
    (tmp_path / "pull.csv").write_text("\n".join(lines))
    with pytest.raises(DataError, match=r"tip.* 0.001 times .*convert them, or force where it is the load that is in"):
        read_campaign(tmp_path / "pull.csv", twin)
    slow = [f"pull,{force},{2 * force + k},{12e3 + k}" for force in (50, 100) for k in range(6)]
    (tmp_path / "pull.csv").write_text("\n".join([lines[0], *slow]))
    with pytest.raises(DataError, match=r"columns f1 to f1.*convert them$"):
        read_campaign(tmp_path / "pull.csv", twin)


@pytest.mark.parametrize("unit", ["1", "-", ""])
def test_a_pure_number_is_written_without_a_unit(unit):
    assert amount(0.252, unit) == "0.252"
    effect = parameter_effect("share", Range(0.3, 0.0, 1.0, unit), None)
    assert effect.parameter == "share above the model's 0.3"
