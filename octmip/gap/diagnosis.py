"""Diagnosis of a campaign: where the gap lies, which effects explain it, how far it closes, what to test next."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from threadpoolctl import threadpool_limits

from octmip.gap.campaign.campaign import Campaign
from octmip.gap.campaign.metered import gathered_alike
from octmip.gap.campaign.noise import Noise
from octmip.gap.causes import (
    UNKNOWN,
    Cause,
    ConfoundedEffects,
    causes_of,
    credible_set,
    with_identifiable,
    with_imitations,
    with_misfit,
)
from octmip.gap.constants import Constant, constants_of, constants_words
from octmip.gap.doors.budget import Budget
from octmip.gap.doors.function import FunctionTwin
from octmip.gap.effects import in_chain
from octmip.gap.inference.confounding import ABSURD, detectable, ties
from octmip.gap.inference.inference import Judged
from octmip.gap.inference.inputs import WITHOUT_RUN, Inputs
from octmip.gap.inference.linear_model import LinearModel, whole_difference
from octmip.gap.inference.posterior import Posterior, attribute
from octmip.gap.inference.states import joint_covariance, state_posterior
from octmip.gap.inference.wrong_run import weigh_wrong_run
from octmip.gap.location import Where, flips, localise
from octmip.gap.next_test import Limits, Proposal, checked_limits, next_tests
from octmip.gap.odds import Odds
from octmip.gap.preparation import inputs_of, within_budget
from octmip.gap.shrinkage import Shrinkage, measure_shrinkage
from octmip.gap.twins import Addition, AugmentedTwin, CachedTwin
from octmip.input.messages import InWords
from octmip.trees.nodes.tree import Node
from octmip.twin import Effect, Twin

CORRELATED = 0.9
"""Posterior correlation of a damage and an effect beyond which they are not told apart."""
INVISIBLE = 1e6
"""Detectable size over the prior's sd beyond which the signature is zero."""
SOUND_ENOUGH, LIKELY, POSSIBLE = 0.5, 0.5, 0.1
"""Probability that nothing acts beyond which a run is not doubted; that a run was wrong from which it is, or may be."""
BASELINE = "a healthy commissioning run at zero and several other loads would separate them"


