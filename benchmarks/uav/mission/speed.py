"""Time of each part per reading, and memory of a long stream. CPU seconds, one thread, median of five."""

import resource
import time
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from benchmarks.uav.mission.aircraft import NOISE_SD, Aircraft
from octmip.monitor import Monitor, Refusal
from octmip.monitor.stream import Reading

BATCH = 100_000


def speed_rows(aircraft: Aircraft, n_stream: int, seed: int) -> list[dict[str, object]]:
    """Return microseconds per reading of every part, and what a stream of `n_stream` readings took."""
    rng = np.random.default_rng(seed)
    selector, compiled = aircraft.selector, aircraft.selector.compiled
    strains = selector.library.strains[rng.integers(selector.library.n_states, size=BATCH)]
    readings = 3.0 * strains + rng.normal(0.0, NOISE_SD, strains.shape)
    features, few = readings / 3.0, list(readings[:20_000] / 3.0)
    chain, watch = aircraft.filter(16), aircraft.watch()
    chain.likelihood.log_likelihood(readings[:1], 3.0)  # the leaf table is made once
    beliefs, monitor_states = [chain.start(state=0)], [watch.start()]

    def one_step() -> None:
        for row in readings[:200]:
            beliefs[0] = chain.step(beliefs[0], row[None], 3.0)

    def one_look() -> None:
        for row in readings[:200]:
            monitor_states[0] = watch.observe(monitor_states[0], row[None], 3.0)

    rows: list[dict[str, object]] = [
        {"part": "compiled tree, one reading", "us": _micro(lambda: [compiled.label(row) for row in few], len(few))},
        {"part": f"compiled tree, batch of {BATCH}", "us": _micro(lambda: compiled.labels(features), BATCH)},
        {"part": "filter, one reading (256 cells, 9 growth rates)", "us": _micro(one_step, 200)},
        {"part": f"watch, one reading ({len(watch.hypotheses)} hypotheses)", "us": _micro(one_look, 200)},
    ]
    return [*rows, _stream_row(selector.library.gauges, Monitor(selector), readings, n_stream)]


def _micro(work: Callable[[], object], n: int) -> float:
    work()
    seconds = []
    for _ in range(5):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return round(1e6 * float(np.median(seconds)) / n, 3)


def _stream_row(gauges: tuple[str, ...], monitor: Monitor, readings: NDArray[np.float64], n: int) -> dict[str, object]:
    """Return what a stream took in which every thousandth reading is bad: NaN, too short, or of an unknown gauge."""
    rows = readings[:1000].tolist()
    bad: list[Reading] = [
        (3.0, [float("nan"), *rows[0][1:]]),
        (3.0, rows[0][:-1]),
        (3.0, {**dict(zip(gauges, rows[0], strict=True)), "g99": 1.0}),
    ]

    def stream(length: int) -> Iterator[Reading]:
        for k in range(length):
            yield bad[k // 1000 % 3] if k % 1000 == 999 else (3.0, rows[k % 1000])

    for _ in monitor.run(stream(10_000)):
        pass
    before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
    refused = sum(isinstance(answer, Refusal) for answer in monitor.run(stream(n)))
    seconds = time.process_time() - start
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    part = f"stream of {n:.0e} readings: {refused} refused, memory grew by {grown / 1024:.1f} MB"
    return {"part": part, "us": round(1e6 * seconds / n, 3)}
