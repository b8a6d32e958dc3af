"""Calibration of a strip of two zones: gradients, recovery from another mesh, limits, held-out readings."""

from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest
import scipy.sparse as sparse

from femlib.arrays import FloatArray
from femlib.assembly import Shells, Supports, point_masses
from femlib.calibration import (
    Design,
    FrequencyReading,
    MassReading,
    MovingGauges,
    Observation,
    OutputReading,
    Parameter,
    Varying,
    VaryingRows,
    calibrate,
    predict,
)
from femlib.errors import InputError, SolveError
from femlib.material import isotropic_plate
from tests.test_femlib.plates import grid_mesh

TRUE = {"inner": 1.4, "outer": 0.5, "density": 1.2, "gauge_x": 0.31, "load": 8.0}
LABELS = ("s1", "s2", "s3", "s4")


class Cantilever:
    """A strip 1 m long, clamped at x = 0, of two zones, with four gauges in a row that starts at gauge_x."""

    def __init__(self, n: int) -> None:
        self.mesh = grid_mesh(np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 0.2, 4))
        card = isotropic_plate(7e10, 0.3, 0.004, 2700.0)
        count = self.mesh.n_elements
        self.shells = Shells(
            self.mesh, (card,), np.zeros(count, dtype=np.int64), np.ones(count), np.array([1.0, 0.0, 0.0])
        )
        self.supports = Supports.clamping(self.mesh, np.flatnonzero(self.mesh.nodes[:, 0] == 0.0))
        thickness = np.full(count, 0.004)
        self.gauges = MovingGauges(self.mesh, thickness, np.array([1.0, 0.0, 0.0]), ("plate",), unit=1e6)

    def design(self, values: Mapping[str, float]) -> Design:
        """Return the strip at `values`; what they do not name has its true value."""
        v = {**TRUE, **values}
        outer = self.mesh.centroids()[:, 0] > 0.5
        zones = {"inner": 1.0 - outer, "outer": 1.0 * outer}
        stiffness = Varying(v["inner"] * zones["inner"] + v["outer"] * zones["outer"], zones)
        ones = np.ones(self.mesh.n_elements)
        soft = Varying(np.where(self.mesh.centroids()[:, 0] < 0.25, 0.6, 1.0))
        unit = self._tip(2)
        places = np.column_stack([v["gauge_x"] + np.array([0.0, 0.06, 0.38, 0.5]), np.full(4, 0.11), np.zeros(4)])
        aft = np.broadcast_to(np.array([1.0, 0.0, 0.0]), (4, 3))
        return Design(
            self.shells,
            self.supports,
            stiffness,
            Varying(v["density"] * ones, {"density": ones}),
            {"sound": Varying(ones), "damaged": soft},
            {"tip": Varying(v["load"] * unit, {"load": unit}), "one newton": Varying(unit)},
            {
                "gauges": self.gauges.at(Varying(places, {"gauge_x": aft})),
                "tip": VaryingRows(sparse.csr_array(unit[None])),
                "sideways": VaryingRows(sparse.csr_array(self._tip(1)[None])),
            },
            point_masses(self.mesh, {len(self.mesh.nodes) - 1: 0.3}),
        )

    def _tip(self, axis: int) -> FloatArray:
        nodes = np.flatnonzero(self.mesh.nodes[:, 0] == 1.0)
        unit = np.zeros(self.mesh.n_dofs)
        unit[6 * nodes + axis] = 1.0 / len(nodes)
        return unit


@cache
def strip(n: int) -> Cantilever:
    return Cantilever(n)


