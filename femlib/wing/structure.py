"""The wing as shells: skins, one spar web and ribs on a grid of span and chord lines.

Both skins share their nodes at the leading and trailing edge; web and ribs share the skins' nodes. Nodes of one span
station are scaled copies of the next station's, so every quadrilateral is plane.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.assembly import Shells
from femlib.errors import InputError, is_number
from femlib.geometry import Naca4, Planform, grid_lines
from femlib.material import Laminate, isotropic_plate
from femlib.mesh import Mesh, QualityLimits
from femlib.strength import Strength
from femlib.wing.damage import SURFACES, DamageRegion

STEP_ETA = 0.011
"""Largest step of the span fraction at refinement 1, where gauges are."""
STEP_ETA_AWAY = 0.02
"""The same farther than `SENSED` from the innermost and the outermost gauge."""
SENSED = 0.06
STEP_ETA_RIB = 0.005
"""The same within `RIB_ZONE` of a rib that has a gauge nearer than `RIB_SENSED`: the skin bends where a rib holds it;
without, the pristine strain of a gauge 9 mm from a rib was 2.6 % off."""
RIB_ZONE = 0.01
RIB_SENSED = 0.03
STEP_CHORD = 0.035
"""Largest step of the chord fraction at refinement 1, aft of the nose."""
NOSE_END = 0.12
"""Chord fraction up to which the lines crowd toward the leading edge."""
STEP_NOSE = 0.2
"""Largest step of sqrt(x/c / 0.12) at refinement 1: the section curves most at its nose."""
EDGE_REACH = 0.03
"""Width of the zone on both sides of an edge in which lines are close [m]."""
LINES_ASPECT = 4000.0
"""Aspect ratio of elements up to which close lines may run on, far from the edges that asked for them."""
DEPTH = 0.06
"""Height of the spar at the root [m]."""
CARBON_LENGTH = 3.8e-3
"""Length over which strains are means before plies are asked whether they fail [m]: the strain of a region's corner
grows without limit as the mesh is refined. Source: J. M. Whitney, R. J. Nuismer, J. Composite Materials 8 (1974)
253-265, carbon laminates. For plywood it is assumed; its plies are 1 to 1.5 mm thick."""
ROOT_END = 1.0 / 6.0
"""Span fraction up to which the root's layup reaches; a rib of 13 stands there."""
MIDDLE = 0.5
"""Span fraction at which the skin's layup steps; a rib of 13 stands there."""
LEVELS = (0.0, 0.5, 1.0)
"""Height fractions of web and ribs, from the upper skin, at which they have nodes."""


SKIN_STRAINS = (6.0e-3, 4.5e-3, 9.0e-3)
"""Strains that the carbon faces bear in tension, compression and shear [-]. Assumed: what designers allow where an
impact that nobody saw may have hurt the laminate; undamaged coupons bear twice as much."""
WOOD_STRAINS = (5.5e-3, 4.0e-3, 1.5e-2)
"""The same of birch plywood, means of coupons; the weakest of twenty bears a quarter less. Assumed."""
PLAUSIBLE = {
    "skin_young": (1e6, 1e13, "Pa"),
    "wood_young": (1e6, 1e13, "Pa"),
    "skin_thickness": (1e-6, 0.2, "m"),
    "wood_thickness": (1e-6, 0.2, "m"),
}
"""Outside these a number is in another unit: rubber has 1e6 Pa, diamond 1e12."""


