"""Small meshes with named sets, as meshio would read them, and one structure of each kind of part."""

import meshio
import numpy as np

from femlib.material import isotropic_plate
from femlib.structure import Spring, Structure, read, rectangular_beam

ALUMINIUM = isotropic_plate(70e9, 0.33, 0.003, 2700.0)


def plate_mesh(n_x=6, n_y=4, length=0.6, width=0.4):
    """A plate of quadrilaterals with a mast of two lines at one corner; sets of each kind."""
    x, y = np.meshgrid(np.linspace(0.0, length, n_x + 1), np.linspace(0.0, width, n_y + 1))
    mast = np.array([[length, width, 0.1], [length, width, 0.2]])
    points = np.concatenate([np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]), mast])
    first = (np.arange(n_y)[:, None] * (n_x + 1) + np.arange(n_x)).ravel()
    quads = np.column_stack([first, first + 1, first + n_x + 2, first + n_x + 1])
    lines = np.array([[x.size - 1, x.size], [x.size, x.size + 1]])
    inner = np.flatnonzero(np.abs(points[quads].mean(axis=1)[:, 0] - length / 2) < length / 5)
    none = np.zeros(0, dtype=int)
    return meshio.Mesh(
        points,
        [("quad", quads), ("line", lines)],
        cell_sets={
            "skin": [np.arange(len(quads)), none],
            "middle": [inner, none],
            "mast": [none, np.arange(2)],
            "nothing": [none, none],
        },
        point_sets={
            "left": np.flatnonzero(points[:, 0] == 0.0),
            "right": np.flatnonzero((points[:, 0] == length) & (points[:, 2] == 0.0)),
            "top": np.array([len(points) - 1]),
            "corner": np.array([n_x]),
        },
    )


def plate_with_mast(damage=("middle", "mast"), springs=(), supports=None, finer=1, **others):
    """The structure of `plate_mesh`, 6 x 4 or `finer`: its left edge is clamped, a mass stands on the mast."""
    given = {
        "sections": {"skin": ALUMINIUM, "mast": rectangular_beam(70e9, 0.33, 0.01, 0.02, (1, 0, 0), 2700.0)},
        "supports": {"left": "clamped"} if supports is None else supports,
        "damage": damage,
        "masses": {"top": 0.5},
        "springs": springs,
    }
    return Structure(read(plate_mesh(6 * finer, 4 * finer)), **(given | others))


def corner_spring(stiffness=2e4):
    return Spring("foot", "corner", (0.0, 0.0, stiffness, 0.0, 0.0, 0.0))
