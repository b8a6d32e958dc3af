"""The next test: its expected information about the open question, per unit of cost.

For a strain test the hypotheses predict normal readings N_i; the mutual information between hypothesis and reading is
at least

    - sum_i p_i log sum_j p_j exp(-B_ij),     B_ij the Bhattacharyya distance of N_i and N_j

(Kolchinsky and Tracey (2017), "Estimating mixture entropy with pairwise distances", Entropy 19, eq. 10 at alpha =
1/2; the choice by expected information is Lindley's (1956), Ann. Math. Statist. 27). A test of another kind (a load
cell, a shunt) answers yes or no about the effects it sees; its information is the entropy of that answer, times its
reliability.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from octmip.errors import DataError, TwinError
from octmip.gap.campaign.campaign import Campaign
from octmip.gap.effects import in_chain
from octmip.gap.inference.candidates import Candidate, gauges_of
from octmip.gap.inference.evidence import Fit
from octmip.gap.inference.inference import Judged
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel, difference_at
from octmip.twin import MICROSTRAIN, Load, amounts_of, load_of

Floats = NDArray[np.float64]

MOST_HYPOTHESES = 16
"""Hypotheses that compete for the next test."""
REPEATS = 50
"""Repeats of a proposed strain test."""
MOST_REPEATED = 6
"""Of several loads, about so many settings are looked at for a test that repeats them."""
MOST_OF_CORNERS = 3
"""Loads whose corners are looked at."""
RELIABLE = 0.9
"""Share of a perfect answer's information that a test outside the strain gauges gives."""
SETTLED = 0.15
"""Entropy [nats] of the hypotheses below which no test is needed."""
WORTH = 0.05
"""Expected information [nats] below which a test is not proposed."""


@dataclass(frozen=True, slots=True)
class Proposal:
    """A test that is worth running.

    Attributes
    ----------
    name
        in snake_case.
    words
        what to do.
    information
        expected information [nats] about which hypothesis holds.
    cost
        relative to one strain test at a load that was flown before.
    is_strain_test
        whether the strain gauges alone answer it.
    load, gauge
        at which it reads, and of which a second instrument is needed; None and "" otherwise.
    """

    name: str
    words: str
    information: float
    cost: float
    is_strain_test: bool
    load: Load | None = None
    gauge: str = ""

    @property
    def value(self) -> float:
        """Information per cost."""
        return self.information / self.cost


OTHER_TESTS = {
    "applied_load": Proposal("load_cell", "check the load with a second load cell or a known mass", 0.0, 1.0, False),
    "shunt_reading": Proposal("shunt_calibration", "shunt-calibrate the bridges", 0.0, 0.5, False),
    "channel_order": Proposal(
        "tap_test", "warm or press one gauge after the other and see which channel answers", 0.0, 0.3, False
    ),
    "gauge_placement": Proposal(
        "gauge_survey", "measure place and angle of the gauge on the structure", 0.0, 0.5, False
    ),
    "deflection": Proposal("tip_deflection", "measure the tip deflection under a known load", 0.0, 1.5, False),
    "frequency": Proposal("frequency", "measure the first natural frequencies", 0.0, 3.0, False),
    "thermal_zero": Proposal("thermal_soak", "repeat the zero-load reading at another temperature", 0.0, 5.0, False),
}
"""Tests outside the strain gauges, by the quantity that they measure (`octmip.twin.QUANTITIES`).

They see the effects whose `seen_by` names it."""


Limits = tuple[float, float]
"""The lowest and the highest load that the structure may be tested at."""


def checked_limits(limits: Limits | None) -> Limits | None:
    """Return limits of the load.

    Raises
    ------
    DataError
        the lowest is not below the highest.
    """
    if limits is not None and not limits[0] < limits[1]:
        raise DataError(
            f"the limits of the load are {limits[0]:g} to {limits[1]:g}; expected the lowest first, then the highest; "
            "give for instance -1.0 and 3.5"
        )
    return limits


