"""The wing's reduced model beside the full model and beside pyMOR's reduced basis: error, bound, time.

For two regions and for 28: the worst gauge error over random states (load factor 3), how often the bound was below it,
processor time of a query and of a state in a batch. The truth is the structure at its ports, solved exactly, which is
itself compared with the full model. pyMOR takes part on the coarse mesh: its solver needs seconds per snapshot on
the default one. The default mesh with 28 regions needs `--limit 600`.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version

import numpy as np
from numpy.typing import NDArray

from benchmarks.tables import Line, markdown
from benchmarks.wing.damages import random_states
from benchmarks.wing.pymor_basis import PymorBasis, pymor_basis
from femlib.components import PortFlexibility, port_flexibility
from femlib.rom import ReducedModel, ReductionSettings, reduce_ports
from femlib.wing import Wing, uav_wing
from femlib.wing.damage import UAV_REGIONS, damage_library

MICRO = 1e6
LOAD_FACTOR = 3.0
Floats = NDArray[np.float64]
KINDS: dict[int, tuple[tuple[int, float], ...]] = {
    2: ((1, 0.95), (2, 0.95)),
    28: ((1, 0.8), (2, 0.8), (3, 0.8), (28, 0.8), (3, 0.95), (28, 0.95)),
}
"""Kinds of random states: how many regions are damaged, and the most they lose."""
N_STATES = 1000
N_TIMED, N_CALLS, N_BATCH, N_PEER = 15, 40, 10_000, 100
COARSE, DEFAULT = 0.4, 1.0
LONG = 300.0
"""Seconds that 28 regions on the default mesh need."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield the lines of each number of regions and mesh."""
    for refinement in (COARSE, DEFAULT):
        for n_regions in KINDS:
            if (n_regions, refinement) != (28, DEFAULT) or limit >= LONG:
                yield from compared(n_regions, refinement, N_STATES, with_pymor=refinement == COARSE)