@dataclass(frozen=True, slots=True)
class WingMaterials:
    """Moduli and thicknesses, all fitted or assumed: none was published. The defaults are those of `uav_wing`.

    Attributes
    ----------
    skin_young, skin_poisson, skin_thickness : float
        One layer [Pa, -, m] equivalent to a sandwich of two carbon faces of E t = 2.11e6 N/m at +-1.1 mm. Fitted to the
        published strains. A thin monolithic skin would buckle at 40 to 100 microstrain.
    face_height : float
        Height of the carbon face over the skin's middle [m]: a gauge reads there, not at the equivalent layer's
        surface.
    skin_taper : float
        Skin modulus at the tip over the root's, linear between; 1 for none.
    skin_rise : float
        Growth of the skin's modulus along the span besides, exp(skin_rise (eta - 1/2)). Fitted.
    skin_step : float
        Factor on the skin's modulus outboard of mid-span, where a layup ends. Fitted.
    root_factor : float
        Factor on the modulus of skins and web inboard of `ROOT_END`, where a wing is doubled. No gauge stands there.
    web_factor, rib_factor : float
        Factors on the modulus of web and ribs. Fitted.
    wood_young, wood_poisson, wood_thickness : float
        Plywood of web and ribs [Pa, -, m]. Assumed.
    modulus_scale : float
        Factor on all moduli, fitted to the published tip stiffness 0.677 N/mm.
    skin_density, wood_density : float
        Masses [kg/m^3]: the wing weighs 2.15 kg, fitted to an estimate of 2.3.
    skin_expansion, wood_expansion : float
        Thermal expansion [1/K]. Assumed: carbon fabric and plywood along the grain.
    """

    skin_young: float = 1.11e9
    skin_poisson: float = 0.31
    skin_thickness: float = 3.81e-3
    face_height: float = 1.1e-3
    skin_taper: float = 1.0
    skin_rise: float = 3.1671
    skin_step: float = 0.2618
    root_factor: float = 1.0
    web_factor: float = 2.2016
    rib_factor: float = 2.5663
    wood_young: float = 3.25e9
    wood_poisson: float = 0.30
    wood_thickness: float = 3.0e-3
    modulus_scale: float = 1.3757
    skin_density: float = 336.1
    wood_density: float = 600.0
    skin_expansion: float = 2.0e-6
    wood_expansion: float = 5.0e-6

    def __post_init__(self) -> None:
        for name, (least, most, unit) in PLAUSIBLE.items():
            value = getattr(self, name)
            if is_number(value) and value > 0.0 and not least <= value <= most:
                raise InputError(
                    f"{name} is {value!r} {unit}; expected {least:g} to {most:g} {unit}; give moduli in Pa, "
                    "lengths in m"
                )
        if not is_number(self.skin_taper) or self.skin_taper <= 0.0:
            raise InputError(f"skin_taper is {self.skin_taper!r}; expected tip over root modulus above 0; correct it")
        if not is_number(self.skin_rise):
            raise InputError(f"skin_rise is {self.skin_rise!r}; expected a finite number, 0 for none; correct it")
        for name in ("skin_step", "root_factor", "web_factor", "rib_factor"):
            value = getattr(self, name)
            if not is_number(value) or value <= 0.0:
                raise InputError(f"{name} is {value!r}; expected a factor above 0, 1 for no change; correct it")
        if not is_number(self.face_height) or not 0.0 <= self.face_height <= 0.5 * self.skin_thickness:
            raise InputError(
                f"face_height is {self.face_height!r} m; expected 0 to half the skin's thickness, "
                f"{self.skin_thickness!r} m; correct the material card"
            )

    def laminates(self) -> tuple[Laminate, Laminate]:
        """Return the sections (skin at the root, wood)."""
        skin = (self.skin_young, self.skin_poisson, self.skin_thickness, self.skin_density, self.skin_expansion)
        wood = (self.wood_young, self.wood_poisson, self.wood_thickness, self.wood_density, self.wood_expansion)
        young = [self.modulus_scale * card[0] for card in (skin, wood)]
        return (
            isotropic_plate(young[0], *skin[1:], _bearing(young[0], skin[1], SKIN_STRAINS)),
            isotropic_plate(young[1], *wood[1:], _bearing(young[1], wood[1], WOOD_STRAINS)),
        )


def _bearing(young: float, poisson: float, strains: tuple[float, float, float]) -> Strength | None:
    """Return the strength of an isotropic card that bears strains in tension, compression and shear."""
    if not (is_number(young) and is_number(poisson)) or young <= 0.0 or poisson <= -1.0:
        return None  # the card itself is refused, with a sentence of its own
    tension, compression, shear = strains
    return Strength(
        young * tension, young * compression, young * tension, young * compression, young * shear / (2 * (1 + poisson))
    )


def tapered_materials() -> WingMaterials:
    """Return the cards of `tapered_wing`: a skin with one straight taper."""
    return WingMaterials(
        modulus_scale=1.01309,
        skin_taper=0.31,
        skin_rise=0.0,
        skin_step=1.0,
        web_factor=1.0,
        rib_factor=1.0,
        skin_density=367.0,
    )


