"""Any shells as a CalculiX deck: what it says, what is refused, and that CalculiX finds the same."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.ccx import has_ccx, run_deck
from benchmarks.shells.curved import scordelis_lo_roof
from femlib.arrays import FloatArray
from femlib.assembly import Shells, Supports, factorise, surface_load
from femlib.errors import InputError
from femlib.export.calculix import Deck, write_deck
from femlib.export.calculix_results import read_buckling_factors, read_displacements, read_frequencies
from femlib.material import Laminate, Ply, isotropic_plate, laminate
from femlib.mesh import DOFS_PER_NODE
from tests.test_femlib.plates import grid_mesh, patch, rotation

PLATE = isotropic_plate(70e9, 0.3, 5e-3, density=2700.0)
CARBON = Ply(140e9, 10e9, 0.3, 5e9, 5e9, 3e9, 1e-3, 0.3, 1600.0)
CROSSED = laminate([CARBON, replace(CARBON, angle=1.2), replace(CARBON, angle=0.3)])
needs_calculix = pytest.mark.skipif(not has_ccx(), reason="CalculiX (ccx) is not installed")


def cantilever(section: Laminate, n: int = 8) -> Deck:
    """Return a strip clamped at one end under a force across its other."""
    mesh = grid_mesh(np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 0.3, 4))
    ones = np.ones(mesh.n_elements)
    shells = Shells(mesh, (section,), np.zeros(mesh.n_elements, dtype=np.int64), ones, np.array([1.0, 0.0, 0.0]))
    supports = Supports.clamping(mesh, np.flatnonzero(mesh.nodes[:, 0] == 0.0))
    return Deck(shells, supports, surface_load(mesh, np.outer(ones, [0.0, 0.0, 100.0])))


def solved(deck: Deck) -> FloatArray:
    """Return femlib's translations (n_nodes, 3)."""
    supports = deck.supports
    factors = factorise(supports.reduce(deck.shells.stiffness()), supports.groups)
    return supports.expand(factors.solve(deck.load[supports.free])).reshape(-1, DOFS_PER_NODE)[:, :3]


def run(deck: Deck, folder: Path) -> None:
    write_deck(deck, folder / "a.inp")
    run_deck(folder / "a.inp")


@needs_calculix
@pytest.mark.parametrize(
    ("section", "close"),
    # contraction: a clamped edge of CalculiX's hinders it through the thickness too, 2 % here and less on a finer mesh
    [(isotropic_plate(70e9, 0.0, 5e-3), 0.006), (PLATE, 0.025), (CROSSED, 0.02)],
)
def test_calculix_bends_the_same_strip(section: Laminate, close: float, tmp_path: Path) -> None:
    deck = cantilever(section)
    run(deck, tmp_path)
    theirs, ours = read_displacements(tmp_path / "a.frd", len(deck.shells.mesh.nodes)), solved(deck)
    assert np.abs(ours - theirs).max() < close * np.abs(theirs).max()


@needs_calculix
def test_calculix_has_the_roof_that_symmetry_holds(tmp_path: Path) -> None:
    roof = scordelis_lo_roof(16)
    run(Deck(roof.shells, roof.supports, roof.load), tmp_path)
    moved = np.zeros((len(roof.shells.mesh.nodes), DOFS_PER_NODE))
    moved[:, :3] = read_displacements(tmp_path / "a.frd", len(moved))
    assert roof.ratio(moved.ravel()) == pytest.approx(1.0, abs=0.01)


def test_two_rotations_held_obliquely_are_refused() -> None:
    shells = patch(PLATE, "quad4", rotation(2))
    supports = Supports.holding(shells.mesh, [0, 1, 2, 3, 4, 6, 7, 8, 18, 19, 20])
    deck = Deck(shells, supports, np.zeros(shells.mesh.n_dofs))
    with pytest.raises(InputError, match="node 0 holds two rotations that are oblique to the shell there"):
        deck.lines()


WRONG = [
    (lambda d: replace(d, analysis="buckle"), r"analysis is 'buckle'; expected one of \['linear', "),
    (lambda d: replace(d, n_modes=0), "n_modes is 0; expected a whole number from 1"),
    (lambda d: replace(d, load=np.zeros(3)), r"load has shape \(3,\)"),
    (lambda d: replace(d, factor=np.ones(3)), r"factor has shape \(3,\)"),
    (lambda d: replace(d, supports=cantilever(PLATE, 4).supports), "supports have 120 degrees of freedom; expected"),
    (lambda d: replace(d, temperature=(1.0, np.nan)), "temperature is .*; expected .K. and .K/m."),
    (lambda d: cantilever(replace(PLATE, plies=())).lines(), "laminate 0 has no plies; expected them"),
    (
        lambda d: cantilever(replace(PLATE, bending=2 * PLATE.bending)).lines(),
        "another bending stiffness than its plies",
    ),
    (
        lambda d: cantilever(laminate([Ply(70e9, 60e9, 0.8, 20e9, 20e9, 20e9, 1e-3)])).lines(),
        "ply 0 of laminate 0 has no stable solid with nu_13",
    ),
]


@pytest.mark.parametrize("case", range(len(WRONG)))
def test_a_wrong_deck_gets_a_sentence(case: int) -> None:
    ask, sentence = WRONG[case]
    with pytest.raises(InputError, match=sentence):
        ask(cantilever(PLATE))


def test_a_wrong_result_gets_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.frd"
    with pytest.raises(InputError, match=r"a.frd cannot be read .*; run the deck"):
        read_displacements(path, 2)
    path.write_text(" -4  DISP        4    1\n -1         1 1.00000E+00 2.00000E+00 3.00000E+00\n")
    assert read_displacements(path, 1).tolist() == [[1.0, 2.0, 3.0]]
    with pytest.raises(InputError, match=r"has no displacement of node 2; expected 2 nodes"):
        read_displacements(path, 2)
    path.write_text(" -4  DISP        4    1\n -1         1 1.00000E+00 two 3.00000E+00\n")
    with pytest.raises(InputError, match=r"line 2: .* is no row of displacements"):
        read_displacements(path, 1)
    with pytest.raises(InputError, match=r"has no table 'E I G E N"):
        read_frequencies(path)
    path.write_text("B U C K L I N G   F A C T O R   O U T P U T\n 1 x\n")
    with pytest.raises(InputError, match=r"has a number that is none"):
        read_buckling_factors(path)
