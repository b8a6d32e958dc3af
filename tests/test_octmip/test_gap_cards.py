"""Every model that the documentation prints is diagnosed, with its card and in Python, with and without a run."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from docs._extensions.notebooks import BLOCK
from octmip.gap import Campaign, Recorded, diagnose, gathered
from octmip.gap.campaign.metered import gathered_alike
from octmip.gap.doors import FunctionTwin, read_card
from octmip.interfaces.report.diagnosis.as_json import as_object
from octmip.twin import load_of
from tests.test_examples import DOCS
from tests.test_octmip.test_gap_built import SD, SPRINGS, at_forces, springs

LOADS = {
    "doors": [{"force": f} for f in (20.0, 50.0, 80.0)],
    "joint": [{"amplitude": a} for a in (0.3, 0.6)],
    "rod": [{"power": p, "air": a} for p, a in ((5.0, 20.0), (10.0, 21.0), (20.0, 23.0))],
    "own-machines motor_twin": [{"voltage": v, "torque": t} for v in (12.0, 24.0) for t in (0.1, 0.2)],
    "own-machines frame_twin": [{"force": f} for f in (20.0, 60.0, 100.0)],
    "own-machines bolted_twin": [{"force": f} for f in (100.0, 300.0, 600.0)],
}
"""What is applied to the models of each page; a page of several has a line for each twin."""
PAGES = sorted(
    page for page in DOCS.rglob("*.md") if page.stem != "index" and "twin = function_twin(" in page.read_text()
)  # the start page diagnoses its twin itself, and tests/test_examples.py runs it
CARD = re.compile(r"```json\n(\{\"readings\".*?)```", re.DOTALL)


def twin_of(page: Path, name: str = "twin") -> FunctionTwin:
    """Return the first twin of a name that the code of a page makes."""
    namespace: dict = {}
    for kind, code in BLOCK.findall(page.read_text()):
        if kind == "python":
            exec(code, namespace)
        if name in namespace:
            return namespace[name]
    raise AssertionError(f"{page} makes no {name}")


def read(twin: FunctionTwin, loads: list[dict], moved: str = "", seed: int = 0) -> Campaign:
    """Return a campaign of a twin, one parameter at nine tenths of its greatest value, with a noise of a thousandth."""
    rng, blocks = np.random.default_rng(seed), []
    own = twin.card.ranges.get(moved)
    for load in loads:
        at = load_of(twin.loads, tuple(load.values()))
        clean = twin.ask({}, at, {} if own is None else {moved: 0.1 * own.nominal + 0.9 * own.high})
        blocks.append(Recorded(clean + 1e-3 * (1 + np.abs(clean)) * rng.standard_normal((12, len(clean))), load))
    return gathered(twin, blocks)


def test_each_page_that_makes_a_twin_is_diagnosed_here():
    assert sorted(page.stem for page in PAGES) == sorted({case.partition(" ")[0] for case in LOADS})


@pytest.mark.parametrize("with_run", [False, True])
@pytest.mark.parametrize("case", LOADS)
def test_the_twin_of_every_page_is_diagnosed_with_and_without_a_run(case, with_run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    stem, _, name = case.partition(" ")
    page = next(page for page in PAGES if page.stem == stem)
    twin, loads = twin_of(page, name or "twin"), LOADS[case]
    name = next(iter(twin.card.ranges))
    run = read(twin, loads, seed=1) if with_run else None
    diagnosis = diagnose(read(twin, loads, name), twin, commissioning=run)
    constants = json.loads(json.dumps(as_object(diagnosis)["constants"]))
    assert [tuple(one["interval"]) for one in constants] == [one.interval for one in diagnosis.constants]
    apart = [one["name"] for one in constants if not one["interval"][0] <= one["drawn"] <= one["interval"][1]]
    assert name in (*diagnosis.which[0].effects, *apart)
    assert not diagnosis.doubts


def test_every_card_that_a_page_prints_is_that_of_its_twin_in_python(tmp_path):
    cards = [(page, card) for page in DOCS.rglob("*.md") for card in CARD.findall(page.read_text())]
    assert [page.stem for page, _ in cards] == ["doors"]
    for page, card in cards:
        (tmp_path / "card.json").write_text(card)
        told, own = read_card(tmp_path / "card.json"), twin_of(page).card
        assert (told.readings, tuple(told.loads), told.ranges) == (own.readings, own.loads, own.ranges)


NOMINAL = {name: own.nominal for name, own in SPRINGS.card.ranges.items()}


def metered(n: int, seed: int, **values: float):
    """Return a time series of the springs: each row its own force."""
    rng = np.random.default_rng(seed)
    forces = 40.0 + 20.0 * np.sin(np.arange(n) / n * 40.0) + 2.0 * rng.standard_normal(n)
    noise = SD * rng.standard_normal((n, len(SD)))
    return at_forces(np.array([springs(NOMINAL | values, {"force": force}) for force in forces]) + noise, forces)


@pytest.mark.parametrize("n", [150, 1500])
def test_a_time_series_beside_another_is_diagnosed_with_its_size(n):
    found = diagnose(metered(n, 2, k1=9.7), SPRINGS, commissioning=metered(n, 1))
    assert found.which[0].effects == ("k1",)
    size = found.which[0].parameters[0]
    assert size.low < -0.3 < size.high
    assert size.high - size.low < 0.05
    assert "Nearly every row has its own load" in " ".join(found.notes)
    assert len(found.posterior.model.inputs.campaign.cells) <= 20


def test_rows_are_moved_along_the_square_through_their_like_and_the_rest_is_their_noise():
    rng = np.random.default_rng(3)
    forces, sd = rng.uniform(0.0, 10.0, 600), 0.01
    rows = np.column_stack([forces**2, np.where(rng.random(600) < 0.3, np.nan, 3.0 * forces), forces, 0.0 * forces])
    series = at_forces(rows + sd * rng.standard_normal(rows.shape), forces)
    (moved,), notes = gathered_alike([series])
    assert len(notes) == 1
    assert len(moved.cells) == 20
    for cell in moved.cells:
        assert cell.mean == pytest.approx([cell.load**2, 3.0 * cell.load, cell.load, 0.0], abs=0.02)
        assert np.nanstd(moved.readings[cell.rows], axis=0) == pytest.approx(sd, rel=0.6)


def test_tests_and_states_stay_apart_and_few_loads_stay_as_they_are():
    series = metered(300, 1)
    half = ["a"] * 150 + ["b"] * 150
    (moved,), _ = gathered_alike([replace(series, test=tuple(half))])
    assert {cell.test for cell in moved.cells} == {"a", "b"}
    assert len({cell.load for cell in moved.cells}) <= 20
    steady = at_forces(np.ones((45, 5, 4)), range(45))
    assert gathered_alike([steady]) == ([steady], [])


def test_a_time_series_beside_steady_loads_is_gathered_at_these_and_moves_no_reading_of_them():
    rows = np.array([springs(NOMINAL | {"k1": 9.5}, {"force": f}) for f in (25.0, 40.0, 55.0)])
    steady = at_forces(rows[:, None] + SD * np.random.default_rng(4).standard_normal((3, 12, 4)), (25.0, 40.0, 55.0))
    run, now = gathered_alike([metered(1500, 1), steady])[0]
    assert now.readings == pytest.approx(steady.readings)
    assert {cell.load for cell in run.cells} == {cell.load for cell in now.cells} == {25.0, 40.0, 55.0}
    found = diagnose(steady, SPRINGS, commissioning=metered(1500, 1))
    assert found.which[0].effects == ("k1",)
    assert found.which[0].parameters[0].size == pytest.approx(-0.5, abs=0.06)


def test_plateaus_of_two_tests_near_one_centre_stay_at_their_own_loads():
    series = metered(400, 1)
    plateau = gathered(SPRINGS, [Recorded(np.full((30, 4), 3.0), {"force": 41.37}, test="B")])
    both = replace(
        series,
        test=(*series.test, *plateau.test),
        load_factor=np.concatenate([series.load_factor, plateau.load_factor]),
        states=np.zeros((430, 0)),
        readings=np.concatenate([series.readings, plateau.readings]),
        time=np.full(430, np.nan),
        temperature=np.full(430, np.nan),
    )
    (moved,), _ = gathered_alike([both])
    (own,) = [cell for cell in moved.cells if cell.test == "B"]
    assert own.load == pytest.approx(41.37)
    assert own.mean == pytest.approx(3.0)
