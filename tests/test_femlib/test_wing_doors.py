"""The wing behind a function and behind a table: one verdict, one size."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from femlib.wing import Wing, WingTwin
from femlib.wing.effects import wing_effects
from octmip.gap import Campaign, FunctionTwin, Recorded, diagnose, gathered
from octmip.gap.doors import Card, table_twin
from octmip.gap.sizes import Parameter
from octmip.interfaces.report.diagnosis.recommendation import recommend

RANGES = {
    "temperature_uniform": (0.0, -20.0, 20.0, "K"),
    "torsion": (0.0, -10.0, 10.0, "% chord"),
}
TRUTH, SIZE = "temperature_uniform", 12.0
DAMAGES, MEASURED = (0.0, 0.3), 0.3
LOADS = (1.0, 3.0)


@pytest.fixture(scope="module")
def native(tiny: Wing) -> WingTwin:
    effects = wing_effects(tiny)
    return WingTwin(tiny, {name: effects[name] for name in RANGES})


@pytest.fixture(scope="module")
def twin(native: WingTwin) -> FunctionTwin:
    def wing(parameters, loads):
        state, load = {"mu1": parameters["mu1"]}, loads["load_factor"]
        added = [parameters[name] * effect.signature(native, state, load) for name, effect in native.effects.items()]
        return native.predict(state, load) + np.sum(added, axis=0)

    readings, sign = dict.fromkeys(native.gauges, "microstrain"), "compressive strain positive"
    return FunctionTwin(wing, Card(readings, states=("mu1",), parameters=RANGES, sign=sign))


@pytest.fixture(scope="module")
def campaign(twin: FunctionTwin) -> Campaign:
    rng = np.random.default_rng(6)
    blocks = []
    for load in LOADS:
        true = twin.ask({"mu1": MEASURED}, load, {TRUTH: SIZE})
        rows = true + 5.0 * rng.standard_normal((12, len(true)))
        blocks.append(Recorded(rows, {"load_factor": load}, state={"mu1": MEASURED}))
    return gathered(twin, blocks)


@pytest.fixture(scope="module")
def card(twin: FunctionTwin, tmp_path_factory) -> Path:
    own = twin.card
    parameters = {name: [r.nominal, r.low, r.high, r.unit] for name, r in own.ranges.items()}
    content = {"readings": own.readings, "states": own.states, "parameters": parameters, "sign": own.sign}
    path = tmp_path_factory.mktemp("doors") / "card.json"
    path.write_text(json.dumps(content))
    return path


def found(campaign: Campaign, twin: FunctionTwin) -> tuple[Parameter, str]:
    diagnosis = diagnose(campaign, twin, twin.effects)
    (parameter,) = diagnosis.which[0].parameters
    return parameter, recommend(diagnosis)


@pytest.fixture(scope="module")
def expected(campaign: Campaign, twin: FunctionTwin) -> tuple[Parameter, str]:
    return found(campaign, twin)


def assert_same(own: tuple[Parameter, str], expected: tuple[Parameter, str], tolerance: float = 1e-6) -> None:
    assert own[1] == expected[1]
    for name in ("size", "low", "high"):
        assert getattr(own[0], name) == pytest.approx(getattr(expected[0], name), rel=tolerance)


def test_the_function_names_what_the_wing_itself_names(campaign, native, twin, expected):
    parameter, sentence = expected
    assert parameter.effect == TRUTH
    assert parameter.low < SIZE < parameter.high
    assert sentence.startswith("Correct the temperature uniform: it is ")
    (own,) = diagnose(campaign, FunctionTwin(twin.function, twin.card), native.effects).which[0].parameters
    assert own.effect == TRUTH
    assert own.size == pytest.approx(parameter.size, rel=5e-3)  # its prior scale is the effect's own


def test_a_table_of_the_wing_says_the_same(campaign, twin, card, expected, tmp_path):
    """Multilinear interpolation loses nothing between these rows; between damages it does."""
    axes = [[low, high] for _, low, high, _ in RANGES.values()]
    lines = [",".join([*RANGES, "mu1", "load_factor", *twin.gauges])]
    for *sizes, damage, load in itertools.product(*axes, DAMAGES, (0.0, 3.0)):
        values = twin.ask({"mu1": damage}, load, dict(zip(RANGES, sizes, strict=True)))
        lines.append(",".join(f"{value:.17g}" for value in (*sizes, damage, load, *values)))
    path = tmp_path / "wing.csv"
    path.write_text("\n".join(lines))
    table = table_twin(path, card)
    assert_same(found(campaign, table), expected)
    # strain is convex in damage: half-way to 30 % a line is off by a twentieth of what 30 % adds
    between = np.abs(table.predict({"mu1": 0.15}, 3.0) - twin.predict({"mu1": 0.15}, 3.0)).max()
    assert between < 0.06 * np.abs(twin.predict({"mu1": 0.3}, 3.0) - twin.predict({}, 3.0)).max()