def next_tests(model: LinearModel, judged: Sequence[Judged], limits: Limits | None) -> tuple[Proposal, ...]:
    """Return the tests worth running, best value first; none when little uncertainty remains.

    Within `limits` of the load where they are given; a campaign of several loads repeats what was applied.
    """
    if judged and not judged[0].members and not judged[0].has_unknown:
        return ()  # sound: what competes with it is too small to name
    open_ones = [h for h in judged[:MOST_HYPOTHESES] if not h.has_unknown and h.probability > 1e-3]
    weight = np.array([h.probability for h in open_ones])
    if not len(weight) or _entropy(weight / weight.sum()) < SETTLED:
        return ()
    weight = weight / weight.sum()
    fits = [h.fit for h in open_ones]
    proposals = [*_strain_tests(model, fits, weight, limits), *_other_tests(model.inputs, fits, weight)]
    return tuple(sorted((p for p in proposals if p.information > WORTH), key=lambda p: -p.value))


def _strain_tests(model: LinearModel, fits: Sequence[Fit], weight: Floats, limits: Limits | None) -> list[Proposal]:
    """Return tests at other loads; one at a load that the twin refuses, as a table does beyond its rows, is none."""
    found = []
    for load, words, cost in _loads_to_test(model.inputs.campaign, limits):
        try:
            information = _strain_information(model, fits, weight, load)
        except TwinError:
            continue
        found.append(Proposal(f"load_{load:g}", words, information, cost, True, load))
    return found