@dataclass(frozen=True, slots=True)
class StateEstimate:
    """An unknown damage state as the most probable cause leaves it.

    Attributes
    ----------
    tests
        tests that share it.
    mean, sd
        by parameter, fractions.
    """

    tests: tuple[str, ...]
    mean: Mapping[str, float]
    sd: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Diagnosis(InWords):
    """The result: what the campaign says about the twin.

    Attributes
    ----------
    where
        the gap by gauge, load, test and tree node.
    which
        causes, most probable first.
    shrinkage
        how far the first cause of the library closes the gap (None when it names no effect).
    next_test
        tests worth running, best value first; empty when little uncertainty remains.
    noise
        what the repeats say.
    inclusion
        probability of every effect to be among the causes.
    unknown_probability
        probability that something outside the library acts.
    detectable
        size of every effect that would have been seen with 95 % power, in its unit.
    refused
        effects of which these readings say nothing, with the reason.
    ties
        effects by name that this twin cannot tell apart at the loads and states read, whatever their size.
    states
        unknown states under the first cause.
    notes
        what the reader should know about the data.
    doubts
        what speaks against the commissioning run, as sentences; a run that is not usable was left out.
    constants
        what the readings say of the asset's own constants, where no run does.
    posterior
        all hypotheses.

    Examples
    --------
    >>> twin = function_twin(lambda own, loads: [2.0 * loads["force"]], {"g1": "microstrain"}, loads=["force"])
    >>> rows = np.random.default_rng(0).normal(0.0, 1.0, (20, 1))
    >>> diagnosis = diagnose(gathered(twin, [Recorded(rows + 2.0 * f, {"force": f}) for f in (0, 50, 100)]), twin)
    >>> diagnosis.is_sound, diagnosis.which[0]
    (True, Cause(0.969: nothing acts))
    """

    where: Where
    which: tuple[Cause, ...]
    shrinkage: Shrinkage | None
    next_test: tuple[Proposal, ...]
    noise: Noise
    inclusion: Mapping[str, float]
    unknown_probability: float
    detectable: Mapping[str, float]
    refused: Mapping[str, str]
    states: tuple[StateEstimate, ...]
    notes: tuple[str, ...]
    posterior: Posterior
    doubts: tuple[str, ...]
    ties: tuple[tuple[str, ...], ...]
    constants: tuple[Constant, ...]

    def __repr__(self) -> str:
        """Return the causes that hold 95 % of the probability on one line; all else has its own field."""
        causes = ", ".join(map(repr, self.credible))
        return f"Diagnosis({causes}; unknown: {self.unknown_probability:.3f})"

    def __str__(self) -> str:
        """Return the same, a line for each cause, and the notes."""
        lines = [*map(repr, self.credible), f"something unknown: {self.unknown_probability:.3f}", *self.notes]
        return "\n".join(lines)

    @property
    def ambiguity(self) -> tuple[ConfoundedEffects, ...]:
        """Effects of the first cause that these readings cannot tell from others."""
        return self.which[0].confounded if self.which else ()

    @property
    def is_sound(self) -> bool:
        """Whether no effect and nothing unknown is needed to explain the readings, and no channel stands still."""
        return bool(self.which) and not self.which[0].effects and not self.noise.stuck

    @property
    def nothing_acts(self) -> float:
        """Probability that nothing acts, however faint; the probability of a sound cause is that nothing is seen."""
        silent_ones = (h for h in self.posterior.judged if not h.members and not h.has_unknown)
        return float(sum(h.probability for h in silent_ones))

    @property
    def credible(self) -> tuple[Cause, ...]:
        """The fewest causes that hold 95 % of the probability."""
        return credible_set(self.which)

    def augmented(self, twin: Twin) -> AugmentedTwin:
        """Return the twin with the effects of the first cause, as they were last, and the calibration added."""
        inputs = self.posterior.model.inputs
        parts = list(self.which[0].parameters if self.which else ())
        stays = {(c.name, c.place): c.effect for c in inputs.candidates if c.test in ("", inputs.last_test)}
        parts = [p for p in parts if (p.effect, p.place) in stays]
        level = self.posterior.model.level
        own, sound = twin.twin if isinstance(twin, CachedTwin) else twin, inputs.twin.twin
        if isinstance(own, FunctionTwin) and isinstance(sound, FunctionTwin):
            built = {name: one.nominal for name, one in sound.card.ranges.items()}
            built |= {one.name: one.sound for one in self.constants}
            own = own.at(built, sound.signature_error)
            stays |= {(name, ""): own.effects[name] for name in inputs.open if (name, "") in stays}
        additions = [Addition(stays[p.effect, p.place], p.place, p.size) for p in parts]
        additions.sort(key=lambda addition: in_chain(addition.effect))  # the structure first, the chain last
        difference = None if inputs.run is None else partial(whole_difference, inputs, level)
        return AugmentedTwin(own, tuple(additions), difference)


