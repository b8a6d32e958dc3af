"""The deck says what the model says; CalculiX, where installed, agrees on the strains."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.ccx import has_ccx, run_deck
from femlib.assembly import thermal_load
from femlib.errors import InputError
from femlib.wing import Wing, tapered_wing, uav_wing
from femlib.wing.export.calculix import read_gauges, write_deck


def block(lines: list[str], start: str) -> list[str]:
    first = next(k for k, line in enumerate(lines) if line.startswith(start)) + 1
    length = next(k for k, line in enumerate(lines[first:]) if line.startswith("*"))
    return lines[first : first + length]


def test_the_deck_has_every_element_and_the_whole_load(tiny: Wing, tmp_path: Path) -> None:
    write_deck(tiny, tmp_path / "wing.inp", {"mu1": 0.5}, 3.0, warming=-20.0, large_deflection=True)
    assert [path.name for path in tmp_path.iterdir()] == ["wing.inp"]
    deck, mesh = (tmp_path / "wing.inp").read_text().splitlines(), tiny.structure.shells.mesh
    assert len(block(deck, "*ELEMENT, TYPE=S8R")) == len(mesh.quads)
    assert len(block(deck, "*ELEMENT, TYPE=S6")) == len(mesh.trias)
    loads = np.array([line.split(",") for line in block(deck, "*CLOAD")], dtype=float)
    assert loads[:, 2].sum() == pytest.approx(3.0 * tiny.lift[2::6].sum())
    assert "*STEP, NLGEOM" in deck
    assert "ALL, -20.0, 0.0" in deck


def test_damage_lowers_the_modulus_of_its_region(tiny: Wing, tmp_path: Path) -> None:
    moduli = []
    for mu in (0.0, 0.5):
        write_deck(tiny, tmp_path / "wing.inp", {"mu1": mu}, 1.0)
        lines = (tmp_path / "wing.inp").read_text().splitlines()
        element = int(np.flatnonzero(tiny.structure.components[0].elements)[0]) + 1
        sets = [k for k, line in enumerate(lines) if line.startswith("*ELSET, ELSET=E")]
        owner = next(k for k in reversed(sets) if f"{element}," in block(lines[k:], "*ELSET"))
        at = next(k for k in range(owner, len(lines)) if lines[k] == "*ELASTIC")
        moduli.append(float(lines[at + 1].split(",")[0]))
    assert moduli[1] == pytest.approx(0.5 * moduli[0])


def test_the_last_increment_of_a_result_counts(tiny: Wing, tmp_path: Path) -> None:
    elements = range(1, tiny.structure.shells.mesh.n_elements + 1)
    for share in (0.5, 1.0):
        with (tmp_path / "wing.dat").open("a") as out:
            out.write(" strains (elem, integ.pnt.,exx,eyy,ezz,exy,exz,eyz) for set GAUGES and time  1.0\n\n")
            out.writelines(
                f" {e} {p} {3 * f'{-share * 1e-3 * (p > 4)} '} 0. 0. 0. S\n" for e in elements for p in range(1, 9)
            )
    assert read_gauges(tiny, tmp_path / "wing.dat") == pytest.approx(np.full(24, 1000.0), rel=1e-4)


def test_other_forces_a_gradient_and_a_temperature_by_element_reach_the_deck(tiny: Wing, tmp_path: Path) -> None:
    path, n = tmp_path / "wing.inp", tiny.structure.shells.mesh.n_elements
    forces = np.zeros_like(tiny.lift)
    forces[[7, 10]] = 2.0, 0.5  # node 2: a force along y and a moment about y
    write_deck(tiny, path, {}, 3.0, lift=forces, warming=5.0, gradient=200.0)
    lines = path.read_text().splitlines()
    assert block(lines, "*CLOAD") == ["2, 2, 6.000000000e+00", "2, 5, 1.500000000e+00"]
    assert block(lines, "*TEMPERATURE") == ["ALL, 5.0, 200.0"]
    warm = np.where(np.arange(n) == 3, 7.0, 0.0)
    write_deck(tiny, path, {}, 3.0, warming=warm)
    lines = path.read_text().splitlines()
    assert block(lines, "*TEMPERATURE") == ["ALL, 1.0, 0.0"]
    heated = [k for k, line in enumerate(lines) if line.startswith("*EXPANSION") and float(lines[k + 1]) > 0.0]
    assert [float(lines[k + 1]) for k in heated] == [pytest.approx(7.0 * tiny.materials.skin_expansion)]
    with pytest.raises(InputError, match=r"gradient is 1.0 K/m beside a warming by element; expected 0"):
        write_deck(tiny, path, {}, 3.0, warming=warm, gradient=1.0)
    with pytest.raises(InputError, match=r"warming has shape \(3,\)"):
        write_deck(tiny, path, {}, 3.0, warming=np.zeros(3))
    with pytest.raises(InputError, match=r"lift\[1\] is nan"):
        write_deck(tiny, path, {}, 3.0, lift=np.where(np.arange(len(forces)) == 1, np.nan, 0.0))


@pytest.mark.skipif(not has_ccx(), reason="CalculiX (ccx) is not installed")
def test_calculix_feels_the_same_heat_of_one_skin(tmp_path: Path) -> None:
    wing = tapered_wing(refinement=0.15)
    mesh = wing.structure.shells.mesh
    top = np.isin(mesh.patch_of_element, [mesh.patches.index(name) for name in ("top", "R1", "R2")])
    write_deck(wing, tmp_path / "wing.inp", {}, 0.0, warming=20.0 * top)
    run_deck(tmp_path / "wing.inp")
    heat = thermal_load(wing.structure.shells, 20.0 * top, np.zeros(mesh.n_elements))
    ours, theirs = wing.strain_microstrain({}, 1.0, heat), read_gauges(wing, tmp_path / "wing.dat")
    assert ours @ theirs > 0.98 * np.linalg.norm(ours) * np.linalg.norm(theirs)
    assert np.linalg.norm(ours) == pytest.approx(np.linalg.norm(theirs), rel=0.25)


@pytest.mark.skipif(not has_ccx(), reason="CalculiX (ccx) is not installed")
def test_calculix_reads_the_same_gauges(tmp_path: Path) -> None:
    wing = uav_wing(refinement=0.25)
    write_deck(wing, tmp_path / "wing.inp", {}, 3.0)
    run_deck(tmp_path / "wing.inp")
    ratio = wing.strain_microstrain({}, 3.0) / read_gauges(wing, tmp_path / "wing.dat") - 1.0
    usable = wing.gauges.is_usable
    assert np.sqrt(np.mean(ratio[usable] ** 2)) < 0.02
    assert np.abs(ratio[usable]).max() < 0.07
