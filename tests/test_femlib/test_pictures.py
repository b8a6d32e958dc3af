"""Pictures show what the solution says; the command writes them."""

import sys
from pathlib import Path

import numpy as np
import pytest

from femlib.wing import Wing
from femlib.wing.export.pictures import main, render, strain_picture
from femlib.wing.export.vtu import near_shape, write_vtu


def test_the_strain_of_both_skins_is_coloured(tiny: Wing) -> None:
    _, strains = near_shape(tiny, tiny.solve({"mu1": 0.4}, 2.0))
    figure = strain_picture(tiny, strains, "mu1 = 40 %")
    top, bottom = (np.asarray(axis.collections[0].get_array()) for axis in figure.axes[:2])
    assert len(top) + len(bottom) == 2 * len(tiny.grid.upper[:-1]) * (len(tiny.grid.chord) - 1)
    assert np.median(top) > 0 > np.median(bottom)


def test_a_large_deflection_and_other_loads_reach_the_vtu_file(tiny: Wing, tmp_path: Path) -> None:
    texts = []
    for options in ({}, {"large_deflection": True}, {"lift": 2.0 * tiny.lift}):
        write_vtu(tiny, tmp_path / "wing.vtu", {}, 3.0, **options)
        texts.append((tmp_path / "wing.vtu").read_text())
    assert len(set(texts)) == 3


def test_vtk_and_meshio_read_the_file(tiny: Wing, tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed: pip install 'octmip[pictures]'")
    write_vtu(tiny, tmp_path / "wing.vtu", {}, 1.0)
    grid = pyvista.read(tmp_path / "wing.vtu")
    assert (grid.n_points, grid.n_cells) == (
        len(tiny.structure.shells.mesh.nodes),
        tiny.structure.shells.mesh.n_elements,
    )
    assert grid.point_data["displacement_m"][:, 2].max() == pytest.approx(tiny.solve({}, 1.0)[:, 2].max(), rel=1e-6)


def test_vtk_renders_off_screen(tiny: Wing, tmp_path: Path) -> None:
    pytest.importorskip("pyvista", reason="pyvista is not installed: pip install 'octmip[pictures]'")
    moved, strains = near_shape(tiny, tiny.solve({}, 3.0))
    render(tiny, moved, strains, tmp_path / "wing.png")
    assert (tmp_path / "wing.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
def test_the_command_writes_its_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    main([str(tmp_path / "out"), "--refinement", "0.25", "--mu1", "0.5"])
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"wing_regions.png", "wing_strain.png", "wing_deformed.png", "wing.vtu"}
    assert (
        "rendering needs the package pyvista, which is not installed; install octmip[pictures]"
        in capsys.readouterr().out
    )