def diagnose(
    campaign: Campaign,
    twin: Twin,
    effects: Mapping[str, Effect] | None = None,
    commissioning: Campaign | None = None,
    tree: Node | None = None,
    feature_names: Sequence[str] = (),
    noise_sd: float | Mapping[str, float] | None = None,
    odds: Odds = Odds(),  # noqa: B008  (frozen)
    load_limits: Limits | None = None,
    trust_run: bool | None = None,
    budget: Budget | None = None,
) -> Diagnosis:
    """Return where campaign and twin differ, which effects explain it, how far the gap closes, and what to test next.

    Parameters
    ----------
    campaign
        readings of the asset.
    twin
        the model, with the structure's effects in `twin.effects`.
    effects
        the library; None: the measuring chain's effects and the twin's own.
    commissioning
        readings of the same asset while it was known to be sound, in one test or several; measures what twin and
        asset differ by. Tests of it that differ show by how much the campaign's may.
    tree
        a deployed tree, to rank its nodes by flipped decisions.
    feature_names
        the tree's features, names of gauges.
    noise_sd
        standard deviation of one reading in its unit, of all gauges or by gauge, from the instrument's
        card; used where no load was read often enough to estimate the noise.
    odds
        how probable causes are before any reading.
    load_limits
        lowest and highest load that the structure may be tested at: no test beyond them is proposed.
    trust_run
        whether the run is right, whatever it says (True), or is to be left out (False); None: it was wrong with the
        probability `odds.wrong_run`.
    budget
        how often a model behind a door may be asked; None: as often as it takes, some hundred times.

    Raises
    ------
    DataError
        nothing to compare (no repeats at all, a gauge that the twin does not know, a commissioning run that lacks a
        gauge or a known state).

    Examples
    --------
    >>> made, gauges = np.array([9.0, 6.0, 3.0]), dict.fromkeys(["g1", "g2", "g3"], "microstrain")
    >>> twin = function_twin(lambda own, loads: loads["force"] * made, gauges, loads=["force"])
    >>> rows = lambda f: f * made + [0, 40, 0] + np.random.default_rng(f).normal(0, 1, (20, 3))  # g2 reads 40 too high
    >>> diagnose(gathered(twin, [Recorded(rows(f), {"force": f}) for f in (0, 50, 100)]), twin)
    Diagnosis(Cause(0.997: gauge_bias g2 40 microstrain (36.6 to 43.4)); unknown: 0.003)
    """
    checked_limits(load_limits)
    with threadpool_limits(1):  # the matrices are small: threads cost more than they save
        (campaign, *of_run), of_loads = gathered_alike([one for one in (campaign, commissioning) if one is not None])
        commissioning = of_run[0] if of_run else None
        asked, of_budget = within_budget(twin, [one for one in (campaign, commissioning) if one is not None], budget)
        beside = partial(inputs_of, campaign, asked, effects, noise_sd, odds)
        inputs, notes = beside(commissioning if trust_run is not False else None)
        if trust_run is False and commissioning is not None:
            notes = [_NOT_TRUSTED, *(note for note in notes if note != WITHOUT_RUN)]
        without = partial(beside, commissioning, is_right=False) if trust_run is None else None
        posterior, doubts, notes = _beside_doubt(attribute(inputs), notes, without)
        judged = with_imitations(with_identifiable(posterior.judged))
        which, closing, unknown_probability = _which(judged)
        model, sizes = posterior.model, detectable(posterior.model)
        constants = constants_of(judged, which[0].parameters if which else ())
        return Diagnosis(
            where=localise(model, flips(model, tree, feature_names) if tree is not None else ()),
            which=which,
            shrinkage=closing,
            next_test=next_tests(model, judged, load_limits),
            noise=model.inputs.noise,
            inclusion=posterior.inclusion(),
            unknown_probability=unknown_probability,
            detectable=sizes,
            refused=_refused(which, model, sizes),
            states=_states(which[0].judged) if which else (),
            notes=(
                *doubts,
                *notes,
                *constants_words(constants, odds.differences.constants),
                *of_budget,
                *of_loads,
                *campaign.notes,
            ),
            posterior=posterior,
            doubts=doubts,
            ties=ties(model),
            constants=constants,
        )


_NOT_TRUSTED = "The commissioning run is left out, as it is not to be trusted (trust_run)."


