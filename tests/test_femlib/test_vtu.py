"""A VTU file holds the mesh and the fields of its state."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from femlib.wing import Wing
from femlib.wing.export.vtu import write_vtu


def test_the_file_holds_mesh_displacement_and_strain(coarse: Wing, tmp_path: Path) -> None:
    path = tmp_path / "wing.vtu"
    write_vtu(coarse, path, {"mu1": 0.4}, 2.0)
    arrays = {
        item.get("Name"): np.array((item.text or "").split(), dtype=float)
        for item in ElementTree.parse(path).getroot().iter("DataArray")
    }
    mesh = coarse.structure.shells.mesh
    assert arrays["points"].reshape(-1, 3) == pytest.approx(mesh.nodes, abs=1e-8)
    assert len(arrays["types"]) == mesh.n_elements
    assert arrays["offsets"][-1] == len(arrays["connectivity"]) == mesh.quads.size + mesh.trias.size
    moved = coarse.solve({"mu1": 0.4}, 2.0)[:, :3]
    assert arrays["displacement_m"].reshape(-1, 3) == pytest.approx(moved, rel=1e-6, abs=1e-9)
    strain, top = arrays["spanwise_strain_microstrain"], mesh.elements_in("top")
    assert np.isfinite(strain[top]).all()
    assert np.median(strain[top]) > 0
    assert np.median(strain[mesh.elements_in("bottom")]) < 0
    assert [p.name for p in tmp_path.iterdir()] == ["wing.vtu"]
