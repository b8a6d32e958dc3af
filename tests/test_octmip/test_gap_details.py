"""Details of the diagnosis, each beside its definition: loads, units, grids of states, jumps, variances."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from octmip.errors import DataError, TwinError
from octmip.gap import read_campaign
from octmip.gap.campaign.noise_estimate import _moderated
from octmip.gap.channels.jumps import jumps_in
from octmip.gap.effects.chain import Moment
from octmip.gap.effects.loads import errors_of_load
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.inference.states import LINES, _changes, grid
from octmip.twin import Loads
from tests.test_octmip.beam_twin import Beam, measured
from tests.test_octmip.test_gap_campaign import lines_of, with_cell, write


@dataclass(frozen=True)
class Bent:
    """Two gauges that grow with the square of a force, up to a load."""

    most: float = np.inf
    gauges: tuple = ("a", "b")
    parameters: tuple = ()

    def predict(self, state, load):
        force, other = tuple(load.values()) if isinstance(load, Loads) else (load, 1.0)
        if force > self.most:
            raise TwinError("too much")
        return np.array([1.0, 3.0]) * force**2 * other


@pytest.mark.parametrize("load", [2.0, Loads(("force", "other"), (2.0, 5.0))])
@pytest.mark.parametrize("kind", [0, 1])
def test_a_load_that_was_another_changes_what_the_twin_says_of_it(load, kind):
    """Per cent of a factor, units of an offset; exactly, and linearly where the twin knows no greater load."""
    error, size = errors_of_load("force", 10.0, 0.0)[kind], 0.5
    there = 2.0 + size if kind else 2.0 * (1.0 + size / 100.0)
    here, slope = Bent().predict({}, load), 2.0 / 2.0 * (1.0 if kind else 2.0 / 100.0)
    exact = error.predict(Bent(), {}, load, size, "", 0.0)
    assert exact == pytest.approx(here * there**2 / 4.0, rel=1e-12)
    assert error.change(Moment(Bent(), {}, load, load_name="force")) == pytest.approx(slope * here, rel=0.01)
    linear = error.predict(Bent(most=2.0), {}, load, size, "", 0.0)
    assert linear == pytest.approx(here * (1.0 + slope * size), rel=0.01)


def test_readings_are_in_the_units_of_the_twin():
    twin = Beam()
    twin.units = {name: "mm" if name == "g03" else "microstrain" for name in twin.gauges}
    found = prepare(measured(1), twin, twin.effects)[0].campaign
    assert [found.unit_of(name) for name in ("g02", "g03")] == ["microstrain", "mm"]


def test_an_unknown_damage_changes_each_load_by_what_the_twin_says():
    twin = Beam()
    inputs = prepare(measured(1, known=False), twin, twin.effects, measured(1000))[0]
    model, nodes = linearise(inputs, np.zeros((4, 2))), np.array([[0.3, 0.0], [0.1, 0.6]])
    rows = np.arange(0, len(model.gauge), 7)
    for node, found in zip(nodes, _changes(model, rows, nodes), strict=True):
        state = dict(zip(twin.parameters, node, strict=True))
        true = [twin.predict(state, model.loads[k]) - twin.predict({}, model.loads[k]) for k in rows]
        gauges = [inputs.order[k] for k in model.gauge[rows]]
        assert found == pytest.approx([row[k] for row, k in zip(true, gauges, strict=True)])


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_a_grid_of_states_has_every_parameter_and_every_pair(n):
    nodes = grid(n)
    assert (
        len(np.unique(nodes, axis=0)) == len(nodes) == (LINES[n] ** n if n in LINES else 1 + 4 * (n + n * (n - 1) // 2))
    )
    assert {tuple(np.flatnonzero(node)) for node in nodes if np.count_nonzero(node) < 3} == {
        (),
        *((a,) for a in range(n)),
        *((a, b) for b in range(n) for a in range(b)),
    }
    assert (nodes.min(), 0.7 <= nodes.max() <= 0.85) == (0.0, True)


@pytest.mark.parametrize(("n_jumps", "named"), [(1, 1), (2, 2), (3, 0)])
def test_a_gauge_that_jumps_in_more_than_a_fifth_of_its_cells_is_slow_noise(n_jumps, named):
    campaign = measured(5, loads=tuple(np.linspace(0.5, 3.0, 10)))
    readings = np.array(campaign.readings)
    for k in range(n_jumps):
        readings[100 * k + 25 : 100 * k + 50, 8] += 20.0 * 31.6
    found = jumps_in(replace(campaign, readings=readings))
    assert [(fault.gauge, fault.first) for fault in found] == [("g09", 100 * k + 25) for k in range(named)]


def test_variances_of_few_repeats_are_drawn_toward_that_of_all():
    """Of gauges whose true variances are drawn: no bias, and a third of the error of each gauge's own."""
    rng = np.random.default_rng(3)
    true = 9.0 * 12.0 / rng.chisquare(12.0, 4000)
    degrees = np.full(4000, 5.0)
    own = true * rng.chisquare(degrees) / degrees
    found = _moderated(own, degrees)
    assert found.mean() == pytest.approx(true.mean(), rel=0.02)
    assert np.mean((found - true) ** 2) < 0.4 * np.mean((own - true) ** 2)


@pytest.mark.parametrize(("row", "cure"), [(1, "begin the row with #"), (2, "clear the cell")])
def test_a_text_among_readings_is_refused_with_what_its_row_may_be(tmp_path, row, cure):
    rows = with_cell(lines_of(measured(1)), row, "g03", "gauge")
    with pytest.raises(DataError, match=rf"row {row + 1}, column g03 is 'gauge'; .*{cure}"):
        read_campaign(write(tmp_path, rows), Beam())