def _beside_doubt(
    posterior: Posterior,
    notes: list[str],
    without: Callable[[], tuple[Inputs, list[str]]] | None,
) -> tuple[Posterior, tuple[str, ...], list[str]]:
    """Return the posterior beside the run or, where that was probably wrong, without it; the doubt; and notes."""
    inputs = posterior.model.inputs
    sound = sum(h.probability for h in posterior.judged if not h.members and not h.has_unknown)
    if inputs.run is None or without is None or sound > SOUND_ENOUGH:
        return posterior, (), notes
    wrong = weigh_wrong_run(posterior.model)
    probability = 1.0 / (1.0 + math.exp(min(700.0, posterior.log_total + wrong.log_usual - wrong.log_weight)))
    if probability > LIKELY:
        sentence = f"The commissioning run is doubted (probability {probability:.2f}): {wrong.words}; it is left out."
        left, notes = without()
        return attribute(left), (sentence,), notes
    if probability > POSSIBLE:
        sentence = f"The commissioning run may have been wrong (probability {probability:.2f}): {wrong.words}."
        return posterior, (), [sentence, *notes]
    return posterior, (), notes


def _which(judged: Sequence[Judged]) -> tuple[tuple[Cause, ...], Shrinkage | None, float]:
    """Return the causes, how far the first of the library closes the gap, and the probability of the unknown."""
    unknown_probability = float(sum(h.probability for h in judged if h.has_unknown))
    which = causes_of(judged)
    best = next((cause for cause in which if UNKNOWN not in cause.effects), None)
    closing = None
    if best is not None and best.effects:
        closing = measure_shrinkage(best.judged.inference, best.judged.members)
    which, unknown_probability = with_misfit(which, best, closing, unknown_probability)
    return which, closing, unknown_probability


def _states(judged: Judged) -> tuple[StateEstimate, ...]:
    """Return the unknown states as a hypothesis leaves them."""
    inputs = judged.model.inputs
    if not inputs.groups:
        return ()
    mean, covariance = state_posterior(judged.allowing, judged.fit)
    sd = np.sqrt(np.maximum(np.diag(covariance), 0.0)).reshape(len(inputs.groups), -1)
    centre = np.clip(mean, 0.0, 1.0).reshape(len(inputs.groups), -1)
    tests = [tuple(dict.fromkeys(inputs.campaign.cells[c].test for c in group)) for group in inputs.groups]
    rows = zip(tests, centre, sd, strict=True)
    return tuple(StateEstimate(name, inputs.named(middle), inputs.named(spread)) for name, middle, spread in rows)


def _refused(which: Sequence[Cause], model: LinearModel, sizes: Mapping[str, float]) -> dict[str, str]:
    """Return the effects about which the readings are silent, with the reason."""
    weak = _too_weak(model, sizes)
    return weak | _hidden_by_damage(which[0].judged) if which and model.inputs.groups else weak


def _too_weak(model: LinearModel, sizes: Mapping[str, float]) -> dict[str, str]:
    """Return the effects that are far below what could be seen."""
    refused = {}
    effects = {candidate.name: candidate.effect for candidate in model.inputs.candidates}
    for name, size in sizes.items():
        effect = effects[name]
        if size > INVISIBLE * effect.prior_sd:
            refused[name] = f"has no signature in any gauge: {effect.separated_by}"
        elif size > ABSURD * effect.prior_sd and effect.prior_mean == 0.0:
            hidden = "hidden behind the unknown damage" if model.inputs.groups else "too weak in these readings"
            hint = f"; {BASELINE}" if model.inputs.groups else ""
            refused[name] = f"{hidden}: only a size above {size:.3g} {effect.unit} would have been seen{hint}"
    return refused


def _hidden_by_damage(judged: Judged) -> dict[str, str]:
    """Return the effects of a hypothesis whose sizes an unknown damage could make as well."""
    own = judged.fit
    joint = joint_covariance(judged.allowing, own)
    n_open = len(joint) - len(own.members)
    sd = np.sqrt(np.maximum(np.diag(joint), 1e-300))
    correlation = np.abs(joint / np.outer(sd, sd))[n_open:, :n_open].max(axis=1, initial=0.0)
    names = [judged.model.inputs.candidates[j].name for j in own.members]
    pairs = zip(names, correlation, strict=True)
    return {n: f"correlated {c:.2f} with an unknown damage: {BASELINE}" for n, c in pairs if c > CORRELATED}
