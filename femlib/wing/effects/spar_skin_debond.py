"""Spar-skin debond: over a length the web slides along the skin, so no shear passes between them.

letter = word: t spanwise displacements of the web's edge at the nodes of the length, K_w stiffness of the row of web
elements at that edge, K the wing's, u its displacements. Where the edge slides freely it is condensed out of its row,

    K_debonded = K - W T^-1 W',   W = K_w[:, t],   T = K_w[t, t],

and by Woodbury the debonded wing moves by K^-1 W (T - W' K^-1 W)^-1 W' u more. Exact for a whole debond (size 1) of
the healthy wing; sizes between are linear, at the price of some ten per cent of the trace. The skin keeps touching the
web: only the sliding is free.
Source: W. W. Hager, SIAM Review 31 (1989) 221-239, eq. 2 (Woodbury); R. J. Guyan, AIAA Journal 3 (1965) 380.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
import scipy.sparse as sparse

from femlib.arrays import BoolArray, FloatArray, IntArray
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
    row : FloatArray
        T of all nodes (n, n).
    answer : FloatArray
        W' K^-1 W (n, n).
    strains : FloatArray
        Gauge strains of forces W (n_gauges, n) [microstrain].
    """

    eta: FloatArray
    tied: FloatArray
    row: FloatArray
    answer: FloatArray
    strains: FloatArray

    def opened(self, inner: float, outer: float) -> FloatArray:
        """Return the change of the gauge strains (n_gauges,) where the nodes from `inner` to `outer` slide."""
        free = (self.eta >= inner - 1e-9) & (self.eta <= outer + 1e-9)
        block = (self.row - self.answer)[np.ix_(free, free)]
        return np.asarray(self.strains[:, free] @ np.linalg.solve(block, self.tied[free]))


@dataclass(frozen=True, slots=True, eq=False)
class SparSkinDebond(WingEffect):
    """The effect, solved exactly from one set of solutions for all its places."""

    _joints: dict[str, Joint] = field(init=False, repr=False, default_factory=dict)

    def signature(
        self, twin: Any, state: Mapping[str, float], load_factor: float, variant: str = "", time: float = 0.0
    ) -> FloatArray:
        """Return the change of the gauge strains (n_gauges,) in microstrain per unit of size, of the healthy wing."""
        flange, _, lengths = variant.split()
        inner, outer = (float(eta) for eta in lengths.split("-"))
        if flange not in self._joints:
            self._joints[flange] = joint(self.response, flange)
        return load_factor * self._joints[flange].opened(inner, outer)


def joint(response: Response, flange: str) -> Joint:
    """Return the joint of the web with the upper or lower skin."""
    wing = response.wing
    elements, nodes = web_edge(wing, flange)
    sliding = DOFS_PER_NODE * nodes + 1
    columns = sparse.csc_array(wing.structure.shells.stiffness(elements)[:, sliding])
    moved = response.moved_by({}, columns.toarray())
    return Joint(
        eta=wing.structure.shells.mesh.nodes[nodes, 1] / wing.span,
        tied=columns.T @ response.displacements({}),
        row=columns[sliding].toarray(),
        answer=np.asarray(columns.T @ moved),
        strains=MICRO * np.asarray(wing.strain_rows @ moved),
    )


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

    def force(state: Mapping[str, float], load_factor: float, place: str) -> FloatArray:
        return np.zeros_like(response.wing.lift)

    lengths = [(c - 0.5 * w, c + 0.5 * w) for c, w in product(SPAN_CENTRES.tolist(), SPAN_WIDTHS)]
    inside = [(inner, outer) for inner, outer in lengths if inner > 0.0 and outer < 1.0]
    return SparSkinDebond(
        name="spar_skin_debond",
        parameter="share of the shear between spar and skin that is lost over the length",
        unit="-",
        prior_sd=0.5,
        prior_source="a peeled bond passes no shear (1), a kissing one a part",
        separated_by="a trace on the gauges next to the spar alone; a tap test along the spar finds it",
        load_power=1,
        response=response,
        force=force,
        places=tuple(f"{flange} eta {inner:.3f}-{outer:.3f}" for flange in FLANGES for inner, outer in inside),
        n_between=4,
        signature_error=0.1,
        is_one_sided=True,
    )