def _loads_to_test(campaign: Campaign, limits: Limits | None) -> list[tuple[Load, str, float]]:
    """Return loads worth a test, with what to do and what it costs; of several loads those that were applied."""
    if len(campaign.load_names) != 1:
        every = campaign.loads[:: max(1, len(campaign.loads) // MOST_REPEATED)]
        repeated = [
            (load, f"repeat {campaign.load_words(load) or 'the test'} with {REPEATS} readings", 1.0) for load in every
        ]
        return [*repeated, *((load, f"set {campaign.load_words(load)}", 2.0) for load in _new_settings(campaign))]
    top = max(abs(amounts_of(load)[0]) for load in campaign.loads) or 1.0
    words = campaign.load_words
    low, high = limits or (-1.0, 1.5 * top)
    hint = "" if limits else ", if the structure allows it"
    tests: list[tuple[Load, str, float]] = []
    if low <= 0.0 <= high:
        tests.append((0.0, "read all gauges at zero load", 0.5))
    if low < 0.0:
        back = max(low, -1.0)
        tests.append((back, f"load the structure the other way, {words(back)}{hint}", 3.0))
    if high >= top:
        tests.append((top, f"repeat {words(top)} with {REPEATS} readings", 1.0))
    if high > top:
        more = min(high, 1.5 * top)
        tests.append((more, f"go to {words(more)}{hint}", 2.0))
    return tests


def _new_settings(campaign: Campaign) -> list[Load]:
    """Return settings of several loads that were not read: corners of what was, and half of the least of all."""
    if not campaign.load_names:
        return []
    applied = np.array([amounts_of(load) for load in campaign.loads])
    least, most = applied.min(axis=0), applied.max(axis=0)
    corners = [*product(*zip(least.tolist(), most.tolist(), strict=True))] if len(least) <= MOST_OF_CORNERS else []
    wanted = [*corners, *([tuple((0.5 * least).tolist())] if (least > 0.0).all() else [])]
    known = {tuple(row) for row in applied.tolist()}
    return [load_of(campaign.load_names, point) for point in dict.fromkeys(wanted) if point not in known]


def _other_tests(inputs: Inputs, fits: Sequence[Fit], weight: Floats) -> list[Proposal]:
    """Return tests that other instruments answer: a bridge is shunted, what reads no strain has a second beside it."""
    candidates = inputs.candidates
    found = []
    for quantity, test in OTHER_TESTS.items():
        answers = [
            frozenset(candidates[j].name for j in fit.members if _is_seen(inputs, candidates[j], quantity))
            for fit in fits
        ]
        found.append(replace(test, information=RELIABLE * _answer_entropy(answers, weight)))
    for gauge, unit in zip(inputs.campaign.gauges, inputs.units, strict=True):
        if unit != MICROSTRAIN:
            answers = [
                frozenset([gauge] if any(gauge in _instruments(inputs, candidates[j]) for j in fit.members) else [])
                for fit in fits
            ]
            words = f"read {gauge} with a second instrument"
            information = RELIABLE * _answer_entropy(answers, weight)
            found.append(Proposal("second_instrument", words, information, 1.0, False, gauge=gauge))
    return found


def _is_seen(inputs: Inputs, candidate: Candidate, quantity: str) -> bool:
    """Return whether a test shows an effect: one of bridges where it acts on a strain gauge."""
    if quantity not in getattr(candidate.effect, "seen_by", ()):
        return False
    units = dict(zip(inputs.campaign.gauges, inputs.units, strict=True))
    own = [units[name] for name in _instruments(inputs, candidate) if name in units]
    return not own or MICROSTRAIN in own


def _instruments(inputs: Inputs, candidate: Candidate) -> Sequence[str]:
    """Return the gauges whose instrument an effect acts on; none of what the structure or a load does."""
    if not in_chain(candidate.effect) or getattr(candidate.effect, "seen_by", ()) == ("applied_load",):
        return ()
    return gauges_of(candidate.effect, inputs.twin, candidate.place)


def _answer_entropy(answers: Sequence[frozenset[str]], weight: Floats) -> float:
    return _entropy(np.array([float(weight[[a == b for b in answers]].sum()) for a in dict.fromkeys(answers)]))


def _entropy(weight: Floats) -> float:
    positive = weight[weight > 0.0]
    return float(-np.sum(positive * np.log(positive)))


def _strain_information(model: LinearModel, fits: Sequence[Fit], weight: Floats, load: Load) -> float:
    """Return the lower bound on the information of a strain test at a load, in the first cell's state."""
    inputs = model.inputs
    rows = {j: _row(model, j, load) for j in sorted({j for fit in fits for j in fit.members})}
    repeats = np.full(len(inputs.order), REPEATS)
    difference = difference_at(inputs, load, inputs.named(model.states[0]), model.level)[1]
    noise = inputs.noise.of_mean(repeats, load) + difference
    columns = [np.array([rows[j] for j in f.members]).reshape(-1, len(repeats)) for f in fits]
    means = [own.T @ f.size for own, f in zip(columns, fits, strict=True)]
    spreads = [noise + own.T @ f.covariance @ own for own, f in zip(columns, fits, strict=True)]
    logs = [np.linalg.slogdet(s)[1] for s in spreads]
    near = np.array([[_overlap(means, spreads, logs, i, j) for j in range(len(fits))] for i in range(len(fits))])
    return float(-np.sum(weight * np.log(near @ weight)))


def _row(model: LinearModel, member: int, load: Load) -> Floats:
    """Return what a unit of a member changes (n_gauges,) at a load, in the first cell's state, at the end.

    At the size of its chord, where the model has one: two effects that change all readings alike at their sizes would
    seem to differ by their slopes.
    """
    inputs, one, size = model.inputs, model.inputs.candidates[member], model.chords.get(member, 0.0)
    if one.test not in ("", inputs.last_test):
        return np.zeros(len(inputs.order))
    state, time = inputs.named(model.states[0]), max(average.time for average in inputs.averages)
    found = inputs.twin.signatures(one.effect, (one.place,), state, load, time)[0]
    if one.forward is not None and size and found.any() and one.name not in inputs.open:
        there = np.asarray(one.forward(inputs.twin, state, load, size, one.place, time))
        found = (there - inputs.twin.predict(state, load)) / size
    return np.asarray(found[list(inputs.order)])


def _overlap(means: list[Floats], spreads: list[Floats], logs: list[float], i: int, j: int) -> float:
    """Return exp(-B_ij)."""
    middle = 0.5 * (spreads[i] + spreads[j])
    apart = means[i] - means[j]
    squared = float(apart @ np.linalg.solve(middle, apart))
    volume = float(np.linalg.slogdet(middle)[1]) - 0.5 * (logs[i] + logs[j])
    return float(np.exp(-squared / 8.0 - 0.5 * volume))
