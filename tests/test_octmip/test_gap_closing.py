"""A cause closes the gap of readings to which its size was not fitted, or it is none."""

import math

import numpy as np
import pytest

from octmip.gap import CHAIN, diagnose, sizes
from octmip.gap.causes import _closes, _left_by
from octmip.gap.inference.candidates import Candidate
from octmip.gap.inference.inference import Inference, Judged
from octmip.gap.inference.inputs import prepare
from octmip.gap.inference.linear_model import linearise
from octmip.gap.shrinkage import Shrinkage, measure_shrinkage
from octmip.gap.sizes import _exact, parameters
from tests.test_octmip.beam_twin import ETA, Beam, Bumps, Field, measured

RUN = measured(1000)
SHAPE = np.linspace(-4.0, -1.0, 20)


def closing(closed: float, chi2_before: float, floor: float = 0.0) -> Shrinkage:
    """Return a closing of readings whose chi-squared falls to 1 per reading."""
    return Shrinkage(100.0, 10.0, floor, closed, closed, closed, (), chi2_before, 1.0, 0.5)


def test_a_cause_that_closes_all_of_a_gap_loses_nothing_and_one_that_closes_half_of_it_nearly_all():
    clear = 1.0 + 40.0**2 / 80  # d' = 40 in 80 readings
    assert _closes(closing(1.0, clear), 80) == 1.0
    assert _closes(closing(1.1, clear), 80) == 1.0
    spread = math.hypot(0.04, 1.5 / 40.0)
    expected = math.exp(-0.5 * (0.3 / spread) ** 2) / (spread * math.sqrt(2.0 * math.pi))
    assert _closes(closing(0.7, clear), 80) == pytest.approx(expected)
    assert expected < 1e-4
    assert _closes(closing(0.7, clear), 80, left=0.04) == pytest.approx(expected)
    # a large deflection: the wing's other models differ so far
    assert _closes(closing(0.7, clear), 80, left=0.36) > 0.5
    # a flaw whose trace is known to 40 %: some panel that buckles closes two thirds
    assert _closes(closing(0.92, clear), 80, left=0.16) == 1.0
    assert _closes(closing(0.63, clear), 80, left=0.16) < 0.2


@pytest.mark.parametrize(("power", "left"), [(1, 0.16), (0, 0.16), (2, 0.64), (None, 0.64)])
def test_an_effect_of_a_linear_structure_leaves_no_more_than_the_square_of_its_error(power, left):
    assert _left_by(Candidate(Field("flaw", SHAPE, power, 1.0, signature_error=0.4), "", 1.0)) == pytest.approx(left)


def test_a_gap_that_twin_and_asset_differ_by_says_little_of_how_far_a_cause_closes_it():
    clear = 1.0 + 40.0**2 / 80
    assert _closes(closing(0.3, clear), 80) < 1e-9
    assert _closes(closing(0.3, clear, floor=67.0), 80) > 0.6
    assert _closes(closing(-0.8, clear, floor=20.0), 80) < 1e-9


def test_a_faint_gap_says_little_of_how_far_it_closes_and_one_that_is_not_clear_nothing():
    assert _closes(closing(0.7, 1.0 + 4.0**2 / 80), 80) > 0.5
    assert _closes(closing(math.nan, 3.0), 80) == 1.0
    assert _closes(None, 80) == 1.0


def inference_of(campaign, *effects):
    """Return the inference of a campaign with more effects, and the numbers of their candidates."""
    names = {effect.name: effect for effect in effects}
    inputs, _ = prepare(campaign, Beam(), {**CHAIN, **names}, RUN)
    inference = Inference(linearise(inputs, np.array([cell.state for cell in campaign.cells])))
    return inference, tuple(k for k, c in enumerate(inputs.candidates) if c.name in names)


class AtTheTop(Field):
    """A field that is there at the greatest load alone."""

    def signature(self, twin, state, load_factor, place="", time=0.0):
        return self.shape * (load_factor > 2.5)


def test_a_load_without_which_nothing_says_how_large_an_effect_is_is_not_held_out():
    effect = AtTheTop("stop", SHAPE, None, 10.0)
    campaign = measured(3, lambda state, load, time: 12.0 * SHAPE * (load > 2.5))
    inference, (j,) = inference_of(campaign, effect)
    held = [part.name for part in measure_shrinkage(inference, (j,)).held_out]
    assert held == ["load factor 0", "load factor 1", "load factor 2"]


