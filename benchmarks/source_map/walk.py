"""How far a reader walks from a question to its answer: the files that one call goes through, by what it calls.

From `solve` to `certify`, and from a campaign to its diagnosis. Each is called once before, so that what is made at the
first call alone does not count. A stay is one file that calls another; however often it does so, the reader has read
on once. A climb is a stay that leads to a higher level of `benchmarks/source_map/levels.py`: a call back, which no
import shows. Functions of the native core are not followed.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

import octmip
from benchmarks.source_map.levels import LEVELS, part_of
from benchmarks.tables import Line, markdown
from femlib.wing import WingTwin, uav_wing
from femlib.wing.effects import wing_effects
from octmip.gap import CachedTwin, Campaign, diagnose
from octmip.trees.answer.certificate import certify
from octmip.trees.question.problem import Problem
from octmip.trees.solver import solve

ROOT = Path(octmip.__path__[0])
COARSE = 0.5
"""Refinement of the wing's mesh: what is called does not depend on it."""
Stay = tuple[str, str]
"""Two files of octmip: the one that calls, and the one that is called."""


def results(limit: float, threads: Sequence[int]) -> Iterator[Line]:
    """Yield the figures of each walk."""
    for name, walk in (("problem to certificate", to_certificate()), ("campaign to verdict", to_verdict())):
        walk()
        yield {"size": name, "seed": 0, **figures(stays(walk))}


def figures(walked: Sequence[Stay]) -> Line:
    """Return the files, the stays and the climbs of a walk, and which these are."""
    climbs = sorted(stay for stay in walked if _level(stay[1]) > _level(stay[0]))
    files = {name for stay in walked for name in stay}
    return {"files": len(files), "stays": len(walked), "climbs": len(climbs), "which": [" > ".join(c) for c in climbs]}


def stays(walk: Callable[[], object]) -> list[Stay]:
    """Return the stays of a call in the order in which they are met first."""
    found: dict[Stay, None] = {}

    def followed(frame: FrameType, event: str, _argument: Any) -> None:
        if event != "call" or (here := _file(frame)) is None:
            return
        caller, name = frame.f_back, None
        while caller is not None and (name := _file(caller)) is None:
            caller = caller.f_back
        if name is not None and name != here:
            found[name, here] = None

    sys.setprofile(followed)
    try:
        walk()
    finally:
        sys.setprofile(None)
    return list(found)


def _file(frame: FrameType) -> str | None:
    """Return the dotted name inside octmip of the file that a frame's code stands in; None outside of it."""
    path = Path(frame.f_code.co_filename)
    if not path.is_relative_to(ROOT):
        return None
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def _level(name: str) -> int:
    return LEVELS["octmip"].get(part_of("octmip", name), 0)


def to_certificate() -> Callable[[], object]:
    """Return the call that solves a small problem and certifies the solution.

    20 files need 19 stays. The other 24 are calls of methods of what is asked and answered (`shape`, `problem`, `tree`,
    `solution`, `interruption`) by a second and a third file. Each has its reason:

    solver       registry, options, exact: the method, what it takes, the proof; problem: what is asked;
                 solution: limits and result; interruption: Ctrl-C ends the whole call; certificate: the recount
    registry     problem: loss and shape, which choose the solver
    exact        ranks, costs, native_call: the input of the core and its answer; problem: true costs of a tree;
                 solution: limits and result
    ranks        problem: sensors and allowed features; tree: nodes from rows
    costs        problem: the cost matrix, and splits that have to stand
    problem      tree, class_costs: predictions and what they cost
    solution     interruption: no second is left to a call that was interrupted
    certificate  problem: limits and objective; tree: the way of each sample; solution: the claims
    """
    rng = np.random.default_rng(0)
    features = rng.normal(size=(60, 4)).round(1)
    problem = Problem(features, (features[:, 0] > 0) ^ (features[:, 1] > 0.3), depth=2)
    return lambda: certify(problem, solve(problem, "exact"))


def to_verdict() -> Callable[[], object]:
    """Return the call that diagnoses a small campaign of the wing.

    Half of its stays lead to five files: `twin`, `inputs`, `linear_model`, `candidates` and `gap.twins`.
    """
    wing = uav_wing(refinement=COARSE)
    twin = CachedTwin(WingTwin(wing, wing_effects(wing)))
    loads = np.repeat((0.0, 1.0, 2.0), 5)
    readings = np.array([twin.predict(dict.fromkeys(twin.parameters, 0.0), load) for load in loads])
    noise = np.random.default_rng(0).normal(0.0, 20.0, readings.shape)
    campaign = Campaign(
        gauges=twin.gauges,
        parameters=twin.parameters,
        test=("T0",) * len(loads),
        load_factor=loads,
        states=np.zeros((len(loads), len(twin.parameters))),
        readings=1.25 * readings + noise,  # a gain that the diagnosis is to find
        time=np.arange(len(loads), dtype=np.float64),
        temperature=np.full(len(loads), np.nan),
    )
    return lambda: diagnose(campaign, twin)


def summary(lines: Sequence[Line]) -> str:
    """Return the table of walks."""
    rows = ([line[key] for key in ("size", "files", "stays", "climbs")] for line in lines)
    return markdown(["walk", "files", "stays", "climbs"], rows)