@dataclass(frozen=True, slots=True, eq=False)
class WingGrid:
    """Node numbers of the wing on its grid lines.

    Attributes
    ----------
    eta, chord : FloatArray
        Span fractions (n_eta,) and chord fractions (n_chord,) of the grid lines.
    upper, lower : IntArray
        Nodes (n_eta, n_chord) of the skins; equal in the first and last column.
    inside : IntArray
        Nodes (n_eta, n_chord, n_levels) between the skins, -1 where neither web nor rib needs one.
    rib_rows : IntArray
        Indices into `eta` of the ribs (n_ribs,).
    spar_column : int
        Index into `chord` of the spar.
    levels : FloatArray
        Height fractions of the nodes between the skins (n_levels,), from the upper skin.
    """

    eta: FloatArray
    chord: FloatArray
    upper: IntArray
    lower: IntArray
    inside: IntArray
    rib_rows: IntArray
    spar_column: int
    levels: FloatArray

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return int(max(self.lower.max(), self.inside.max())) + 1

    def columns(self, row: int) -> IntArray:
        """Return the nodes (n_chord, n_levels + 2) of a span station from the upper to the lower skin."""
        return np.concatenate([self.upper[row, :, None], self.inside[row], self.lower[row, :, None]], axis=1)


def wing_grid(
    planform: Planform,
    n_ribs: int,
    regions: Sequence[DamageRegion],
    gauge_eta: FloatArray,
    refinement: float,
    edge_step: float = 0.0,
) -> WingGrid:
    """Return the numbers of the nodes on their grid lines.

    Ribs, spar, region edges and the span fractions `gauge_eta` of the installed gauges lie on grid lines, so that
    strains and damage increments converge smoothly; steps shrink with 1 / `refinement`. Beside edges of regions and
    layups, and beside the skins on web and ribs, the first lie `edge_step` [m] away if it is not 0.
    """
    ribs = np.linspace(0.0, 1.0, n_ribs)
    span_edges = [e for r in regions for e in (r.eta_min, r.eta_max)]
    layups, close, steps = [ROOT_END, MIDDLE] if edge_step else [], edge_step / planform.span, _edge_steps(edge_step)
    eta = _beside(_span_lines(ribs, span_edges, gauge_eta, refinement), [*span_edges, *layups], ribs, close, steps)
    nose = NOSE_END * grid_lines([0.0, 1.0], STEP_NOSE / refinement) ** 2
    edges, spar = _chord_edges(regions), planform.spar_fraction
    rest = grid_lines([NOSE_END, spar, 1.0, *edges], STEP_CHORD / refinement)
    kept = np.array([0.0, NOSE_END, spar, 1.0])
    joints = [spar] if edge_step else []
    chord = _beside(np.concatenate([nose[:-1], rest]), [*edges, *joints], kept, edge_step / planform.root_chord, steps)
    rib_rows = np.searchsorted(eta, ribs - 1e-9)
    column = int(np.searchsorted(chord, spar - 1e-9))
    shape = (len(eta), len(chord))
    upper = np.arange(shape[0] * shape[1]).reshape(shape)
    lower = upper.copy()
    lower[:, 1:-1] = upper.size + np.arange(shape[0] * (shape[1] - 2)).reshape(shape[0], -1)
    levels = _beside(np.array(LEVELS), [0.0, 1.0], [], edge_step / DEPTH, steps)[1:-1]
    needed = np.zeros((*shape, len(levels)), dtype=bool)
    needed[:, column] = True
    needed[rib_rows, 1:-1] = True
    inside = np.full(needed.shape, -1)
    inside[needed] = lower.max() + 1 + np.arange(needed.sum())
    return WingGrid(eta, chord, upper, lower, inside, rib_rows, column, levels)


