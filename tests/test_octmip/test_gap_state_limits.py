"""Unknown states of twins that answer only so far, or only at a price: looked for within the limit, or not at all."""

import json
from dataclasses import replace

import numpy as np
import pytest

from octmip.errors import DataError
from octmip.gap import FunctionTwin, Recorded, diagnose, function_twin, gathered
from octmip.gap.doors import table_twin

GAUGES = {f"g{k}": "mm" for k in range(6)}
SHAPE = np.linspace(1.0, 2.0, 6)


def cracked(parameters, loads):
    crack = parameters["crack"]
    return loads["force"] * SHAPE * (1.0 + crack * np.linspace(0.1, 2.0, 6) / (1.2 - crack)) * 10.0 / parameters["k"]


PARAMETERS = {"k": (10.0, 8.0, 12.0, "N/mm")}
TWIN = function_twin(cracked, GAUGES, PARAMETERS, ("force",), states=("crack",))


def measured(crack, known=float("nan"), seed=0):
    rng, blocks = np.random.default_rng(seed), []
    for force in (1.0, 2.0, 4.0):
        rows = cracked({"crack": crack, "k": 10.0}, {"force": force}) + 0.02 * rng.standard_normal((15, 6))
        blocks.append(Recorded(rows, {"force": force}, state={"crack": known}))
    return gathered(TWIN, blocks)


@pytest.fixture
def table(tmp_path):
    lines = [",".join(["k", "crack", "force", *GAUGES])]
    for k in (8.0, 9.0, 10.0, 11.0, 12.0):
        for crack in np.linspace(0.0, 0.4, 41):
            for force in (0.0, 4.0):
                row = cracked({"crack": crack, "k": k}, {"force": force})
                lines.append(",".join(f"{v:.15g}" for v in (k, crack, force, *row)))
    (tmp_path / "t.csv").write_text("\n".join(lines))
    card = {"readings": GAUGES, "loads": ["force"], "states": ["crack"], "parameters": {"k": list(PARAMETERS["k"])}}
    (tmp_path / "t.csv.json").write_text(json.dumps(card))
    return table_twin(tmp_path / "t.csv")


def test_an_unknown_state_is_looked_for_within_the_table(table):
    assert table.state_limits == {"crack": 0.4}
    (own,), (exact,) = (diagnose(measured(0.25), twin).states for twin in (table, TWIN))
    assert own.mean["crack"] == pytest.approx(0.25, abs=0.03)
    assert own.mean["crack"] == pytest.approx(exact.mean["crack"], abs=0.02)


def test_a_stated_state_at_the_end_of_the_table_is_no_question_beyond_it(table):
    assert diagnose(measured(0.4, known=0.4), table).is_sound


def test_a_state_without_a_limit_is_taken_as_stated_and_must_be_stated():
    slow = FunctionTwin(cracked, replace(TWIN.card, state_limits={}))
    assert diagnose(measured(0.3, known=0.3), slow).is_sound
    with pytest.raises(DataError, match="state crack is unknown, and the twin gives no range"):
        diagnose(measured(0.3), slow)
