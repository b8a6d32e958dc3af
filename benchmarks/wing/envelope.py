"""What load factor a damaged wing bears: curves with their uncertainty, and the flight envelope.

    python -m benchmarks.wing.envelope [--refinement 0.5] [--picture FILE.png]
    python -m benchmarks.wing.envelope --trim 25 35
    python -m benchmarks.wing.envelope --meshes | --regions

`built_wing` under its elliptic lift. The uncertainty has two parts: the modulus scale that the authors measured (their
100 samples) and the strains that plies bear (a coefficient of variation of `STRENGTH_CV`, assumed). Both scale the
limits: a modulus scale e multiplies all three, a strength the first. With --trim only what the
lift that moves as the wing twists changes, at these speeds [m/s]; with --meshes and --regions only what meshes change.
"""

import argparse
import time
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from femlib.rom.capability import LIMITS, Capability, drawn_states, first_ply
from femlib.wing import FlightPoint, ReducedWing, Wing, reduce_wing, uav_wing
from femlib.wing.built import BUILT_MASS, built_library, built_wing
from femlib.wing.strength import wing_capability, wing_limits, wing_stresses
from femlib.wing.structure import CARBON_LENGTH, SKIN_STRAINS, WOOD_STRAINS
from femlib.wing.trim import trim_wing
from octmip.interfaces.report.markdown import markdown_table

Floats = NDArray[np.float64]
FLOWN = 3.0
"""Load factor of the study's tight turns."""
STRENGTH_CV = 0.08
"""Coefficient of variation of the strains that plies bear. Assumed."""
N_DRAWS = 4000
DAMAGE = np.linspace(0.0, 0.9, 46)
KINDS = {"mu1": (1.0, 0.0), "mu2": (0.0, 1.0), "mu1 and mu2": (1.0, 1.0)}
SHOWN = (0.0, 0.4, 0.6, 0.8)
TRIM_STATES = ((0.0, 0.0), (0.4, 0.0), (0.8, 0.0), (0.0, 0.8), (0.8, 0.8))
MESHES = (
    *((refinement, 0.0) for refinement in (0.5, 1.0, 2.0)),
    *((k * 0.5, CARBON_LENGTH / k) for k in (1.0, 2.0)),
)
"""Refinements, and distances of the first lines beside edges [m]."""
DENSITY, MOST_LIFT, FASTEST = 1.225, 1.4, 40.0
"""Of air [kg/m^3]; the wing's greatest lift coefficient and the fastest speed [m/s] of the picture, assumed."""
COLOURS = {"mu1": "#c2410c", "mu2": "#1d4ed8", "mu1 and mu2": "#222222"}