def test_a_load_without_which_two_effects_are_one_is_not_held_out():
    """Each alone is known from the one load that is left, both together are not."""
    soak, warm = Field("soak", SHAPE, 1, 10.0), Field("warm", 0.2 * np.arange(20.0) - 5.0, 0, 10.0)
    campaign = measured(3, lambda state, load, time: 12.0 * SHAPE * load + 10.0 * warm.shape, loads=(0.0, 3.0))
    inference, both = inference_of(campaign, soak, warm)
    assert measure_shrinkage(inference, both).held_out == ()
    assert [part.name for part in measure_shrinkage(inference, both[:1]).held_out] == ["load factor 0"]


def test_an_effect_whose_course_over_the_load_is_another_is_called_unexplained():
    """A size that is fitted to some loads does not fit the others, though the best of the library is far ahead."""
    late = lambda state, load, time: 10.0 * SHAPE * load**3 / 9.0  # noqa: E731
    library = {"soak": Field("soak", SHAPE, 1, 10.0)}
    assert "unknown" in diagnose(measured(3, late), Beam(), library, commissioning=RUN).which[0].effects


def test_a_signature_may_be_known_better_at_one_reading_than_at_another():
    effect = Field("soak", SHAPE, 1, 10.0, signature_error=np.repeat([0.0, 0.5], 10))
    campaign = measured(3, lambda state, load, time: 12.0 * SHAPE * load)
    inference, (j,) = inference_of(campaign, effect)
    error = np.diag(inference._errors((j,), np.array([12.0]), 1.0)[0])
    assert not error[inference.model.gauge < 10].any()
    assert (error[(inference.model.gauge >= 10) & (np.array(inference.model.loads) > 0.0)] > 0.0).all()


class Softer(Field):
    """All strains divided by 1 + size / 100."""

    def predict(self, twin, state, load_factor, size, place, time):
        return twin.predict(state, load_factor) / (1.0 + 0.01 * size)


class Taller(Bumps):
    """The taller, the further outboard."""

    power = 3


def first_parameter(effect, change):
    twin = Beam(effects={effect.name: effect})
    first = diagnose(measured(3, change), twin, commissioning=RUN).which[0]
    assert first.effects[0] == effect.name
    return first.parameters[0]


def test_an_exact_size_fits_the_readings_best_and_its_interval_holds_the_one_that_leads(monkeypatch):
    """From the linear fit of a strain that is divided by 1 + size / 100."""
    softer = Softer("modulus", np.full(20, -0.01), None, 4.0)
    campaign = measured(3, lambda state, load, time: Beam().predict(state, load) * (1 / 1.2 - 1))
    inputs, _ = prepare(campaign, Beam(), {"modulus": softer}, RUN)
    model = linearise(inputs, np.zeros((4, 2)))
    head = Judged((0,), False, 0.0, Inference(model), probability=1.0)
    shown, plain = model.rows.predicted, float(head.fit.size[0])
    tried = np.linspace(10.0, 30.0, 2001)
    left = [np.linalg.norm(model.whiten(model.residual + shown - shown / (1.0 + 0.01 * size))) for size in tried]
    size, stretch = _exact(head, 0, plain)
    assert abs(plain - 20.0) > 2.0
    assert size == pytest.approx(tried[np.argmin(left)], abs=0.05)
    assert stretch == pytest.approx((1.0 + 0.01 * size) ** 2, rel=0.15)  # of the slope about none and there
    for mean in (plain - 3.0, plain + 3.0):
        monkeypatch.setattr(sizes, "_mixture", lambda *_, mean=mean: (mean, 0.01))
        (own,) = parameters(head, [head])
        assert own.low <= size <= own.high
        assert own.high - own.low > 3.0


def test_the_interval_of_a_size_reckons_with_the_place_between_two_places():
    size = first_parameter(
        Taller("bump", ETA, 1, 400.0), lambda state, load, time: 900.0 * Taller.at(0.40, load)
    )  # places at 0.35 and 0.45
    assert size.low < 900.0 < size.high
