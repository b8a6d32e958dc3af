"""A wing as thin-walled strips: booms that stretch, edges that shear, sections that ribs keep in shape.

Each section moves by u (aft), w (up), a turn about the span, and an axial displacement of each boom of its own.
Between two stations an edge has axial strains that are linear over its width, and the shear (v_l - v_k) / b + u' t_x +
w' t_z + turn' (z t_x - x t_z), taken in the middle. So bending of any axis, Bredt's shear flow in both cells, warping
and its restraint at the root, shear lag, and the way of the load around a weak patch are in it; local bending of skins
and ribs that give are not.

Source: Kuhn (1956), Stresses in Aircraft and Shell Structures, chapters 3 to 8, in displacements.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import SuperLU, splu

from benchmarks.blind.assets.beam.section import INNER, Section
from femlib.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Card:
    """Constants of the wing.

    Attributes
    ----------
    span, root_chord, tip_chord
        [m].
    skin, web
        modulus [Pa] and thickness [m].
    skin_poisson, web_poisson
        for the shear moduli.
    taper
        modulus of the skins at the tip over the root's.
    face
        height of the gauges over the skin's middle [m].
    """

    span: float = 1.8288
    root_chord: float = 0.43561
    tip_chord: float = 0.261112
    skin: tuple[float, float] = (1.11e9, 3.81e-3)
    web: tuple[float, float] = (3.25e9, 3.0e-3)
    skin_poisson: float = 0.31
    web_poisson: float = 0.30
    taper: float = 0.31
    face: float = 1.1e-3

    def chord(self, eta: FloatArray) -> FloatArray:
        """Return the chord [m] at span fractions."""
        return self.root_chord + (self.tip_chord - self.root_chord) * eta


class Strips:
    """The structure: stiffness, loads, strains.

    Attributes
    ----------
    section, card, eta
        what it is made of; `eta` (n_stations,) are the span fractions of the stations.
    middle
        (n_bays,) span fractions of the bays' middles.
    """

    def __init__(self, section: Section, card: Card, eta: FloatArray) -> None:
        self.section, self.card, self.eta = section, card, eta
        self.middle = 0.5 * (eta[1:] + eta[:-1])
        self.width = len(section.x) + 3
        self._stretch, self._shear, self._axial, self._sheared = self._elements()
        self.n = self.width * len(eta)
        self.free = np.arange(self.width, self.n)

    def _elements(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return unit matrices (n_bays, n_edges, 10, 10) of stretch and shear and their stiffnesses (n_bays, n_edges).

        Freedoms: the booms k and l at the inner station, k and l at the outer one, then u, w, turn inside and outside.
        """
        s, card = self.section, self.card
        k, l_ = s.ends.T
        chord = card.chord(self.middle)[:, None]
        run = np.diff(self.eta)[:, None] * card.span
        dx, dz = s.x[l_] - s.x[k], s.z[l_] - s.z[k]
        wide = np.hypot(dx, dz)
        tx, tz = dx / wide, dz / wide
        arm = chord * (0.5 * (s.z[k] + s.z[l_]) * tx - 0.5 * (s.x[k] + s.x[l_]) * tz)
        b = chord * wide
        stretch = np.zeros((*b.shape, 2, 10))
        for row in (0, 1):
            stretch[..., row, row], stretch[..., row, row + 2] = -1.0 / run, 1.0 / run
        mass = np.array([[1.0, 0.5], [0.5, 1.0]]) / 3.0
        shear = np.zeros((*b.shape, 10))
        shear[..., [0, 2]], shear[..., [1, 3]] = (-0.5 / b)[..., None], (0.5 / b)[..., None]
        for place, value in ((4, tx / run), (5, tz / run), (6, arm / run)):
            shear[..., place], shear[..., place + 3] = -value, value
        is_web = s.part == INNER
        young = np.where(is_web, card.web[0], card.skin[0] * (1.0 - (1.0 - card.taper) * self.middle[:, None]))
        thick = np.where(is_web, card.web[1], card.skin[1])
        poisson = np.where(is_web, card.web_poisson, card.skin_poisson)
        volume = thick * b * run
        unit = np.einsum("...ri,rs,...sj->...ij", stretch, mass, stretch)
        return unit, np.einsum("...i,...j->...ij", shear, shear), young * volume, 0.5 * young / (1 + poisson) * volume

    @property
    def _places(self) -> IntArray:
        """Return the freedoms (n_bays, n_edges, 10) of the elements."""
        inner = self.width * np.arange(len(self.middle))[:, None, None]
        ends = self.section.ends[None]
        last = np.arange(self.width - 3, self.width)[None, None]
        pieces = [inner + ends, inner + self.width + ends, inner + last, inner + self.width + last]
        shape = (len(self.middle), len(ends[0]))
        return np.concatenate([np.broadcast_to(p, (*shape, p.shape[-1])) for p in pieces], axis=-1)

    def factors(self, stiff: FloatArray, shear: FloatArray | None = None) -> SuperLU:
        """Return the factors of the stiffness, each element's stretch and shear times its factor (n_bays, n_edges)."""
        of_shear = stiff if shear is None else shear
        values = (self._axial * stiff)[..., None, None] * self._stretch
        values = values + (self._sheared * of_shear)[..., None, None] * self._shear
        places = self._places
        rows = np.broadcast_to(places[..., :, None], values.shape).ravel()
        columns = np.broadcast_to(places[..., None, :], values.shape).ravel()
        whole = sparse.coo_array((values.ravel(), (rows, columns)), shape=(self.n, self.n)).tocsc()
        return splu(whole[self.free][:, self.free], permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

    def moved(self, factors: SuperLU, force: FloatArray) -> FloatArray:
        """Return the displacements (n_stations, width) under forces of the same shape."""
        found = np.zeros(self.n)
        found[self.free] = factors.solve(np.asarray(force).ravel()[self.free])
        return found.reshape(len(self.eta), self.width)

    def lift(self, force: FloatArray, aft: FloatArray) -> FloatArray:
        """Return the forces of a lift (n_stations,) [N] that acts `aft` (n_stations,) [m] of the web."""
        loads = np.zeros((len(self.eta), self.width))
        loads[:, -2], loads[:, -1] = force, -force * aft
        return loads

    def heat(self, expansion: FloatArray, stiff: FloatArray) -> FloatArray:
        """Return the forces by which elements of free strains (n_bays, n_edges) push."""
        push = np.zeros(self.n)
        run = np.diff(self.eta)[:, None] * self.card.span
        end = 0.5 * self._axial * stiff * expansion / run
        places = self._places
        for corner, sign in ((0, -1.0), (1, -1.0), (2, 1.0), (3, 1.0)):
            np.add.at(push, places[..., corner], sign * end)
        return push.reshape(len(self.eta), self.width)

    def strain(self, moved: FloatArray, eta: FloatArray, boom: IntArray) -> FloatArray:
        """Return the strains on the skin's outer face at span fractions on booms, tension positive.

        The face lies higher than the skin's middle: there the bending of the section as a whole adds its share.
        """
        run = np.diff(self.eta)[:, None] * self.card.span
        axial = np.diff(moved[:, :-3], axis=0) / run
        s = self.section
        plane = np.column_stack([np.ones(len(s.x)), s.x, s.z])
        curved = (np.linalg.lstsq(plane, axial.T, rcond=None)[0].T / self.card.chord(self.middle)[:, None])[:, 2]
        face = axial + self.card.face * curved[:, None]
        return np.array([np.interp(e, self.middle, face[:, b]) for e, b in zip(eta, boom, strict=True)])
