"""Frequencies and dampings of a free decay, amid hum and a wandering zero."""

import numpy as np
import pytest

from benchmarks.real.decay import decay_of

TIME = np.arange(0.0, 1.6, 0.0005)
DECAY = np.exp(-1.5 * TIME) * np.cos(2 * np.pi * 26.2 * TIME + 0.3)
HIGHER = 0.4 * np.exp(-6.0 * TIME) * np.sin(2 * np.pi * 160.4 * TIME)
HUM = 0.5 * np.sin(2 * np.pi * 60.0 * TIME + 1.0)


def test_a_decay_is_found_amid_hum_and_a_wandering_zero():
    found = decay_of(TIME, DECAY + HIGHER + HUM + 2.0 - 0.7 * TIME, [(15.0, 50.0), (140.0, 300.0)], hum=[60.0])
    assert found.frequencies == pytest.approx([26.2, 160.4], abs=1e-6)
    assert found.dampings == pytest.approx([1.5, 6.0], abs=1e-4)
    assert found.amplitudes == pytest.approx([1.0, 0.4], abs=1e-5)


def test_the_covariance_of_a_decay_is_the_scatter_over_repeats():
    rng = np.random.default_rng(3)
    fits = [decay_of(TIME[::4], (DECAY + 0.2 * rng.standard_normal(len(TIME)))[::4], [(15.0, 50.0)]) for _ in range(60)]
    scatter = np.std([fit.frequencies[0] for fit in fits])
    assert np.mean([fit.frequency_sd[0] for fit in fits]) == pytest.approx(scatter, rel=0.25)


def test_residuals_that_are_alike_widen_the_covariance():
    rng = np.random.default_rng(4)
    white = rng.standard_normal(len(TIME))
    red = np.zeros_like(white)
    for k in range(1, len(red)):
        red[k] = 0.9 * red[k - 1] + np.sqrt(1 - 0.81) * white[k]
    sd = [decay_of(TIME, DECAY + 0.1 * noise, [(15.0, 50.0)]).frequency_sd[0] for noise in (white, red)]
    assert sd[1] > 3.0 * sd[0]