def compared(
    n_regions: int, refinement: float, n_states: int, with_pymor: bool, settings: ReductionSettings | None = None
) -> Iterator[Line]:
    """Yield a line for each model and kind of state."""
    wing = uav_wing(refinement=refinement, regions=UAV_REGIONS if n_regions == 2 else damage_library())
    begin = time.process_time()
    exact = port_flexibility(wing.structure, wing.lift, MICRO * wing.strain_rows, wing.gauges.names)
    at_ports = time.process_time() - begin
    model = reduce_ports(exact, settings)
    offline = time.process_time() - begin
    head = {"size": f"{n_regions} regions, refinement {refinement:g}", "seed": 0, "outcome": "measured"}
    head |= {"unknowns": len(wing.structure.supports.free)}
    yield head | _full(wing, exact, at_ports)
    rng = np.random.default_rng(1)
    peer = _peer(wing) if with_pymor else None
    for n_damaged, most in KINDS[n_regions]:
        states = random_states(rng, n_states // len(KINDS[n_regions]), n_regions, n_damaged, most)
        truth = exact.solve(states)
        kind = head | {"damaged": n_damaged, "most_damage": most}
        batch = random_states(rng, N_BATCH if n_regions == 2 else 200, n_regions, n_damaged, most)
        yield kind | {"offline_cpu_seconds": round(offline, 2)} | _reduced(model, states, truth, batch)
        if peer is not None:
            yield kind | _pymor(peer, states[:N_PEER], truth[:N_PEER])


def _reduced(model: ReducedModel, states: Floats, truth: Floats, batch: Floats) -> Line:
    """Return errors, bounds and times of femlib's reduced model."""
    error, bound = np.abs(model.solve(states) - truth), model.error_bound(states)
    return {
        "solver": "femlib reduced",
        "version": f"octmip {version('octmip')}",
        "modes": model.n_modes,
        "worst_error": LOAD_FACTOR * float(error.max()),
        "bound_below_error": int((bound < error).sum()),
        "states": len(states),
        "largest_bound": LOAD_FACTOR * float(bound.max()),
        "bound_over_error": float(np.median(bound / np.maximum(error, 1e-12))),
        "query_microseconds": _microseconds(model.query, states),
        "checked_microseconds": _microseconds(lambda state: model.solve(state[None, :]), states),
        "bound_microseconds": _microseconds(lambda state: model.error_bound(state[None, :]), states, 3),
        "batch_microseconds": 1e6 * _median_seconds(partial(model.solve, batch), 5) / len(batch),
    }


def _pymor(peer: tuple[float, PymorBasis], states: Floats, truth: Floats) -> Line:
    """Return error and times of pymor's reduced basis."""
    built, basis = peer
    error = np.abs(np.array([basis.query(state) for state in states]) - truth)
    return {
        "solver": "pymor",
        "version": f"pymor {version('pymor')}",
        "modes": basis.n_modes,
        "offline_cpu_seconds": round(built, 2),
        "worst_error": LOAD_FACTOR * float(error.max()),
        "states": len(error),
        "query_microseconds": _microseconds(basis.query, states, 10),
        "bound_microseconds": basis.estimate and _microseconds(basis.estimate, states, 3),
    }


def _full(wing: Wing, exact: PortFlexibility, at_ports: float) -> Line:
    """Return the line of the full model: its time, and how far the structure at its ports is from it."""
    states = random_states(np.random.default_rng(2), 5, len(wing.parameters), len(wing.parameters), 0.8)
    strains = wing.strains_microstrain(states, 1.0)  # once before: few regions share one factorisation
    begin = time.process_time()
    wing.strains_microstrain(states, 1.0)
    seconds = (time.process_time() - begin) / len(states)
    return {
        "solver": "femlib full",
        "version": f"octmip {version('octmip')}",
        "modes": len(exact.own),
        "offline_cpu_seconds": round(at_ports, 2),
        "worst_error": LOAD_FACTOR * float(np.abs(exact.solve(states) - strains).max()),
        "states": len(states),
        "query_microseconds": 1e6 * seconds,
    }


def _peer(wing: Wing) -> tuple[float, PymorBasis] | None:
    """Return pyMOR's CPU seconds to build and its model, or None where it is not installed."""
    try:
        version("pymor")
    except PackageNotFoundError:
        return None
    begin = time.process_time()
    basis = pymor_basis(wing, 0.95)
    return time.process_time() - begin, basis


def _microseconds(call: Callable[[Floats], object], states: Floats, calls: int = N_CALLS) -> float:
    """Return the median over states of the processor time of a call [microseconds]."""
    call(states[0])
    spent = []
    for state in states[:N_TIMED]:
        begin = time.process_time()
        for _ in range(calls):
            call(state)
        spent.append((time.process_time() - begin) / calls)
    return 1e6 * float(np.median(spent))


def _median_seconds(call: Callable[[], object], times: int) -> float:
    """Return the median processor time of a call [s]."""
    spent = []
    for _ in range(times):
        begin = time.process_time()
        call()
        spent.append(time.process_time() - begin)
    return float(np.median(spent))


def summary(lines: Sequence[Line]) -> str:
    """Return the table: a row for each model and kind of state."""
    head = ["wing", "model", "modes", "set-up, CPU s", "damaged", "worst error", "bound below error"]
    head += ["largest bound, bound / error", "query, us", "in a batch, us", "bound, us"]
    rows = []
    for line in lines:
        damaged = f"{line['damaged']}, to {100 * line['most_damage']:.0f} %" if "damaged" in line else "all, to 80 %"
        cells = [line["size"], line["solver"], line["modes"], line["offline_cpu_seconds"], damaged]
        cells.append(f"{line['worst_error']:.2g}")
        held = "bound_below_error" in line
        cells.append(f"{line['bound_below_error']} of {line['states']}" if held else "")
        cells.append(f"{line['largest_bound']:.2g}, {line['bound_over_error']:.0f}" if held else "")
        cells += [_number(line.get(f"{name}_microseconds")) for name in ("query", "batch", "bound")]
        rows.append(cells)
    return markdown(head, rows)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"
