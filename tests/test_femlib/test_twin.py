"""The reduced wing is a twin as the full one is: the same protocol, the same diagnosis within its bound."""

from pathlib import Path

import numpy as np
import pytest

from femlib.errors import InputError
from femlib.wing import ReducedWing, Wing, WingTwin, saved_twin, uav_wing
from femlib.wing.effects import wing_effects
from octmip.gap import Campaign, Diagnosis, Recorded, diagnose, gathered
from octmip.twin import Effect, Twin, predict_states

LOADS, REPEATS, NOISE = (0.0, 1.0, 2.0, 3.0), 8, 5.0


@pytest.fixture(scope="module")
def full(tiny: Wing) -> WingTwin:
    return WingTwin(tiny, wing_effects(tiny))


@pytest.fixture(scope="module")
def reduced(tiny: Wing, tiny_reduced: ReducedWing, full: WingTwin) -> WingTwin:
    return WingTwin(tiny_reduced, full.effects, lambda: tiny)


def campaign(twin: WingTwin, state: dict[str, float], effect: str, size: float, is_known: bool) -> Campaign:
    """Readings of the full wing with one effect, at all loads."""
    rng = np.random.default_rng(3)
    signature = twin.effects[effect].signature
    means = [twin.predict(state, load) + size * signature(twin, state, load) for load in LOADS]
    noise = NOISE * rng.standard_normal((len(LOADS), REPEATS, len(twin.gauges)))
    told = state if is_known else dict.fromkeys(twin.parameters, np.nan)
    blocks = zip(LOADS, np.array(means)[:, None] + noise, strict=True)
    return gathered(twin, [Recorded(rows, {"load_factor": load}, "T0", told) for load, rows in blocks])


def test_full_and_reduced_wing_answer_by_one_protocol(full: WingTwin, reduced: WingTwin) -> None:
    assert isinstance(full, Twin)
    assert isinstance(reduced, Twin)
    assert all(isinstance(effect, Effect) for effect in reduced.effects.values())
    for name in ("gauges", "parameters", "is_linear_in_load"):
        assert getattr(full, name) == getattr(reduced, name)
    assert np.array_equal(full.gauge_positions, reduced.gauge_positions)
    assert np.array_equal(full.outline, reduced.outline)
    assert full.wing is reduced.wing
    assert full.model.model_hash == reduced.model.model_hash


def test_the_reduced_twin_keeps_its_bound(full: WingTwin, reduced: WingTwin) -> None:
    states = np.random.default_rng(1).uniform(0.0, 0.9, (40, 2))
    gap = np.abs(predict_states(full, states, 3.0) - predict_states(reduced, states, 3.0))
    bound = reduced.error_bound(states, 3.0)
    assert (gap <= bound).all()
    assert bound.max() < 2.0
    assert (full.error_bound(states, 3.0) == 0.0).all()
    assert full.error_bound(states, 3.0).shape == bound.shape
    one = reduced.predict({"mu1": 0.3}, 2.0)
    assert one == pytest.approx(reduced.predict_states(np.array([[0.3, 0.0]]), 2.0)[0])


@pytest.mark.parametrize(
    ("state", "effect", "size", "is_known"),
    [({"mu1": 0.4}, "temperature_gradient", 25.0, True), ({"mu1": 0.3, "mu2": 0.2}, "modulus", 20.0, False)],
    ids=["known state", "unknown state"],
)
def test_a_diagnosis_with_the_reduced_twin_is_that_with_the_full_one(
    full: WingTwin, reduced: WingTwin, state: dict[str, float], effect: str, size: float, is_known: bool
) -> None:
    """Verdict, probabilities and sizes. The twins differ by 0.003 of 3,000 microstrain, the noise is 5."""
    readings = campaign(full, state, effect, size, is_known)
    effects = {name: full.effects[name] for name in ("modulus", "temperature_gradient", "torsion")}
    found = [diagnose(readings, WingTwin(twin.model, effects, twin.make_wing)) for twin in (full, reduced)]
    exact, near = found
    assert exact.is_sound == near.is_sound
    assert _causes(exact) == _causes(near)
    assert effect in _causes(exact)[0]
    assert near.inclusion == pytest.approx(exact.inclusion, abs=2e-3)
    assert near.unknown_probability == pytest.approx(exact.unknown_probability, abs=2e-3)
    for mine, other in zip(exact.which, near.which, strict=True):
        assert other.probability == pytest.approx(mine.probability, abs=2e-3)
    assert _sizes(near) == pytest.approx(_sizes(exact), rel=2e-3, abs=1e-3)


def test_a_saved_twin_answers_at_once_and_makes_the_full_wing_when_it_must(
    tiny: Wing, tiny_reduced: ReducedWing, tmp_path: Path
) -> None:
    made: list[Wing] = []

    def make() -> Wing:
        made.append(tiny)
        return tiny

    tiny_reduced.save(tmp_path / "wing.npz")
    twin = saved_twin(tmp_path / "wing.npz", make)
    assert twin.predict({"mu1": 0.2}, 3.0) == pytest.approx(tiny.strain_microstrain({"mu1": 0.2}, 3.0), abs=0.1)
    assert twin.gauge_positions == pytest.approx(tiny.gauge_positions)
    assert not made
    assert "modulus" in twin.effects
    assert len(twin.effects) == 13
    assert twin.wing is tiny
    assert len(made) == 1
    other = saved_twin(tmp_path / "wing.npz", lambda: uav_wing(refinement=0.25, effective_mass=24.0))
    with pytest.raises(
        InputError, match=r"the reduced wing was made of the wing .*; expected the same; give make_wing"
    ):
        other.wing.outline()
    with pytest.raises(InputError, match="this twin knows only the reduced wing; expected make_wing"):
        WingTwin(tiny_reduced).wing.outline()


def _causes(found: Diagnosis) -> list[tuple[str, ...]]:
    return [cause.effects for cause in found.which]


def _sizes(found: Diagnosis) -> list[float]:
    return [part.size for cause in found.which for part in cause.parameters]
