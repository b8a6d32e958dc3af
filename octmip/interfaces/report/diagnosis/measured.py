"""Measured against predicted: the mean readings of every test and load beside the twin, without and with the effect."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from octmip.gap.causes import UNKNOWN
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.inference.linear_model import OPEN_STATE, LinearModel
from octmip.gap.location import whole_means
from octmip.gap.sizes import WIDTH
from octmip.twin import Load

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredCell:
    """The mean readings of one test at one load, all (n_gauges,) in the gauges' units, NaN where nothing was recorded.

    Attributes
    ----------
    test, load, load_words
        of the cell.
    state
        values of the state parameters, "" of an unknown one.
    measured, half_width
        mean reading, and half of its 90 % interval: the noise alone.
    twin, repaired
        what the calibrated twin predicts, without and with the first cause.
    usual
        half of the 90 % interval of what a sound asset and its twin differ by.
    units
        of the gauges.
    unit, scale
        in which several gauges are drawn side by side, and what each is divided by for it.
    """

    test: str
    load: Load
    load_words: str
    state: tuple[float | str, ...]
    measured: Floats
    half_width: Floats
    twin: Floats
    repaired: Floats
    usual: Floats
    units: tuple[str, ...]
    unit: str
    scale: Floats

    @property
    def before(self) -> Floats:
        """Measured less predicted by the twin."""
        return self.measured - self.twin

    @property
    def after(self) -> Floats:
        """Measured less predicted by the twin with the first cause."""
        return self.measured - self.repaired


def has_repair(diagnosis: Diagnosis) -> bool:
    """Return whether the first cause is one that can be added to the twin."""
    first = diagnosis.which[0]
    return bool(first.judged.members) and UNKNOWN not in first.effects


def noise_sds(diagnosis: Diagnosis) -> dict[str, float]:
    """Return the typical standard deviation of one reading of each unit."""
    inputs = diagnosis.posterior.model.inputs
    sd, units = np.sqrt(np.diag(inputs.noise.covariance)), np.array(inputs.units)
    return {unit: float(np.median(sd[units == unit])) for unit in dict.fromkeys(inputs.units)}


def measured_cells(diagnosis: Diagnosis) -> tuple[MeasuredCell, ...]:
    """Return every cell of the campaign, halves of its repeats taken together."""
    model, after = _after_first_cause(diagnosis)
    noise, inputs = model.scatter, model.inputs
    states = OPEN_STATE**2 * np.sum(model.tangents**2, axis=1)
    usual = np.sqrt(np.maximum(0.0, np.diag(model.covariance) - np.diag(noise) - states))
    (cell, gauge), mix = whole_means(model)
    sd = np.sqrt(np.einsum("ij,jk,ik->i", mix, noise, mix))
    table = np.full((4, len(inputs.campaign.cells), len(inputs.campaign.gauges)), np.nan)
    table[:, cell, gauge] = [mix @ model.residual, mix @ after, WIDTH * sd, WIDTH * mix @ usual]
    return tuple(_cell(model, k, table[:, k]) for k in range(table.shape[1]))


def _after_first_cause(diagnosis: Diagnosis) -> tuple[LinearModel, Floats]:
    """Return the model that is drawn, and the residuals (n,) once the first cause is added."""
    if not has_repair(diagnosis):
        model = diagnosis.posterior.model
        return model, model.residual
    judged = diagnosis.which[0].judged
    model, own = judged.model, judged.fit
    moved = model.tangents @ model.moved_by(own.members, own.size)
    return model, np.asarray(model.residual - model.signatures[:, list(own.members)] @ own.size - moved)


def _cell(model: LinearModel, number: int, means: Floats) -> MeasuredCell:
    """Return a cell of which `means` (4, n_gauges) holds residuals before and after, half-widths and usual ones."""
    inputs = model.inputs
    cell = inputs.campaign.cells[number]
    measured = np.where(np.isnan(means[0]), np.nan, cell.mean)
    return MeasuredCell(
        test=cell.test,
        load=cell.load,
        load_words=cell.load_words,
        state=tuple("" if np.isnan(value) else value for value in cell.state.tolist()),
        measured=measured,
        half_width=means[2],
        twin=measured - means[0],
        repaired=measured - means[1],
        usual=means[3],
        units=inputs.units,
        unit=inputs.unit,
        scale=inputs.scale,
    )
