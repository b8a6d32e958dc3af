"""Damage through ports is the full model, state by state."""

from dataclasses import replace

import numpy as np
import pytest

from femlib.assembly import factorise
from femlib.components import Component, DamagedStructure, port_flexibility
from femlib.wing import Wing

STATES = np.array([[0.0, 0.0], [0.8, 0.0], [0.0, 0.4], [0.6, 0.999]])


def full_solution(structure: DamagedStructure, mu: np.ndarray, load: np.ndarray) -> np.ndarray:
    supports = structure.supports
    factors = factorise(structure.stiffness(mu), supports.groups)
    return supports.expand(factors.solve(load[supports.free]))


def test_many_states_at_once_are_those_of_new_factorisations(coarser: Wing) -> None:
    rng = np.random.default_rng(2)
    states = np.concatenate([STATES, rng.uniform(0.0, 0.95, (6, 2))])
    load = coarser.lift + 0.1 * rng.normal(size=coarser.lift.shape)
    fresh = replace(coarser.structure)
    moved = fresh.solve(states, load)
    assert fresh.eliminated((0, 1)).ports.is_diagonal
    for mu, displacement in zip(states[-3:], moved[-3:], strict=True):
        full = full_solution(coarser.structure, mu, load)
        assert np.abs(displacement - full).max() < 1e-8 * np.abs(full).max()


def test_regions_that_touch_are_solved_without_a_spectrum(coarser: Wing) -> None:
    first = coarser.structure.components[0].elements
    half = np.cumsum(first) <= first.sum() // 2
    parts = (Component("a", "a", first & half), Component("b", "b", first & ~half))
    structure = DamagedStructure(coarser.structure.shells, coarser.structure.supports, parts)
    states = np.random.default_rng(4).uniform(0.0, 0.9, (6, 2))
    moved = structure.solve(states, coarser.lift)
    assert not structure.eliminated((0, 1)).ports.is_diagonal
    full = full_solution(structure, states[-1], coarser.lift)
    assert np.abs(moved[-1] - full).max() < 1e-8 * np.abs(full).max()


def test_stiffness_is_affine_symmetric_and_positive_definite_in_every_state(coarser: Wing) -> None:
    structure = coarser.structure
    none, first, half = (structure.stiffness(np.array([a, 0.0])) for a in (0.0, 0.8, 0.4))
    assert abs(0.5 * (none + first) - half).max() < 1e-9 * abs(none).max()
    rng = np.random.default_rng(0)
    for mu in STATES:
        matrix = structure.stiffness(mu)
        assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
        trial = rng.normal(size=(matrix.shape[0], 5))
        assert (np.einsum("ik,ik->k", trial, matrix @ trial) > 0).all()
    assert np.linalg.eigvalsh(structure.eliminated((0, 1)).ports.schur).min() > 0


def test_the_structure_at_its_ports_is_the_condensed_structure(coarser: Wing) -> None:
    rng = np.random.default_rng(1)
    load = coarser.lift + 0.1 * rng.normal(size=coarser.lift.shape)  # loads inside the regions too
    ports = port_flexibility(coarser.structure, load, 1e6 * coarser.strain_rows, coarser.gauges.names)
    full = 1e6 * coarser.structure.solve_outputs(STATES[:3], load, coarser.strain_rows)
    assert ports.solve(STATES[:3]) == pytest.approx(full, abs=1e-7 * np.abs(full).max())
    assert ports.own.min() > 0.0
    assert ports.own.max() < 1.0
    assert np.array_equal(ports.across, ports.across.T)


def test_a_structure_without_components_has_no_ports(coarser: Wing) -> None:
    bare = DamagedStructure(coarser.structure.shells, coarser.structure.supports, ())
    ports = port_flexibility(bare, coarser.lift, 1e6 * coarser.strain_rows, coarser.gauges.names)
    assert ports.solve(np.zeros((1, 0)))[0] == pytest.approx(coarser.strain_microstrain({}, 1.0), rel=1e-8)
