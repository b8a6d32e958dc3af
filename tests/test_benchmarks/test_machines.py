"""Machines of the studies: an asset is near its twin but not the twin, what is drawn is clear, answers are judged."""

import json

import numpy as np
import pytest

from benchmarks.machines import retold, ties
from benchmarks.machines.__main__ import JUDGED, MACHINES, SETTLED, closed, figures, inside, run, run_bare
from benchmarks.machines.bare import of_its_twin, today
from benchmarks.machines.draws import CLEAR
from benchmarks.machines.selectors import Said, answer
from benchmarks.seals import open_keys


@pytest.mark.parametrize("machine", MACHINES.values(), ids=MACHINES)
def test_an_asset_is_richer_than_its_twin_and_near_it(machine):
    twin, own = machine.twin(), machine.own(np.random.default_rng(1))
    shown = machine.means(dict.fromkeys(own, 1.0))
    said = np.array([twin.ask({}, cell if len(cell) > 1 else next(iter(cell.values())), {}) for cell in machine.cells])
    apart = np.abs(shown - said) / np.sqrt(np.mean(said**2, axis=0))
    assert 0.003 < apart.max() < 0.5
    assert np.isfinite(machine.means(own, machine.outsiders(np.random.default_rng(2))[:1])).all()


def test_three_machines_settle_constants_and_three_others_judge():
    assert not {m.name for m in SETTLED} & {m.name for m in JUDGED}
    assert [len(SETTLED), len(JUDGED)] == [3, 3]


@pytest.mark.long
def test_cases_are_sealed_clear_and_judged(tmp_path):
    said = run(tmp_path / "set", 3, 5, ["tanks"], ["diagnosis"])
    keys = json.loads((tmp_path / "set.keys.json").read_text())
    assert sorted(key["stratum"] for key in keys.values()) == ["outside", "pair", "single", "single", "sound"]
    assert min(d for key in keys.values() for d in key["d_prime"]) >= CLEAR
    assert "single faults, named right" in said
    answers = [json.loads(line) for line in (tmp_path / "set" / "answers.jsonl").read_text().splitlines()]
    assert len(answers) == 5
    plain = answer(tmp_path / "set" / "tanks" / "tanks000", MACHINES["tanks"], "plain")
    assert plain.names == answers[0]["names"]
    (tmp_path / "set.keys.json").write_text(json.dumps({**keys, "tanks000": {**keys["tanks000"], "noise": "none"}}))
    with pytest.raises(SystemExit, match="do not match their seals"):
        open_keys(tmp_path / "set", tmp_path / "set.keys.json")


def test_figures_count_what_is_right_accused_and_unexplained():
    def key(stratum, names, faults=()):
        new = MACHINES["tanks"].means(dict.fromkeys(("gate12", "gate23", "outlet", "lift", "leak"), 1.0))[0]
        return {"machine": "tanks", "stratum": stratum, "names": names, "faults": faults, "new": new.tolist()}

    load = key("single", ["first_error"], [("load", "first", 0.05)])
    right = Said([["first_error"]], [[["first_error"]]], 0.99, 0.0, [("first_error", "", 4.0, 5.5)], [], closed=1.01)
    wrong = Said([["leak"]], [[["leak"]]], 0.97, 0.0, [], [])
    rows = {f.name: f.value for f in figures([(right, load), (wrong, key("sound", [])), (wrong, key("outside", []))])}
    assert rows["single faults, named right"] == rows["sound, accused"] == rows["`closed` above 1"] == 1.0
    assert rows["outside, called unexplained"] == 0.0
    assert rows["stated 0.95 and more, wrong"] == pytest.approx(2 / 3)
    assert inside(right, load) == [True]
    told = np.array(load["new"])
    near = Said([], [], 0.5, 0.0, [], [], new=tuple(told + 0.01), before=tuple(told + 10.0))
    assert closed(near, load) == pytest.approx(1.0, abs=1e-4)


def test_intervals_are_held_by_the_size_of_their_own_effect_alone():
    key = {"faults": [("gain", "f12", 0.05)]}
    said = Said([], [], 0.9, 0.0, [("gauge_gain", "f12", 4.0, 6.0), ("gauge_bias_l_min", "f12", 0.0, 1.0)], [])
    assert inside(said, key) == [True]


@pytest.mark.long
def test_without_a_run_constants_are_judged_beside_those_of_the_asset(tmp_path):
    said = run_bare(tmp_path / "bare", 4, 4, ["tanks"])
    assert "names stated at 0.95 and more, wrong" in said
    assert "90 % intervals that hold a constant" in said
    keys = json.loads((tmp_path / "bare.keys.json").read_text())
    assert {key["stratum"] for key in keys.values()} <= {"sound", "single", "pair"}
    machine = of_its_twin(MACHINES["tanks"])
    own = dict.fromkeys(machine.twin().card.ranges, 1.1)
    assert today(machine, own, {"leak": 0.2, "lift": 0.5})["leak"] == 0.2
    assert today(machine, own, {"lift": 0.5})["lift"] == pytest.approx(3.4 * 1.1 * 1.5)


@pytest.mark.long
def test_a_tie_is_settled_by_the_proposed_test_and_not_by_a_random_repeat():
    assert ties.run(6, 1) == (
        "Seed 6: 1 ties among 2 single faults; the proposal settles 1 (cell 1 of 1), a random repeat 0."
    )
    doubled = ties.twin_with(MACHINES["tanks"], "power")
    assert doubled.gauges[-1] == "power_2"
    assert doubled.predict({}, MACHINES["tanks"].cells[0])[-1] == doubled.predict({}, MACHINES["tanks"].cells[0])[-2]


@pytest.mark.long
def test_one_fault_has_one_name_in_however_many_tests_and_calls():
    told = "as one test 1, as 2 tests 1, as 4 tests 1, as 8 tests 1, in 100 calls 1"
    assert retold.run(1, 1).startswith(f"Seed 1: of 1 single faults named right: {told}; ")