def main() -> None:
    """Print the tables, and draw what is asked for."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.envelope", description=__doc__)
    parser.add_argument("--refinement", type=float, default=0.5)
    parser.add_argument("--picture", help="PNG file to write")
    parser.add_argument("--trim", type=float, nargs="*", help="speeds [m/s] of a wing in trim, instead")
    parser.add_argument("--meshes", action="store_true", help="the first ply on several meshes, instead")
    parser.add_argument("--regions", action="store_true", help="each of 28 regions on two meshes, instead")
    options = parser.parse_args()
    if options.meshes or options.regions:
        print(markdown_table(list(mesh_rows() if options.meshes else region_rows(options.refinement))))
        return
    wing = built_wing(refinement=options.refinement, edge_step=CARBON_LENGTH)
    start = time.process_time()
    reduced = reduce_wing(wing)
    finer = built_wing(refinement=2.0 * options.refinement, edge_step=0.5 * CARBON_LENGTH)
    capable = wing_capability(wing, reduced, finer=None if options.trim else finer)
    if options.trim:
        print(markdown_table([row for speed in options.trim for row in trim_rows(wing, reduced, capable, speed)]))
        return
    errors = f"largest error of a limit {capable.error:.1e}, by the mesh {capable.mesh_error:.1e}"
    words = f"set-up {time.process_time() - start:.0f} CPU s; {errors}"
    print(f"{words}; {cost(capable)}")
    print(
        f"assumed strains that plies bear (tension, compression, shear): carbon {SKIN_STRAINS}, plywood {WOOD_STRAINS}"
    )
    print(f"first ply: {weakest(wing)}")
    print(f"first ply of uav_wing: {weakest(uav_wing(refinement=options.refinement))}")
    for rows in (curve_rows(capable), crossing_rows(capable)):
        print(f"\n{markdown_table(rows)}", flush=True)
    if options.picture:
        picture(capable, wing).savefig(options.picture, dpi=110)


def mesh_rows() -> Iterator[dict[str, object]]:
    """Yield the load factor at which the first ply fails with mu1 lost, by mesh."""
    for refinement, step in MESHES:
        start = time.process_time()
        wing = built_wing(refinement=refinement, edge_step=step)
        row: dict[str, object] = {"refinement": refinement, "first line mm": round(1e3 * step, 2)}
        row["unknowns"] = wing.structure.shells.mesh.n_dofs
        for damage in (0.0, 0.4, 0.8):
            row[f"{100 * damage:.0f} % lost"] = round(_first(wing, np.array([damage, 0.0])), 3)
        yield row | {"CPU s": round(time.process_time() - start)}


def region_rows(refinement: float) -> Iterator[dict[str, object]]:
    """Yield the same with 80 % of each of the 28 regions lost, and in 12 drawn states, on a mesh and a finer one."""
    own, fine = (
        built_wing(refinement=k * refinement, regions=built_library(), edge_step=CARBON_LENGTH / k) for k in (1.0, 2.0)
    )
    each = 0.8 * np.eye(len(own.parameters))
    states = np.concatenate([0.0 * each[:1], each, drawn_states(np.random.default_rng(2), 12, len(own.parameters))])
    for state in states:
        bears = [_first(wing, state) for wing in (own, fine)]
        lost = (
            " ".join(own.regions[k].name for k in np.flatnonzero(state)[:3]) if np.count_nonzero(state) < 4 else "all"
        )
        row: dict[str, object] = {"lost": lost or "none", "bears": round(bears[0], 3), "finer": round(bears[1], 3)}
        yield row | {"off %": round(100.0 * (bears[0] / bears[1] - 1.0), 2)}


def _first(wing: Wing, state: Floats) -> float:
    moved = wing.structure.solve(state[None], wing.lift)[0]
    return first_ply(wing.structure, wing_limits(wing), moved)


def trim_rows(wing: Wing, reduced: ReducedWing, capable: Capability, speed: float) -> list[dict[str, object]]:
    """Return what trim at a speed changes in strains of the gauges, root moment and capability, and the divergence."""
    trimmed = trim_wing(wing, FlightPoint(airspeed=speed), FLOWN)
    start = time.process_time()
    moving = wing_capability(wing, trimmed, n_checks=2)
    print(f"{speed:g} m/s: set-up {time.process_time() - start:.0f} CPU s, error {moving.error:.1e}; {cost(moving)}")
    states = np.array(TRIM_STATES)
    still, there = reduced.strains_microstrain(states, FLOWN), trimmed.strains_microstrain(states)
    bears = [own.load_factors(states).tolist() for own in (capable, moving)]
    diverges = np.sqrt(2.0 * trimmed.divergence_pressures(states) / DENSITY).tolist()
    y, rows = wing.structure.shells.mesh.nodes[:, 1], []
    for k, state in enumerate(states):
        moment = float(trimmed.lift(state)[2::6] @ y / (wing.lift[2::6] @ y)) - 1.0
        change = 100.0 * (there[k] / still[k] - 1.0)
        row: dict[str, object] = {"speed m/s": speed, "mu1 %": 100 * state[0], "mu2 %": 100 * state[1]}
        row |= {"root moment %": round(100 * moment, 2), "strains % from": round(float(change.min()), 2)}
        row |= {"strains % to": round(float(change.max()), 2), "bears rigid": round(bears[0][k], 3)}
        row |= {"bears in trim": round(bears[1][k], 3), "change %": round(100 * (bears[1][k] / bears[0][k] - 1), 2)}
        rows.append(row | {"diverges at m/s": round(diverges[k], 1)})
    return rows


def cost(capable: Capability) -> str:
    """Return in words what a state costs, one at a time, states drawn as for the check."""
    states = drawn_states(np.random.default_rng(1), 200, len(capable.parameters))
    times = []
    for state in states:
        start = time.process_time()
        capable.limits(state[None])
        times.append(1e3 * (time.process_time() - start))
    return f"{np.median(times):.2f} CPU ms a state in the median, {np.max(times):.2f} at most of {len(states)}"


def weakest(wing: Wing) -> str:
    """Return in words where plies of the sound wing and of mu1 = 80 % fail first, by the full model."""
    mesh, words = wing.structure.shells.mesh, []
    for name, state in (("sound", {}), ("mu1 80 %", {"mu1": 0.8})):
        found = wing_stresses(wing, state, 1.0)
        factors = found.failure_factors("max strain")
        k = int(factors.argmin())
        place = mesh.nodes[found.node[k]] / wing.span
        patch = mesh.patches[mesh.patch_of_element[found.element[k]]]
        error = f"strains {100 * found.error:.0f} % by energy"
        words.append(f"{name}: {patch} at eta {place[1]:.3f}, load factor {factors[k]:.2f} ({error})")
    return "; ".join(words)


def drawn(limits: Floats, seed: int = 0) -> Floats:
    """Return capabilities (n_draws, n_states) of limits (n_states, 3) with drawn modulus scales and strengths."""
    rng = np.random.default_rng(seed)
    scales = np.loadtxt(SHARED / "uav" / "modulus_scale_samples.csv")
    scale, strength = rng.choice(scales, N_DRAWS), np.exp(rng.normal(0.0, STRENGTH_CV, N_DRAWS))
    factors = np.column_stack([scale * strength, scale, scale])
    return np.asarray((factors[:, None] * limits[None]).min(axis=2))


def curve_rows(capable: Capability) -> list[dict[str, object]]:
    """Return the capability along each kind of damage, with the limit that counts and 5 to 95 %."""
    rows: list[dict[str, object]] = []
    for kind, along in KINDS.items():
        limits = capable.limits(DAMAGE[:, None] * np.array(along))
        low, high = np.quantile(drawn(limits), [0.05, 0.95], axis=0)
        for k, damage in enumerate(DAMAGE.tolist()):
            row: dict[str, object] = {"damage": kind, "lost %": round(100 * damage), "bears": round(limits[k].min(), 3)}
            row |= {"5 %": round(low[k], 3), "95 %": round(high[k], 3), "limit": LIMITS[int(limits[k].argmin())]}
            rows.append(row | {name: round(value, 3) for name, value in zip(LIMITS, limits[k].tolist(), strict=True)})
    return rows


def crossing_rows(capable: Capability) -> list[dict[str, object]]:
    """Return the damage at which the flown load factor is no longer borne, and P(not borne) at 40 %."""
    rows: list[dict[str, object]] = []
    for kind, along in KINDS.items():
        grid = np.linspace(0.0, 0.9, 181)
        limits = capable.limits(grid[:, None] * np.array(along))
        fails = drawn(limits) < FLOWN
        first = np.where(fails.any(axis=1), grid[fails.argmax(axis=1)], np.inf)
        low, middle, high = (100 * np.quantile(first, q, method="inverted_cdf") for q in (0.05, 0.5, 0.95))
        row: dict[str, object] = {"damage": kind, "3 g fails at %": _percent(middle), "5 %": _percent(low)}
        row |= {"95 %": _percent(high), "P(fails at 40 %)": round(float(fails[:, 80].mean()), 3)}
        rows.append(row)
    return rows


def _percent(value: float) -> str:
    return f"{value:.0f}" if np.isfinite(value) else "never"


def picture(capable: Capability, wing: Wing) -> Figure:
    """Return the curves with their bands, and the envelope of speed and load factor that shrinks with damage."""
    figure = Figure(figsize=(11, 4.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for kind, along in KINDS.items():
        limits = capable.limits(DAMAGE[:, None] * np.array(along))
        low, high = np.quantile(drawn(limits), [0.05, 0.95], axis=0)
        left.fill_between(100 * DAMAGE, low, high, color=COLOURS[kind], alpha=0.15, lw=0)
        style = {"lw": 4, "alpha": 0.6} if kind == "mu1" else {"lw": 1.5}  # mu1 alone and both lie on one line
        left.plot(100 * DAMAGE, limits.min(axis=1), color=COLOURS[kind], label=kind, **style)
    left.axhline(FLOWN, color="#5b6670", ls="--", lw=1)
    left.annotate("3 g turns of the mission", (1, FLOWN), xytext=(0, 4), textcoords="offset points", fontsize=8)
    left.axvline(40.0, color="#5b6670", ls=":", lw=1)
    left.annotate("the paper's 40 %", (40, 0.1), xytext=(4, 0), textcoords="offset points", fontsize=8)
    left.set(xlabel="stiffness lost [%]", ylabel="greatest load factor [g]", ylim=(0.0, None), xlim=(0.0, 90.0))
    left.set_title("what the wing bears; bands of 5 to 95 %", fontsize=10)
    left.legend(fontsize=8)
    _envelope(right, capable, wing)
    return figure


def _envelope(axis: Axes, capable: Capability, wing: Wing) -> None:
    area = 2.0 * wing.span * 0.5 * (wing.planform.root_chord + wing.planform.tip_chord)
    stall = np.sqrt(2.0 * BUILT_MASS * 9.81 / (DENSITY * area * MOST_LIFT))
    speeds = np.linspace(0.0, FASTEST, 400)
    for k, damage in enumerate(SHOWN):
        bears = float(capable.load_factors(damage * np.ones((1, 2)))[0])
        top = np.minimum((speeds / stall) ** 2, bears)
        colour = str(0.95 - 0.09 * k)
        axis.fill_between(speeds, 0.0, top, color=colour, lw=0)
        axis.plot([*speeds, FASTEST], [*top, 0.0], color="#222222", lw=0.8)
        label = f"{100 * damage:.0f} % lost: {bears:.2f} g"
        place = (FASTEST, bears)
        axis.annotate(label, place, xytext=(-4, -11), textcoords="offset points", ha="right", fontsize=8)
    axis.axhline(FLOWN, color="#c2410c", ls="--", lw=1)
    axis.set(xlabel="speed [m/s]", ylabel="load factor [g]", xlim=(0.0, FASTEST), ylim=(0.0, None))
    axis.set_title("flight envelope by loss in both regions: stall on the left, strength on top", fontsize=10)


if __name__ == "__main__":
    run_main(main)
