"""A structure of shells, beams, a mass and a spring as a CalculiX deck: what is written, and what CalculiX finds."""

from itertools import pairwise

import numpy as np
import pytest

from benchmarks.ccx import has_ccx, run_deck
from femlib.errors import InputError
from femlib.export.calculix_results import read_displacements, read_frequencies
from femlib.sensors import StrainGauge
from femlib.structure import Spring, Structure, read, rectangular_beam
from femlib.structure.calculix import read_gauges, write_deck
from tests.test_femlib.own_meshes import ALUMINIUM, corner_spring, plate_mesh, plate_with_mast

GAUGES = [
    StrainGauge("middle", (0.3, 0.2, 0.0), (1, 0, 0), ("skin",)),
    StrainGauge("slanted", (0.2, 0.3, 0.0), (1, 1, 0), ("skin",), side=-1.0),
]


def test_a_deck_has_every_part(tmp_path):
    plate = plate_with_mast(springs=(corner_spring(),), damage=("mast", "foot"))
    write_deck(plate, tmp_path / "own.inp", {"mast": 0.5, "foot": 0.25}, plate.gravity(), GAUGES)
    lines = (tmp_path / "own.inp").read_text().splitlines()
    after = dict(pairwise(lines))
    assert after["*MASS, ELSET=MASS37"] == "5.000000000e-01"
    assert lines[lines.index("*MATERIAL, NAME=BEAM1") + 2].startswith("3.5")
    assert lines[next(k for k, line in enumerate(lines) if line.startswith("*SPRING,")) + 2] == "1.500000000e+04"
    assert sum(line.startswith("*ELEMENT, TYPE=B32") for line in lines) == 2


@pytest.mark.parametrize("wrong", ["section", "spring"])
def test_a_part_that_a_deck_cannot_hold_is_refused(wrong, tmp_path):
    beam = rectangular_beam(70e9, 0.33, 0.01, 0.02, (1, 0, 0), 2700.0, offset=(0.0, 0.1, 0.0))
    plate = (
        plate_with_mast(sections={"skin": ALUMINIUM, "mast": beam})
        if wrong == "section"
        else plate_with_mast(springs=(Spring("tie", "top", 1e3, to="corner"),))
    )
    with pytest.raises(InputError, match="expected one"):
        write_deck(plate, tmp_path / "own.inp", {}, plate.gravity())


@pytest.mark.skipif(not has_ccx(), reason="CalculiX (ccx) is not installed")
def test_calculix_finds_the_same_motion_strains_and_frequencies(tmp_path):
    beam = rectangular_beam(70e9, 0.33, 0.01, 0.02, (1, 0, 0), 2700.0)
    plate = Structure(
        read(plate_mesh(n_x=18, n_y=12)),
        {"skin": ALUMINIUM, "mast": beam},
        {"left": "clamped"},
        ("middle", "mast", "foot"),
        {"top": 0.5},
        (corner_spring(),),
    )
    state = {"middle": 0.5, "mast": 0.6, "foot": 0.3}
    load = plate.pressure("skin", 100.0) + plate.point_load("top", (1.0, 2.0, 0.0))
    write_deck(plate, tmp_path / "own.inp", state, load, GAUGES)
    run_deck(tmp_path / "own.inp")
    # The mesh is coarse (3.4 % by its estimate): the same mesh is compared, not the plate.
    ours = plate.solve(state, load, limit=0.05)[:, :3]
    theirs = read_displacements(tmp_path / "own.frd", len(plate.mesh.nodes))
    off = np.abs(ours - theirs)[:-2].max()  # a mast turns its corner of a coarse plate as each mesh pleases
    assert off < 0.01 * np.abs(theirs).max()
    ours, theirs = (
        plate.strain_microstrain(state, load, GAUGES, limit=0.05),
        read_gauges(plate, tmp_path / "own.dat", GAUGES),
    )
    assert np.abs(ours - theirs).max() < 0.02 * np.abs(theirs).max()
    write_deck(plate, tmp_path / "own.inp", state, load, analysis="frequencies", n_modes=2)
    run_deck(tmp_path / "own.inp")
    found = read_frequencies(tmp_path / "own.dat")
    # in CalculiX a lone beam on a shell turns freely about the shell's normal
    assert plate.natural_modes(1, state)[0].frequency == pytest.approx(found[found > 0.1][0], rel=0.01)
