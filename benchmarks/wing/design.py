"""The wing as a function of what is fitted to the published data."""

from collections.abc import Mapping

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from femlib.assembly import Shells, point_masses
from femlib.calibration import Design, MovingGauges, Varying, VaryingRows
from femlib.wing import Wing
from femlib.wing.gauges import SPANWISE, pitched_places
from femlib.wing.loads import elliptic_lift
from femlib.wing.planform import PLANFORM, SECTION
from femlib.wing.structure import MIDDLE, ROOT_END

Floats = NDArray[np.float64]
LOAD_FACTOR = 3.0
SKIN_DENSITY = 367.0
"""The skin's density [kg/m^3] that `density` is a factor on."""
PLACE_STEP = 1e-6
"""Half step of the fractions in the derivative of a gauge's point [-]: the section's curve is smooth."""
GAUGE_PARAMETERS = ("front_in", "front_out", "rear_in", "rear_out", "pitch", "x_front", "x_rear")
EDGES = {"mu1": ("r1_fore", "r1_aft"), "mu2": ("r2_fore", "r2_aft")}
"""Parameters of the regions' edges along the chord by damage parameter."""
SPAN_EDGES = {"mu1": ("r1_in", "r1_out"), "mu2": ("r2_in", "r2_out")}
"""The same along the span; those of the wing's own regions if they are not given."""


class WingDesign:
    """A wing with parameters.

    Stiffness: `skin` (all moduli; the skin's alone where wood is apart), `rise`, `step`, `rib`, `web` and `root` (1 if
    not given) as in `WingMaterials`. Load: `mass` [kg]. Gauges: those of `GAUGE_PARAMETERS`, fractions. Weight:
    `density`, a factor on `SKIN_DENSITY`. Regions: those of `EDGES` and `SPAN_EDGES`; an element that an edge cuts
    loses the share of its stiffness that lies inside, the price of a mesh that stays.

    Parameters
    ----------
    wing : Wing
        Gives mesh, supports, sections and regions.
    states : mapping
        Damage parameter and loss of each named state; the undamaged one has a loss of 0.
    fixed : mapping
        Values of parameters that are not fitted.
    masses : mapping
        Point masses [kg] by span fraction, on the spar's upper cap.
    is_wood_apart : bool
        Whether `skin` leaves web and ribs as they are.
    """

    def __init__(
        self,
        wing: Wing,
        states: Mapping[str, tuple[str, float]],
        fixed: Mapping[str, float],
        masses: Mapping[float, float],
        is_wood_apart: bool = False,
    ) -> None:
        own = {n: e for r in wing.regions for n, e in zip(SPAN_EDGES[r.parameter], (r.eta_min, r.eta_max), strict=True)}
        self.wing, self.states, self.is_wood_apart = wing, states, is_wood_apart
        self.fixed = {"root": 1.0, **own, **fixed}
        shells, cards, mesh = wing.structure.shells, wing.materials, wing.structure.shells.mesh
        ones = np.ones(mesh.n_elements)
        wood = shells.section == 1
        self.rib = mesh.patch_of_element == mesh.patches.index("ribs")
        self.web = wood & ~self.rib
        self.eta = mesh.centroids()[:, 1] / wing.span
        factor = 1.0 / cards.modulus_scale
        self.shells = Shells(mesh, shells.laminates, shells.section, factor * ones, shells.axis)
        side = cards.face_height / (cards.skin_thickness / 2.0)
        top = ("top", *(region.name for region in wing.regions))
        self.gauges = MovingGauges(mesh, wing.thickness, SPANWISE, top, side, unit=-1e6)
        self.lift = elliptic_lift(wing.grid, 1.0)
        self.ranges = _ranges(wing)
        rows = {eta: int(np.abs(wing.grid.eta - eta).argmin()) for eta in masses}
        at = {int(wing.grid.upper[rows[eta], wing.grid.spar_column]): masses[eta] for eta in masses}
        self.point_mass = point_masses(mesh, at)

    def design(self, values: Mapping[str, float]) -> Design:
        """Return the wing at parameter values; others have their fixed ones."""
        v = {**self.fixed, **values}
        up, aft = self._tip(2), self._tip(0)
        lift = LOAD_FACTOR * self.lift
        return Design(
            self.shells,
            self.wing.structure.supports,
            self._stiffness(v),
            self._mass(v),
            {name: self._state(v, *state) for name, state in self.states.items()},
            {"lift": Varying(v["mass"] * lift, {"mass": lift}), "tip": Varying(up)},
            {
                "gauges": self.gauges.at(_places(v)),
                "up": VaryingRows(sparse.csr_array(up[None])),
                "aft": VaryingRows(sparse.csr_array(aft[None])),
            },
            self.point_mass,
        )

    def _stiffness(self, v: Mapping[str, float]) -> Varying:
        outer, skin = self.eta > MIDDLE, ~(self.web | self.rib)
        along = np.exp(v["rise"] * (self.eta - MIDDLE)) * np.where(outer, v["step"], 1.0)
        base = np.select([self.web, self.rib], [v["web"], v["rib"]], along)
        base = np.where(~self.rib & (self.eta < ROOT_END), v["root"] * base, base)
        by_skin = np.where(skin | (not self.is_wood_apart), base, 0.0)
        value = np.where(by_skin > 0.0, v["skin"] * base, base)
        slopes = {
            "skin": by_skin,
            "rise": skin * value * (self.eta - MIDDLE),
            "step": (skin & outer) * value / v["step"],
            "web": self.web * value / v["web"],
            "rib": self.rib * value / v["rib"],
        }
        return Varying(value, slopes)

    def _mass(self, v: Mapping[str, float]) -> Varying:
        wood = 1.0 * (self.web | self.rib)
        skin = (1.0 - wood) * SKIN_DENSITY / self.wing.materials.skin_density
        return Varying(wood + v["density"] * skin, {"density": skin})

    def _state(self, v: Mapping[str, float], parameter: str, loss: float) -> Varying:
        """Return the factors of one region's loss, and their derivatives by the region's edges."""
        ones = np.ones(len(self.eta))
        if loss == 0.0:
            return Varying(ones)
        values, slopes = ones, dict[str, Floats]()
        for (low, high), (first, last) in zip(self.ranges, (EDGES[parameter], SPAN_EDGES[parameter]), strict=True):
            top = high > low
            width = np.where(top, high - low, 1.0)
            overlap = np.minimum(high, v[last]) - np.maximum(low, v[first])
            inside = np.where(top, np.clip(overlap, 0.0, None), 0.0) / width
            slopes = {name: slope * inside for name, slope in slopes.items()}
            slopes[first] = values * np.where(top & (low < v[first]) & (v[first] <= high), -1.0, 0.0) / width
            slopes[last] = values * np.where(top & (low <= v[last]) & (v[last] < high), 1.0, 0.0) / width
            values = values * inside
        return Varying(ones - loss * values, {name: -loss * slope for name, slope in slopes.items()})

    def _tip(self, axis: int) -> Floats:
        """Return a unit force (n_dofs,) at the tip's spar, shared as in `Wing.tip_stiffness`."""
        grid = self.wing.grid
        nodes = grid.columns(len(grid.eta) - 1)[grid.spar_column]
        unit = np.zeros(self.shells.mesh.n_dofs)
        unit[6 * nodes + axis] = 1.0 / len(nodes)
        return unit