def _span_lines(ribs: FloatArray, edges: Sequence[float], gauge_eta: FloatArray, refinement: float) -> FloatArray:
    """Return the span fractions of the grid lines: close near ribs that have a gauge by them, far where no gauge is."""
    fixed = np.unique(np.round([*ribs, *edges, *gauge_eta], 12))
    held = ribs[np.abs(ribs[:, None] - gauge_eta).min(axis=1) < RIB_SENSED]
    # a zone is no use to a mesh whose steps are much wider, and no line may come so close to another as to make slivers
    wanted = np.concatenate([held - RIB_ZONE, held + RIB_ZONE]) if 2.0 * RIB_ZONE * refinement > STEP_ETA else held
    clear = np.abs(wanted[:, None] - fixed).min(axis=1) > 0.5 * STEP_ETA_RIB
    stops = np.unique(np.round([*fixed, *wanted[clear]], 12))
    middles = 0.5 * (stops[1:] + stops[:-1])
    by_rib = np.abs(middles[:, None] - held).min(axis=1, initial=np.inf) < RIB_ZONE
    away = (middles < gauge_eta.min() - SENSED) | (middles > gauge_eta.max() + SENSED)
    steps = np.select([by_rib, away], [STEP_ETA_RIB, STEP_ETA_AWAY], STEP_ETA) / refinement
    pieces = [grid_lines(ends, step)[:-1] for ends, step in zip(pairwise(stops), steps, strict=True)]
    return np.concatenate([*pieces, stops[-1:]])


def _edge_steps(first: float) -> list[float]:
    """Return the distances of the lines beside an edge over that of the first [m], each step twice the one before."""
    return [2.0**k - 1.0 for k in range(1, 32) if 0.0 < (2.0**k - 1.0) * first < EDGE_REACH]


def _beside(
    lines: FloatArray, edges: Sequence[float], kept: FloatArray | Sequence[float], first: float, steps: Sequence[float]
) -> FloatArray:
    """Return grid lines with others on both sides of `edges`, at `steps` times `first`.

    They take the place of lines that are nearer than half a step, but for `edges` and those that are `kept`.
    """
    if not first:
        return lines
    fixed, found = np.unique(np.round([*edges, *kept], 12)), lines
    for step, before in zip(steps[::-1], [0.0, *steps[:-1]][::-1], strict=True):
        wanted = np.concatenate([fixed[np.isin(fixed, np.round(edges, 12))] + side * step * first for side in (-1, 1)])
        clear = (np.abs(wanted[:, None] - fixed).min(axis=1) > 0.9 * step * first) & (wanted > 0.0) & (wanted < 1.0)
        wanted = np.sort(wanted[clear])
        wanted = wanted[np.diff(wanted, prepend=-1.0) > 0.5 * (step - before) * first]
        is_free = np.abs(found[:, None] - wanted).min(axis=1, initial=np.inf) > 0.5 * (step - before) * first
        found = np.concatenate([found[is_free | np.isin(np.round(found, 12), fixed)], wanted])
    return np.unique(np.round(found, 12))


def _chord_edges(regions: Sequence[DamageRegion]) -> list[float]:
    """Return the region edges that ask for a chord line of their own, aft of the nose."""
    for region in regions:
        for edge in (region.chord_min, region.chord_max):
            if 0.0 < edge < NOSE_END:
                raise InputError(
                    f"damage region {region.name} has an edge at x/c {edge}; expected 0 or at least {NOSE_END}, "
                    "where the mesh can have a line; move it"
                )
    return [e for r in regions for e in (r.chord_min, r.chord_max) if e >= NOSE_END]


def wing_mesh(planform: Planform, section: Naca4, grid: WingGrid, regions: Sequence[DamageRegion]) -> Mesh:
    """Return the mesh with patches top, bottom, web, ribs and one for each region."""
    top, bottom = _skin(grid.upper), _skin(grid.lower)[:, ::-1]
    patches = (*SURFACES, "ribs", *(region.name for region in regions))
    web = _web(grid)
    ribs, ends = _ribs(grid)
    sizes = [(0, len(top)), (1, len(bottom)), (2, len(web)), (3, len(ribs)), (3, len(ends))]
    patch = np.concatenate([np.full(size, number) for number, size in sizes])
    eta, chord = _middles(grid, len(ribs) + len(ends))
    plain = patch.copy()
    for number, region in enumerate(regions):
        surface = plain == patches.index(region.surface)
        patch[surface & region.contains(eta, chord)] = len(SURFACES) + 1 + number
    limits = QualityLimits(aspect=LINES_ASPECT) if len(grid.levels) + 2 > len(LEVELS) else QualityLimits()
    return Mesh(
        _positions(planform, section, grid), np.concatenate([top, bottom, web, ribs]), ends, patches, patch, limits
    )


