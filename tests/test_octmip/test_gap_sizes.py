"""Sizes as they are told: through an exact forward map, and no surer than the place is known."""

import numpy as np

from octmip.gap import diagnose
from tests.test_octmip.beam_twin import ETA, Beam, Bumps, Field, measured

COMMISSIONING = measured(1000)


class Softer(Field):
    """All strains divided by 1 + size / 100."""

    signature_error = 0.0

    def predict(self, twin, state, load_factor, size, place, time):
        return twin.predict(state, load_factor) / (1.0 + 0.01 * size)


class Taller(Bumps):
    """The taller, the further outboard."""

    power = 3


def first_parameter(effect, change):
    twin = Beam(effects={effect.name: effect})
    first = diagnose(measured(3, change), twin, commissioning=COMMISSIONING).which[0]
    assert first.effects[0] == effect.name
    return first.parameters[0]


def test_a_size_goes_through_the_exact_forward_map():
    softer = Softer("modulus", np.full(20, -0.01), None, 4.0)

    def change(state, load, time):
        return Beam().predict(state, load) * (1 / 1.12 - 1)

    chosen = {"modulus": softer}
    first = diagnose(measured(3, change), Beam(effects=chosen), effects=chosen, commissioning=COMMISSIONING).which[0]
    size = first.parameters[0]
    assert size.low < 12.0 < size.high
    assert size.high - size.low < 1.0


def test_the_interval_of_a_size_reckons_with_the_place_between_two_places():
    size = first_parameter(
        Taller("bump", ETA, 1, 400.0), lambda state, load, time: 900.0 * Taller.at(0.40, load)
    )  # places at 0.35 and 0.45
    assert size.low < 900.0 < size.high


def test_every_mean_reading_is_one_entry_although_its_halves_are_fitted_apart():
    where = diagnose(measured(3), Beam(), commissioning=COMMISSIONING).where
    names = [entry.name for entry in where.entries]
    assert len(names) == len(set(names)) == 20 * 4
    z = np.array([entry.z for entry in where.entries])
    assert 0.7 < float(np.sqrt(np.mean(z**2))) < 1.3
