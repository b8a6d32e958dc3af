"""The family of strips against beam theory: bending, Bredt's torsion, heat, and the lifting line."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import benchmarks.blind.assets.beam as package
from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.beam.lift import lifting_line
from benchmarks.blind.assets.beam.section import INNER, airfoil
from benchmarks.blind.assets.beam.strips import Card, Strips

HEALTHY = (0.0, 0.0)


@pytest.fixture(scope="module")
def prism():
    """Return a wing of one chord and one modulus, ten chords long."""
    card = replace(Card(), root_chord=0.4, tip_chord=0.4, span=4.0, taper=1.0, face=0.0)
    return Strips(airfoil(), card, np.linspace(0.0, 1.0, 81))


@pytest.fixture(scope="module")
def asset():
    return BeamAsset(4, n_stations=61)


def whole(strips):
    return np.ones((len(strips.middle), len(strips.section.ends)))


def section_forces(strips):
    """Return E t b of each edge, and the places of its ends [m]."""
    s, card = strips.section, strips.card
    x, z = (card.root_chord * v[s.ends] for v in (s.x, s.z))
    stiff = np.where(s.part == INNER, card.web[0] * card.web[1], card.skin[0] * card.skin[1])
    return stiff * np.hypot(*(np.diff(v)[:, 0] for v in (x, z))), x, z


def second_moment(weight, a, b):
    return float(weight @ (2 * a[:, 0] * b[:, 0] + 2 * a[:, 1] * b[:, 1] + a[:, 0] * b[:, 1] + a[:, 1] * b[:, 0]) / 6)


def test_far_from_its_ends_a_prism_bends_as_a_beam(prism):
    weight, x, z = section_forces(prism)
    mx, mz = (float(weight @ v.mean(axis=1)) / weight.sum() for v in (x, z))
    ixx, izz, ixz = (second_moment(weight, *p) for p in ((x - mx, x - mx), (z - mz, z - mz), (x - mx, z - mz)))
    force = np.zeros(len(prism.eta))
    force[-1] = 100.0
    moved = prism.moved(prism.factors(whole(prism)), prism.lift(force, np.zeros_like(force)))
    boom = np.array([7, 12])
    got = prism.strain(moved, np.array([0.5, 0.5]), boom)
    curvature = np.linalg.solve([[izz, ixz], [ixz, ixx]], [-100.0 * 2.0, 0.0])
    at = 0.4 * np.stack([prism.section.z[boom], prism.section.x[boom]]) - np.array([[mz], [mx]])
    assert got == pytest.approx(curvature @ at, rel=2e-3)


def test_far_from_its_root_a_prism_twists_as_bredt_says(prism):
    s, card = prism.section, prism.card
    shear = np.where(s.part == INNER, *(m * t / 2 / (1 + p) for (m, t), p in zip(
        (card.web, card.skin), (card.web_poisson, card.skin_poisson), strict=True)))  # fmt: skip
    k, l_ = s.ends.T
    flow = 0.4 * np.hypot(s.x[l_] - s.x[k], s.z[l_] - s.z[k]) / shear
    area = 0.16 * (s.z[k] * s.x[l_] - s.x[k] * s.z[l_]) / 2  # swept about the foot of the web's axis, clockwise
    nose, web = (s.chord_fraction < 0.30) & (s.part != INNER), s.part == INNER
    tail = ~nose & ~web
    way = np.where(s.part == 1, -1.0, 1.0)  # along the upper skin, back along the lower one
    areas = [abs((way * area)[cell].sum() + sign * area[web].sum()) for cell, sign in ((nose, 1.0), (tail, -1.0))]
    compliance = [[flow[nose].sum() + flow[web].sum(), -flow[web].sum()],
                  [-flow[web].sum(), flow[tail].sum() + flow[web].sum()]]  # fmt: skip
    flows = np.linalg.solve(compliance, 2.0 * np.array(areas))
    stiffness = 2.0 * float(np.dot(areas, flows))
    turn = np.zeros((len(prism.eta), prism.width))
    turn[-1, -1] = 10.0
    moved = prism.moved(prism.factors(whole(prism)), turn)
    rate = (moved[60, -1] - moved[40, -1]) / (0.25 * card.span)
    assert rate == pytest.approx(10.0 / stiffness, rel=2e-3)


def test_a_wing_of_one_material_only_grows_when_it_is_warm(prism):
    push = prism.heat(1e-4 * whole(prism), whole(prism))
    moved = prism.moved(prism.factors(whole(prism)), push)
    assert prism.strain(moved, np.array([0.3, 0.6]), np.array([7, 12])) == pytest.approx(1e-4, rel=1e-6)


def test_the_lifting_line_of_an_elliptic_wing_is_an_ellipse():
    class Ellipse(Card):
        def chord(self, eta):
            return 0.4 * np.sqrt(1.0 - eta**2)

    eta = np.linspace(0.05, 0.95, 10)
    lift = lifting_line(Ellipse())(eta)
    assert lift / np.sqrt(1.0 - eta**2) == pytest.approx(lift[0] / np.sqrt(1.0 - eta[0] ** 2), rel=1e-6)


def test_damage_sends_strain_around_its_region(asset):
    moved = asset.strain((0.4, 0.0)) - asset.strain(HEALTHY)
    named = dict(zip(asset.gauges, moved.tolist(), strict=True))
    assert named["g02"] > 50.0  # beside region 1, in front of it
    assert named["g19"] < -20.0  # behind its outer edge, in its shadow
    assert abs(named["g12"]) < 1.0


def test_the_strips_share_no_line_with_femlib():
    files = [path for path in Path(package.__path__[0]).glob("*.py") if path.name != "__init__.py"]
    trees = [ast.parse(path.read_text()) for path in files]
    modules = {node.module for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert files
    assert {m for m in modules if m.startswith(("femlib", "octmip"))} == {"femlib.arrays"}