def wing_shells(mesh: Mesh, planform: Planform, materials: WingMaterials, regions: Sequence[DamageRegion]) -> Shells:
    """Return the shells, each element with its section; the skins' modulus varies along the span."""
    webs = ["web", *(region.name for region in regions if region.surface == "web")]
    web = np.isin(mesh.patch_of_element, [mesh.patches.index(p) for p in webs])
    rib = mesh.patch_of_element == mesh.patches.index("ribs")
    eta = mesh.centroids()[:, 1] / planform.span
    skin = 1.0 - (1.0 - materials.skin_taper) * eta
    skin *= np.exp(materials.skin_rise * (eta - MIDDLE)) * np.where(eta > MIDDLE, materials.skin_step, 1.0)
    scale = np.select([web, rib], [materials.web_factor, materials.rib_factor], skin)
    scale = np.where(~rib & (eta < ROOT_END), materials.root_factor * scale, scale)
    return Shells(mesh, materials.laminates(), (web | rib).astype(np.int64), scale, np.array([0.0, 1.0, 0.0]))


def _middles(grid: WingGrid, n_ribs: int) -> tuple[FloatArray, FloatArray]:
    """Return the span and chord fractions of the elements' middles in the order of the mesh, NaN on the ribs."""
    eta, chord = 0.5 * (grid.eta[1:] + grid.eta[:-1]), 0.5 * (grid.chord[1:] + grid.chord[:-1])
    n_levels = len(grid.levels) + 1
    spar = np.full(len(eta) * n_levels, grid.chord[grid.spar_column])
    nowhere = np.full(n_ribs, np.nan)
    along = [np.repeat(eta, len(chord)), np.repeat(eta, len(chord)), np.repeat(eta, n_levels), nowhere]
    across = [np.tile(chord, len(eta)), np.tile(chord, len(eta)), spar, nowhere]
    return np.concatenate(along), np.concatenate(across)


def _skin(nodes: IntArray) -> IntArray:
    """Quadrilaterals of a node grid (n_eta, n_chord), normal up where x runs aft and y outboard."""
    return np.stack([nodes[:-1, :-1], nodes[:-1, 1:], nodes[1:, 1:], nodes[1:, :-1]], axis=-1).reshape(-1, 4)


def _web(grid: WingGrid) -> IntArray:
    stacks = np.stack([grid.columns(row)[grid.spar_column] for row in range(len(grid.eta))])
    return _skin(stacks)


def _ribs(grid: WingGrid) -> tuple[IntArray, IntArray]:
    """Quadrilaterals of the ribs, and the triangles at their noses and tails."""
    quads, trias = [], []
    for row in grid.rib_rows:
        columns = grid.columns(int(row))
        quads.append(_skin(columns[1:-1]))
        for tip, stack in ((grid.upper[row, 0], columns[1][::-1]), (grid.upper[row, -1], columns[-2])):
            trias.append(np.stack([np.full(len(stack) - 1, tip), stack[:-1], stack[1:]], axis=-1))
    return np.concatenate(quads), np.concatenate(trias)


def _positions(planform: Planform, section: Naca4, grid: WingGrid) -> FloatArray:
    """Node positions (n_nodes, 3): a section scaled by the chord at each station."""
    upper, lower = section.heights(grid.chord)
    nodes = np.zeros((grid.n_nodes, 3))
    chords = planform.chord(grid.eta)
    plane = planform.position(grid.eta[:, None], grid.chord[None, :])
    stacks = [(grid.upper, upper), (grid.lower, lower)]
    stacks += [(grid.inside[:, :, k], upper + level * (lower - upper)) for k, level in enumerate(grid.levels)]
    for numbers, height in stacks:
        z = chords[:, None] * height[None, :]
        points = np.concatenate([plane, z[:, :, None]], axis=2)
        nodes[numbers[numbers >= 0]] = points[numbers >= 0]
    return nodes
