"""Bounded least squares on a parametric structure.

The fit minimises sum ((predicted - measured) / sd)^2 + sum ((coordinate - prior mean) / prior sd)^2 over the
parameters' ranges, by a trust region with the gradient of `femlib.calibration.prediction`. Standard deviations are
those of the linearised posterior, (J'J)^-1 at the optimum over the parameters that are not at an end of their range.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from femlib.arrays import BoolArray, FloatArray
from femlib.calibration.design import ParametricStructure
from femlib.calibration.observation import Observation
from femlib.calibration.parameter import Parameter, checked_parameters, coordinates
from femlib.calibration.prediction import Prediction, predict
from femlib.errors import InputError, SolveError, is_whole

AT_LIMIT = 1e-3
"""Share of the range, on the scale of the fit, within which a parameter counts as at its end."""
INSIDE = 1e-6
"""Share of the range by which the start is moved off an end, where a trust region could not begin."""
TOLERANCE = 1e-5
"""Relative change of sum of squares and coordinates at which the fit ends."""


@dataclass(frozen=True, slots=True, eq=False)
class Calibration:
    """A fit.

    Attributes
    ----------
    parameters : tuple of Parameter
        What was fitted.
    observations : tuple of Observation
        What it was fitted to.
    values : FloatArray
        Fitted values (n_parameters,).
    covariance : FloatArray
        Covariance (n_parameters, n_parameters) of the coordinates; zero for parameters at a limit.
    predicted : FloatArray
        Predictions (n_entries,) at the fitted values, observation by observation.
    is_held_out : BoolArray
        Entries (n_entries,) that the fit did not see.
    n_predictions : int
        How often the structure was solved.
    """

    parameters: tuple[Parameter, ...]
    observations: tuple[Observation, ...]
    values: FloatArray
    covariance: FloatArray
    predicted: FloatArray
    is_held_out: BoolArray
    n_predictions: int

    def __getitem__(self, name: str) -> float:
        """Return the fitted value of a parameter."""
        return self.by_name[name]

    @property
    def by_name(self) -> dict[str, float]:
        """Fitted values by parameter name."""
        return {p.name: float(v) for p, v in zip(self.parameters, self.values, strict=True)}

    @property
    def standard_deviation(self) -> FloatArray:
        """Standard deviations (n_parameters,) of the values; 0 at a limit."""
        slopes = [p.slope(float(v)) for p, v in zip(self.parameters, self.values, strict=True)]
        return np.asarray(np.sqrt(np.diag(self.covariance)) * np.array(slopes))

    @property
    def limits(self) -> dict[str, str]:
        """Parameters that ended at an end of their range: "lower" or "upper" by name."""
        places = coordinates(self.parameters, self.values.tolist())
        return {p.name: end for p, x in zip(self.parameters, places, strict=True) if (end := _limit(p, float(x)))}

    @property
    def residuals(self) -> FloatArray:
        """Predicted less measured, in standard deviations (n_entries,)."""
        return (self.predicted - measured(self.observations)) / deviations(self.observations)

    def of(self, observation: Observation) -> FloatArray:
        """Return the predictions (n,) of one of the observations."""
        start = 0
        for one in self.observations:
            if one is observation:
                return self.predicted[start : start + one.n_entries]
            start += one.n_entries
        raise InputError("the observation is none of this calibration's; expected one of them; take it from the list")


@dataclass(slots=True)
class _Evaluations:
    """Predictions at coordinates, the last one kept: value and gradient are asked for one after the other."""

    structure: ParametricStructure
    parameters: tuple[Parameter, ...]
    observations: tuple[Observation, ...]
    n: int = 0
    _at: FloatArray | None = None
    _kept: Prediction | None = field(default=None)

    def at(self, place: FloatArray) -> Prediction:
        if self._kept is None or self._at is None or not np.array_equal(self._at, place):
            values = [p.value(float(x)) for p, x in zip(self.parameters, place, strict=True)]
            names = [p.name for p in self.parameters]
            found = predict(self.structure.design(dict(zip(names, values, strict=True))), self.observations, names)
            slopes = np.array([p.slope(v) for p, v in zip(self.parameters, values, strict=True)])
            self._at, self._kept = place.copy(), Prediction(found.value, found.jacobian * slopes)
            self.n += 1
        return self._kept


def calibrate(
    structure: ParametricStructure,
    parameters: Sequence[Parameter],
    observations: Sequence[Observation],
    held_out: Collection[str] = (),
    most_predictions: int = 100,
) -> Calibration:
    """Return the parameters that fit observations best within their ranges and priors.

    Parameters
    ----------
    structure : ParametricStructure
        Gives a `Design` for parameter values.
    parameters : sequence of Parameter
        What is fitted, and where it starts.
    observations : sequence of Observation
        What was measured.
    held_out : collection of str
        Labels of entries, or groups of observations, that the fit does not see; they are predicted all the same.
    most_predictions : int
        Limit on the number of times that the structure is solved.

    Raises
    ------
    InputError
        If parameters or observations cannot be used, or nothing is left to fit.
    SolveError
        If the fit does not converge within `most_predictions`.
    """
    known, seen = checked_parameters(parameters), _checked_observations(observations)
    if not is_whole(most_predictions) or most_predictions < 1:
        raise InputError(f"most_predictions is {most_predictions!r}; expected 1 or more; raise it")
    held = _held_out(seen, held_out)
    parts = np.split(held, np.cumsum([o.n_entries for o in seen])[:-1])
    fitted = tuple(o for o, part in zip(seen, parts, strict=True) if not part.all())  # states that none needs cost time
    use = ~np.concatenate([part for part in parts if not part.all()])
    evaluations = _Evaluations(structure, known, fitted)
    target, sd = measured(fitted), deviations(fitted)

    def residuals(place: FloatArray) -> FloatArray:
        own = ((evaluations.at(place).value - target) / sd)[use]
        return np.concatenate([own, _prior_residuals(known, place)])

    def gradient(place: FloatArray) -> FloatArray:
        own = (evaluations.at(place).jacobian / sd[:, None])[use]
        return np.concatenate([own, _prior_gradient(known)])

    ends = np.array([[p.coordinate(p.lower), p.coordinate(p.upper)] for p in known])
    width = ends[:, 1] - ends[:, 0]
    start = coordinates(known, [p.start for p in known])
    start = np.clip(start, ends[:, 0] + INSIDE * width, ends[:, 1] - INSIDE * width)
    found = least_squares(
        residuals,
        start,
        gradient,
        bounds=(ends[:, 0], ends[:, 1]),
        x_scale=width,
        ftol=TOLERANCE,
        xtol=TOLERANCE,
        max_nfev=most_predictions,
    )
    if not found.success:
        raise SolveError(
            f"the fit did not converge in {most_predictions} predictions (sum of squares {2.0 * found.cost:.4g}); "
            "expected convergence; raise most_predictions, start nearer, or give the parameters priors"
        )
    values = np.array([p.value(float(x)) for p, x in zip(known, found.x, strict=True)])
    covariance = _covariance(known, found.x, gradient(found.x))
    names = [p.name for p in known]
    predicted = predict(structure.design(dict(zip(names, values.tolist(), strict=True))), seen, []).value
    return Calibration(known, seen, values, covariance, predicted, held, evaluations.n + 1)


def measured(observations: Sequence[Observation]) -> FloatArray:
    """Return all readings (n_entries,), observation by observation."""
    return np.concatenate([np.atleast_1d(o.measured) for o in observations])


def deviations(observations: Sequence[Observation]) -> FloatArray:
    """Return the standard deviations (n_entries,) of all readings."""
    return np.concatenate([np.atleast_1d(o.sd) for o in observations])


def _checked_observations(observations: Sequence[Observation]) -> tuple[Observation, ...]:
    if not isinstance(observations, Sequence) or not observations:
        raise InputError(f"observations are {observations!r}; expected a list of readings; give at least one")
    wrong = [o for o in observations if not isinstance(o, Observation)]
    if wrong:
        raise InputError(
            f"an observation is a {type(wrong[0]).__name__}; expected OutputReading, MassReading or FrequencyReading; "
            "make one of them"
        )
    return tuple(observations)


def _held_out(observations: Sequence[Observation], names: Collection[str]) -> BoolArray:
    """Return which entries (n_entries,) are named by label or group."""
    wanted = {names} if isinstance(names, str) else set(names)
    held, known = [], set()
    for observation in observations:
        labels = observation.labels or ("",) * observation.n_entries
        known |= {observation.group, *labels}
        held += [observation.group in wanted or label in wanted for label in labels]
    unknown = sorted(wanted - known)
    if unknown:
        raise InputError(f"held_out names {unknown}; expected labels or groups of the observations; correct them")
    if all(held):
        raise InputError("held_out names every reading; expected some left to fit; hold out fewer")
    return np.array(held)


def _prior_residuals(parameters: Sequence[Parameter], place: FloatArray) -> FloatArray:
    rows = zip(parameters, place, strict=True)
    return np.array(
        [(x - p.coordinate(p.prior_mean)) / p.prior_sd for p, x in rows if p.prior_mean is not None and p.prior_sd]
    )


def _prior_gradient(parameters: Sequence[Parameter]) -> FloatArray:
    slopes = np.diag([0.0 if p.prior_sd is None else 1.0 / p.prior_sd for p in parameters])
    return np.asarray(slopes[[k for k, p in enumerate(parameters) if p.prior_sd is not None]])


def _limit(parameter: Parameter, place: float) -> str:
    low, high = parameter.coordinate(parameter.lower), parameter.coordinate(parameter.upper)
    near = AT_LIMIT * (high - low)
    return "lower" if place - low < near else "upper" if high - place < near else ""


def _covariance(parameters: Sequence[Parameter], place: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return (J'J)^-1 over the parameters inside their ranges; a direction that no reading sees has no finite sd."""
    inside = np.array([not _limit(p, float(x)) for p, x in zip(parameters, place, strict=True)])
    covariance = np.zeros((len(parameters), len(parameters)))
    square = gradient[:, inside].T @ gradient[:, inside]
    if inside.any():
        if np.linalg.matrix_rank(square, hermitian=True) < len(square):
            unseen = [p.name for p, i in zip(parameters, inside, strict=True) if i]
            raise SolveError(
                f"the readings do not settle the parameters {unseen} together; expected as many independent readings; "
                "give a prior or fix one"
            )
        covariance[np.ix_(inside, inside)] = np.linalg.inv(square)
    return covariance