def readings(n: int) -> list[Observation]:
    """Return what a strip with the true values, on a mesh of its own, reads."""
    design = strip(n).design({})
    one, sd = np.ones(4), np.full(4, 2.0)
    asked: list[Observation] = [
        OutputReading("strain", "sound", "tip", "gauges", one, sd, labels=LABELS),
        OutputReading("increment", "damaged", "tip", "gauges", one, sd, reference="sound", labels=LABELS),
        OutputReading("stiffness", "sound", "one newton", "tip", one[:1], 1e-5 * one[:1]),
        MassReading(1.0, 0.01),
        FrequencyReading(0, 1.0, 0.05, "tip", "sideways", group="bending 1"),
        FrequencyReading(1, 1.0, 0.2, "tip", "sideways", group="bending 2"),
    ]
    found = iter(predict(design, asked, []).value)
    filled: list[Observation] = []
    for reading in asked:
        values = np.array([next(found) for _ in range(reading.n_entries)])
        if isinstance(reading, OutputReading):
            kept = (reading.group, reading.state, reading.load, reading.output)
            filled.append(OutputReading(*kept, values, reading.sd, reading.reference, reading.labels))
        elif isinstance(reading, MassReading):
            filled.append(MassReading(float(values[0]), reading.sd))
        else:
            moves = (reading.moves, reading.still, reading.group)
            filled.append(FrequencyReading(reading.number, float(values[0]), reading.sd, *moves))
    return filled


def parameters(**changes: Parameter) -> list[Parameter]:
    usual = {
        "inner": Parameter("inner", 1.0, 0.1, 10.0, is_log=True),
        "outer": Parameter("outer", 1.0, 0.1, 10.0, is_log=True),
        "density": Parameter("density", 1.0, 0.3, 3.0, 1.0, 0.5, is_log=True),
        "gauge_x": Parameter("gauge_x", 0.3, 0.2, 0.4, 0.31, 0.005),
        "load": Parameter("load", 5.0, 1.0, 20.0),
    }
    return list({**usual, **changes}.values())


@pytest.mark.parametrize("name", list(TRUE))
def test_the_adjoint_gradient_is_the_central_difference(name: str) -> None:
    plate, seen = strip(16), readings(16)
    step = 1e-5 * TRUE[name]
    up, down = (predict(plate.design({name: TRUE[name] + s}), seen, []).value for s in (step, -step))
    exact = predict(plate.design({}), seen, [name]).jacobian[:, 0]
    expected = (up - down) / (2.0 * step)
    assert np.abs(exact).max() > 0.0
    # a gauge's place is itself differentiated by differences, exact between element middles
    assert exact == pytest.approx(expected, rel=2e-5, abs=2e-5 * np.abs(expected).max())


def test_two_moduli_density_load_and_gauge_place_come_back_from_another_mesh() -> None:
    found = calibrate(strip(16), parameters(), readings(24))
    assert found.limits == {}
    assert [found[name] for name in TRUE] == pytest.approx(list(TRUE.values()), rel=0.03)
    assert np.abs(found.residuals).max() < 2.0
    assert (found.standard_deviation > 0.0).all()
    assert found.n_predictions < 30


def test_on_the_same_mesh_they_come_back_exactly() -> None:
    free = {name: Parameter(name, 1.05 * TRUE[name], 0.1, 20.0) for name in ("inner", "outer", "density", "load")}
    found = calibrate(strip(8), list(free.values()), readings(8))
    assert [found[name] for name in free] == pytest.approx([TRUE[name] for name in free], rel=1e-5)


def test_the_covariance_is_that_of_the_linear_model() -> None:
    seen = readings(8)
    found = calibrate(strip(8), [Parameter("load", 5.0, 1.0, 20.0)], seen)
    slopes = predict(strip(8).design({}), seen, ["load"]).jacobian[:, 0]
    sd = np.concatenate([np.atleast_1d(reading.sd) for reading in seen])
    assert found.standard_deviation[0] == pytest.approx(1.0 / np.linalg.norm(slopes / sd), rel=1e-6)


def test_a_parameter_whose_range_ends_too_early_is_named_with_its_end() -> None:
    found = calibrate(strip(8), parameters(outer=Parameter("outer", 1.0, 0.8, 10.0, is_log=True)), readings(8))
    assert found.limits == {"outer": "lower"}
    assert found.standard_deviation[1] == 0.0
    assert found["outer"] == pytest.approx(0.8, rel=1e-3)