def _ranges(wing: Wing) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return least and largest chord and span fractions (n_elements,) of the top skin's elements, equal elsewhere."""
    mesh = wing.structure.shells.mesh
    corners = mesh.nodes[mesh.quads]
    eta = corners[:, :, 1] / wing.span
    chord = corners[:, :, 0] / PLANFORM.chord(eta) + PLANFORM.spar_fraction
    names = ("top", *(region.name for region in wing.regions))
    top = np.isin(mesh.patch_of_element[: len(mesh.quads)], [mesh.patches.index(name) for name in names])
    return _of_top(chord, top, mesh.n_elements), _of_top(eta, top, mesh.n_elements)


def _of_top(fraction: Floats, top: NDArray[np.bool_], n_elements: int) -> tuple[Floats, Floats]:
    low, high = np.zeros(n_elements), np.zeros(n_elements)
    low[: len(top)][top], high[: len(top)][top] = fraction.min(axis=1)[top], fraction.max(axis=1)[top]
    return low, high


def _places(v: Mapping[str, float]) -> Varying:
    """Return the gauges' points (24, 3) and their derivatives by the rows' parameters."""
    slopes = {}
    for name in GAUGE_PARAMETERS:
        up, down = (_points({**v, name: v[name] + step}) for step in (PLACE_STEP, -PLACE_STEP))
        slopes[name] = (up - down) / (2.0 * PLACE_STEP)
    return Varying(_points(v), slopes)


def _points(v: Mapping[str, float]) -> Floats:
    front, rear = (v["front_in"], v["front_out"]), (v["rear_in"], v["rear_out"])
    eta, chord = pitched_places(front, rear, v["pitch"], (v["x_front"], v["x_rear"])).T
    height = PLANFORM.chord(eta) * SECTION.heights(chord)[0]
    return np.concatenate([PLANFORM.position(eta, chord), height[:, None]], axis=1)
