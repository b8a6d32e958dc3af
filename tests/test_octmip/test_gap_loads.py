"""Twins of several loads, of one load under another name, and of none."""

import json
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import CachedTwin, Campaign, Recorded, diagnose, function_twin, gathered, read_campaign
from octmip.interfaces.report.diagnosis.as_json import as_object
from octmip.interfaces.report.diagnosis.page import report_page
from octmip.interfaces.report.diagnosis.words import page_of_words
from octmip.twin import Loads, load_words, loads_of, units_of
from tests.test_octmip.beam_twin import Beam, Field
from tests.test_octmip.test_gap_units import written

SETTINGS = [(f, a) for f in (1.0, 2.0, 4.0) for a in (0.5, 1.0, 2.0)]


class Grows(Field):
    """An effect that grows with the square of the amplitude."""

    def signature(self, twin, state, load_factor, place="", time=0.0):
        return -(load_factor["amplitude"] ** 2) * np.linspace(1.0, 4.0, 6)


GROWS = Grows("softening", np.zeros(6), None, 5.0)


@dataclass(frozen=True)
class Shaker:
    """Six accelerometers on a beam that is shaken with an amplitude at a frequency."""

    gauges: tuple = tuple(f"a{k}" for k in range(1, 7))
    parameters: tuple = ()
    loads: tuple = ("frequency", "amplitude")
    effects: dict = field(default_factory=lambda: {"softening": GROWS})

    def predict(self, state, loads):
        reach = np.linspace(1.0, 3.0, 6) ** (loads["frequency"] / 2)
        return 40.0 * loads["amplitude"] * reach / (1 + 0.3 * loads["frequency"])


def shaken(seed: int, size: float) -> Campaign:
    rng = np.random.default_rng(seed)
    twin, rows = Shaker(), [pair for pair in SETTINGS for _ in range(10)]
    loads = [Loads(twin.loads, pair) for pair in rows]
    clean = np.array([twin.predict({}, load) + size * GROWS.signature(twin, {}, load) for load in loads])
    readings = clean + rng.normal(0.0, 1.0, clean.shape)
    return gathered(twin, [Recorded(row, load, "sweep") for load, row in zip(loads, readings, strict=True)])


def test_an_effect_is_found_where_readings_depend_on_two_loads():
    diagnosis = diagnose(shaken(0, 3.0), Shaker())
    (found,) = diagnosis.which[0].parameters
    assert (found.effect, found.place) == ("softening", "")
    assert found.low < 3.0 < found.high
    assert diagnosis.shrinkage.closed > 0.9
    assert len(diagnosis.shrinkage.held_out) == 9


def test_a_wrong_amplitude_is_the_error_of_that_load_alone():
    twin, whole = Shaker(), shaken(1, 0.0)
    readings = whole.readings + np.array([0.2 * twin.predict({}, Loads(twin.loads, tuple(r))) for r in whole.applied])
    given = replace(whole, readings=readings)
    diagnosis = diagnose(given, twin)
    names = {name for cause in diagnosis.credible for name in cause.effects}
    assert "amplitude_error" in names
    assert "load_factor_error" not in diagnosis.inclusion


def test_words_and_pages_of_several_loads_never_say_load_factor():
    diagnosis = diagnose(shaken(2, 3.0), Shaker())
    said = page_of_words(diagnosis) + report_page(diagnosis) + json.dumps(as_object(diagnosis))
    assert "load factor" not in said.lower()
    assert "frequency 4, amplitude 2" in said


def test_a_file_names_the_loads_of_the_twin(tmp_path):
    campaign = shaken(3, 0.0)
    path = written(tmp_path, campaign)
    read = read_campaign(path, Shaker())
    assert read.loads == campaign.loads
    assert read.cells[0].name == "sweep at frequency 1, amplitude 0.5"
    path.write_text(path.read_text().replace("frequency", "frequenzy"))
    with pytest.raises(DataError, match="column 'frequency' is missing"):
        read_campaign(path, Shaker())


def test_a_campaign_of_other_loads_than_the_twin_is_refused():
    one = shaken(4, 0.0)
    with pytest.raises(DataError, match=r"loads \['frequency', 'amplitude'\] but the twin \['load_factor'\]"):
        diagnose(one, Beam(gauges=one.gauges))
    with pytest.raises(DataError, match="the campaign has 2 loads"):
        _ = one.cells[0].load_factor


def test_a_load_by_another_name_is_a_float_and_keeps_its_name():
    class Turned(Beam):
        loads = ("torque",)

    rng, twin = np.random.default_rng(5), Turned()
    torque = np.repeat([0.0, 1.0, 2.0], 20)
    clean = np.array([twin.predict({}, t) for t in torque])
    readings = clean + rng.normal(0, 20.0, clean.shape)
    twin.parameters = ()
    blocks = [Recorded(row, {"torque": t}) for t, row in zip(torque, readings, strict=True)]
    diagnosis = diagnose(gathered(twin, blocks), twin)
    assert diagnosis.is_sound
    assert {place.name for place in diagnosis.where.loads} == {"torque 0", "torque 1", "torque 2"}
    assert "torque_error" in diagnosis.detectable


def test_loads_are_a_mapping_with_a_hash_and_order_by_their_amounts():
    a, b = Loads(("f", "a"), (1.0, 2.0)), Loads(("f", "a"), (1.0, 3.0))
    assert dict(a) == {"f": 1.0, "a": 2.0}
    assert sorted({b, a, Loads(("f", "a"), (1.0, 2.0))}) == [a, b]
    assert f"{a:g}" == "f 1, a 2" == load_words(("f", "a"), a)
    with pytest.raises(KeyError):
        _ = a["force"]


def test_a_twin_that_announces_nothing_reads_microstrain_at_a_load_factor():
    beam = CachedTwin(Beam())
    assert loads_of(beam) == ("load_factor",)
    assert units_of(beam) == ("microstrain",) * 20


TWIN = function_twin(lambda p, loads: [loads["a"], loads["b"]], {"u": "mm", "v": "mm"}, {}, ("a", "b"), ("crack",))


def test_blocks_of_rows_become_a_campaign():
    blocks = [
        Recorded(np.ones((3, 2)), {"a": 1.0, "b": 2.0}, "first", {"crack": 0.2}),
        Recorded([5, 6], {"b": 4, "a": 3}),
    ]
    campaign = gathered(TWIN, blocks)
    assert [cell.name for cell in campaign.cells] == ["first at a 1, b 2", "test at a 3, b 4"]
    assert campaign.states[:, 0].tolist() == [0.2, 0.2, 0.2, 0.0]
    assert campaign.units == ("mm", "mm")


@pytest.mark.parametrize(
    ("block", "told"),
    [
        (Recorded(np.ones((3, 3)), {"a": 1, "b": 2}), r"shape \(3, 3\)"),
        (Recorded(np.ones((3, 2)), {"a": 1}), r"loads \['a'\]; expected \['a', 'b'\]"),
        (Recorded(np.ones((3, 2)), {"a": 1, "b": 2}, state={"hole": 1}), r"state \['hole'\]"),
    ],
)
def test_a_block_that_is_not_the_twins_is_refused(block, told):
    with pytest.raises(DataError, match=told):
        gathered(TWIN, [block])
