"""The page of a recorded mission of the aircraft."""

import numpy as np

from benchmarks.uav.mission import course
from benchmarks.uav.mission.aircraft import CRITICAL, Aircraft
from benchmarks.uav.mission.flight import NAMES, POLICY, Flight
from benchmarks.uav.mission.player import Course, Region, mission_page
from octmip.monitor import ParameterTree

KINDS = {
    "paper": "Both regions lose stiffness from 0 to 80 %",
    "own rate": "Each region loses stiffness at a rate of its own",
    "sudden": "A sudden damage",
    "dead gauge": "Both regions lose stiffness, and a gauge dies",
    "outside": "Both regions lose stiffness, and a third that the library lacks",
}


def flight_page(aircraft: Aircraft, flight: Flight) -> str:
    """Return the page of a recorded mission."""
    wing = aircraft.wing
    trees = [ParameterTree.of(file, name) for file, name in zip(aircraft.trees, NAMES, strict=True)]
    regions = [Region(name, wing.region_outline(region)) for name, region in zip(NAMES, wing.regions, strict=False)]
    return mission_page(
        flight.steps,
        flight.library,
        trees,
        twin=aircraft.twin,
        limits=dict.fromkeys(NAMES, CRITICAL),
        traced=flight.traced,
        course=_course(),
        regions=regions,
        title="A self-aware aircraft",
        about=f"{KINDS[flight.kind]}; policy: {POLICY.name}; seed {flight.seed}. {flight.outcome}",
        data=aircraft.source,
    )


def _course() -> Course:
    x = np.linspace(0.0, course.GOAL, 200)
    tight, wide = (np.column_stack([x, course.height(x, np.full(200, width))]) for width in (0.0, 1.0))
    obstacles = tuple((at, 5.0, course.RADIUS) for at in course.OBSTACLES)
    return Course({"tight line, turns of 3 g": tight, "wide line, turns of 2 g": wide}, obstacles, course.GOAL)
