"""Spar-skin debond: over a length the web slides along the skin, so no shear passes between them.

letter = word: t spanwise displacements of the web's edge at the nodes of the length, K_w stiffness of the row of web
elements at that edge, K the wing's, u its displacements. Where the edge slides freely it is condensed out of its row,

    K_debonded = K - W T^-1 W',   W = K_w[:, t],   T = K_w[t, t],

and by Woodbury the debonded wing moves by K^-1 W (T - W' K^-1 W)^-1 W' u more. The middle matrix is what is left of
[[K, W], [W', T]] when K is eliminated, so one factorisation gives it for all places. Exact for a whole debond (size 1)
of the healthy wing; sizes between are linear, at the price of some ten per cent of the signature. The skin keeps
touching the web: only the sliding is free.
Source: W. W. Hager, SIAM Review 31 (1989) 221-239, eq. 2 (Woodbury); R. J. Guyan, AIAA Journal 3 (1965) 380.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.assembly import factorise
from femlib.mesh import DOFS_PER_NODE
from femlib.wing.effects.card import WingEffect
from femlib.wing.effects.response import Response
from femlib.wing.model import MICRO, Wing

SPAN_CENTRES = np.linspace(0.10, 0.90, 41)
"""Centres of the lengths, span fractions: as fine as the grid has stations, nearly continuous."""
SPAN_WIDTHS = (0.05, 0.15)
"""Lengths, span fractions: 91 and 274 mm."""
FLANGES = ("upper", "lower")


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One edge of the web.

    Attributes
    ----------
    eta : FloatArray
        Span fractions of the nodes along it, root left out (n,).
    tied : FloatArray
        W' u of the healthy wing at load factor 1 (n,).
    hold : FloatArray
        T - W' K^-1 W (n, n).
    strains : FloatArray
        Gauge strains of forces W (n_gauges, n) [microstrain].
    """

    eta: FloatArray
    tied: FloatArray
    hold: FloatArray
    strains: FloatArray

    def opened(self, inner: float, outer: float) -> FloatArray:
        """Return the change of the gauge strains (n_gauges,) where the nodes from `inner` to `outer` slide."""
        free = (self.eta >= inner - 1e-9) & (self.eta <= outer + 1e-9)
        return np.asarray(self.strains[:, free] @ np.linalg.solve(self.hold[np.ix_(free, free)], self.tied[free]))


def joints(response: Response) -> dict[str, Joint]:
    """Return the joint of the web with each skin, by flange."""
    wing = response.wing
    shells, supports = wing.structure.shells, wing.structure.supports
    edges = [web_edge(wing, flange) for flange in FLANGES]
    sliding = [DOFS_PER_NODE * nodes + 1 for _, nodes in edges]
    columns = [sparse.csc_array(shells.stiffness(e)[:, s]) for (e, _), s in zip(edges, sliding, strict=True)]
    rows = sparse.block_diag([column[s] for column, s in zip(columns, sliding, strict=True)], format="csc")
    across = sparse.hstack(columns, format="csc")[supports.free]
    stiffness = supports.reduce(shells.stiffness())
    whole = sparse.csc_array(sparse.block_array([[stiffness, across], [across.T, rows]]))
    groups = np.concatenate([supports.groups, *(nodes for _, nodes in edges)])
    hold = factorise(whole, groups, np.arange(stiffness.shape[0], whole.shape[0])).schur()
    first = np.cumsum([0, *(len(nodes) for _, nodes in edges)])
    found = {}
    for k, flange in enumerate(FLANGES):
        own = slice(first[k], first[k + 1])
        found[flange] = Joint(
            eta=shells.mesh.nodes[edges[k][1], 1] / wing.span,
            tied=columns[k].T @ response.displacements({}),
            hold=hold[own, own],
            strains=MICRO * (columns[k][supports.free].T @ response.adjoint()).T,
        )
    return found


def web_edge(wing: Wing, flange: str) -> tuple[BoolArray, IntArray]:
    """Return the row of web elements at a flange (n_elements,) and its nodes on the flange, root left out."""
    grid, mesh = wing.grid, wing.structure.shells.mesh
    nodes = (grid.upper if flange == "upper" else grid.lower)[:, grid.spar_column]
    touching = np.zeros(mesh.n_elements, dtype=bool)
    touching[: len(mesh.quads)] = np.isin(mesh.quads, nodes).sum(axis=1) == 2
    upright = np.abs(mesh.area_vectors()[:, 0]) > 0.9 * np.linalg.norm(mesh.area_vectors(), axis=1)
    return touching & upright, nodes[1:]


def effect(response: Response) -> WingEffect:
    """Return the effect."""
    lengths = [(c - 0.5 * w, c + 0.5 * w) for c, w in product(SPAN_CENTRES.tolist(), SPAN_WIDTHS)]
    inside = [(inner, outer) for inner, outer in lengths if inner > 0.0 and outer < 1.0]

    @cache  # one set of solutions for all places, made when one is first asked for
    def of_web() -> dict[str, Joint]:
        return joints(response)

    def strains(state: Mapping[str, float], load_factor: float, place: str, time: float) -> FloatArray:
        flange, _, length = place.split()
        inner, outer = (float(eta) for eta in length.split("-"))
        return load_factor * of_web()[flange].opened(inner, outer)

    return WingEffect(
        name="spar_skin_debond",
        parameter="share of the shear between spar and skin that is lost over the length",
        unit="-",
        prior_sd=0.5,
        prior_source="a peeled bond passes no shear (1), a kissing one a part",
        separated_by="a signature on the gauges next to the spar alone; a tap test along the spar finds it",
        words="debonding of spar and skin",
        words_at="debonding of spar and skin at {place}",
        action="inspect the bond of spar and skin at {place}",
        says=(
            "a share of {size} of the shear between them is lost",
            "the shear between them is larger by a share of {size}",
        ),
        load_power=1,
        strains=strains,
        place_names=tuple(f"{flange} eta {inner:.3f}-{outer:.3f}" for flange in FLANGES for inner, outer in inside),
        n_between=4,
        signature_error=0.4,
        is_one_sided=True,
        bounds=(0.0, 1.0),
    )
