"""Damage where the library of states has no parameter: a patch of skin or a length of web that lost stiffness.

First order: f = +0.01 K_zone u per per cent, u and the response those of the healthy wing (the zone's own signature
changes little with damage elsewhere). A zone's signature is the sum of its elements' signatures, which are made once.
"""

from functools import cache
from itertools import product

import numpy as np

from femlib.arrays import BoolArray, FloatArray
from femlib.mesh import dofs_of_nodes
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.model import MICRO, Wing

SPAN_CENTRES = np.linspace(0.15, 0.84, 24)
"""Centres of the zones along the span: a local signature needs zones as fine as the gauges lie, and overlapping."""
SPAN_WIDTHS = (0.06, 0.12)
"""Widths of the zones, span fractions."""
UPPER_WIDTHS = (0.06, 0.09, 0.12)
"""Widths on the upper skin: which gauges lie inside decides the signature, so they grow by one gauge at a time."""
CHORD_WINDOWS = ((0.0, 0.3), (0.15, 0.45), (0.3, 0.6), (0.45, 0.75), (0.6, 1.0))
"""Parts of the chord on the upper skin, overlapping by half like the zones along the span."""


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    zones = damage_zones(response.wing)

    @cache  # made at the first call: a second that many users of the wing never need
    def signatures() -> dict[str, FloatArray]:
        of_elements = element_signatures(response)
        return {place: 0.01 * of_elements[elements].sum(axis=0) for place, elements in zones.items()}

    return WingEffect(
        name="damage_outside_library",
        parameter="loss of stiffness of a zone that is no damage region",
        unit="%",
        prior_sd=20.0,
        prior_source="damages of the library lose 20 to 80 %",
        separated_by="a signature local to the zone; more gauges around it locate it",
        words="damage outside the library",
        words_at="damage of the wing at {place}",
        action="inspect the wing at {place}",
        says=("it has lost {size} of its stiffness there", "it is {size} stiffer there than the twin"),
        load_power=1,
        strains=lambda state, load_factor, place, time: load_factor * signatures()[place],
        place_names=tuple(zones),
        n_between=8,
        signature_error=0.4,
        is_one_sided=True,
        bounds=(0.0, 100.0),
    )


def element_signatures(response: Response) -> FloatArray:
    """Return Z' k_e u (n_elements, n_gauges) [microstrain], the strains that the loss of each whole element causes."""
    shells, supports = response.wing.structure.shells, response.wing.structure.supports
    moved, adjoint = response.displacements({}), supports.expand(response.adjoint())
    signatures = []
    for corners, stiffness in zip((shells.mesh.quads, shells.mesh.trias), shells.element_stiffness, strict=True):
        dofs = dofs_of_nodes(corners).reshape(len(corners), -1)
        force = np.einsum("eij,ej->ei", stiffness, moved[dofs])
        signatures.append(MICRO * np.einsum("ei,eig->eg", force, adjoint[dofs]))
    return np.concatenate(signatures)


def damage_zones(wing: Wing) -> dict[str, BoolArray]:
    """Return the elements of every zone, damage regions of the library left out."""
    mesh = wing.structure.shells.mesh
    centre = mesh.centroids()
    eta = centre[:, 1] / wing.span
    chord = _chord_fractions(wing, centre)
    patches = {name: mesh.patch_of_element == mesh.patches.index(name) for name in ("top", "bottom", "web")}
    zones = {}
    for centre_eta, width in product(SPAN_CENTRES.tolist(), UPPER_WIDTHS):
        inner, outer = centre_eta - 0.5 * width, centre_eta + 0.5 * width
        along = (eta >= inner) & (eta < outer)
        where = f"eta {inner:.3f}-{outer:.3f}"
        for fore, aft in CHORD_WINDOWS:
            zones[f"top {where} x/c {fore:g}-{aft:g}"] = patches["top"] & along & (chord >= fore) & (chord < aft)
        if width in SPAN_WIDTHS:
            zones[f"web {where}"] = patches["web"] & along
            zones[f"bottom {where}"] = patches["bottom"] & along
    return {name: elements for name, elements in zones.items() if elements.any()}


def _chord_fractions(wing: Wing, points: FloatArray) -> FloatArray:
    """Return the chord fraction of points (n, 3), from the places of the grid's own nodes."""
    grid = wing.grid
    nodes = wing.structure.shells.mesh.nodes[grid.upper]
    span = nodes[:, 0, 1]
    lead = np.interp(points[:, 1], span, nodes[:, 0, 0])
    tail = np.interp(points[:, 1], span, nodes[:, -1, 0])
    return np.asarray((points[:, 0] - lead) / (tail - lead))