def test_held_out_readings_are_predicted_and_not_fitted() -> None:
    seen = readings(8)
    first = seen[0]
    assert isinstance(first, OutputReading)
    wrong = OutputReading(
        "strain", "sound", "tip", "gauges", first.measured + np.array([0.0, 500.0, 0.0, 0.0]), first.sd, labels=LABELS
    )
    found = calibrate(strip(8), parameters(), [wrong, *seen[1:]], held_out=["s2"])
    assert found["inner"] == pytest.approx(TRUE["inner"], rel=1e-2)
    assert found.of(wrong)[1] == pytest.approx(first.measured[1], rel=1e-2)
    assert found.is_held_out.sum() == 2
    by_group = calibrate(strip(8), parameters(), seen, held_out=["bending 2"])
    assert by_group.is_held_out.tolist().index(True) == 11


def test_a_parameter_that_nothing_sees_gets_a_sentence() -> None:
    with pytest.raises(SolveError, match=r"do not settle the parameters .*give a prior or fix one"):
        calibrate(strip(8), [Parameter("unseen", 1.0, 0.5, 2.0), Parameter("load", 8.0, 1.0, 20.0)], readings(8))


def test_too_few_predictions_get_a_sentence() -> None:
    with pytest.raises(SolveError, match="did not converge in 2 predictions"):
        calibrate(strip(8), parameters(), readings(8), most_predictions=2)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Parameter("a", 3.0, 0.0, 2.0), "parameter a starts at 3.0 in 0.0 to 2.0; expected"),
        (lambda: Parameter("a", 1.0, 0.0, 2.0, is_log=True), "fitted by its logarithm; expected more than 0"),
        (lambda: Parameter("a", 1.0, 0.0, 2.0, prior_sd=1.0), "expected both or neither"),
        (lambda: Parameter("a", 1.0, 0.0, 2.0, 1.0, 0.0), "prior sd 0.0; expected more than 0"),
        (lambda: Parameter("a", 1.0, 0.0, 2.0, 9.0, 1.0), "prior mean 9.0; expected 0.0 to 2.0"),
        (lambda: MassReading(1.0, 0.0), "mass is 1.0 with the sd 0.0; expected"),
        (lambda: FrequencyReading(-1, 1.0, 1.0), "asks for mode -1; expected 0 or more"),
        (lambda: FrequencyReading(0, 1.0, 1.0, "tip"), "names one of moves and still"),
        (lambda: OutputReading("g", "s", "l", "o", np.ones(2), np.zeros(2)), r"g sd\[0\] is 0.0; expected more than 0"),
        (lambda: OutputReading("g", "s", "l", "o", np.ones(2), np.ones(2), labels=("a",)), "1 labels for 2 readings"),
        (lambda: calibrate(strip(8), [], readings(8)), "expected a list of Parameter"),
        (lambda: calibrate(strip(8), [parameters()[0]] * 2, readings(8)), r"share the names \['inner'\]"),
        (lambda: calibrate(strip(8), parameters(), []), "expected a list of readings"),
        (lambda: calibrate(strip(8), parameters(), readings(8), held_out="s9"), r"held_out names \['s9'\]"),
        (lambda: calibrate(strip(8), parameters(), readings(8), most_predictions=0), "most_predictions is 0"),
        (lambda: predict(strip(8).design({}), [unknown("state")], []), "name the state 'no'; expected one of"),
        (lambda: predict(strip(8).design({}), [unknown("load")], []), "name the load 'no'; expected one of"),
        (lambda: predict(strip(8).design({}), [unknown("output")], []), "name the output 'no'; expected one of"),
        (lambda: predict(strip(8).design({}), [unknown("size")], []), "has 2 readings but the design predicts 4"),
        (lambda: strip(8).design({"inner": -1.0}), "stiffness of element 0 is -1.0; expected more than 0"),
        (lambda: Varying(np.ones(2), {"a": np.ones(3)}), r"slope by a has shape \(3,\); expected \(2,\)"),
    ],
)
def test_wrong_input_gets_one_sentence(make: object, sentence: str) -> None:
    assert callable(make)
    with pytest.raises(InputError, match=sentence):
        make()


def unknown(what: str) -> OutputReading:
    names = {"state": "sound", "load": "tip", "output": "gauges"}
    if what in names:
        names[what] = "no"
    n = 2 if what == "size" else 4
    return OutputReading("strain", *names.values(), np.ones(n), np.ones(n))
