"""A five-storey frame pulled at its roof: three frequencies, five displacements, eleven strains.

The twin is a shear frame: columns between floors that do not bend, each storey a spring. In the asset the joints turn,
as beams bend; columns and beams are 3 to 12 % off one by one; the roof's weight softens it (P-delta). The lever arm of
one strain gauge is wrong in the twin, by 12.5 %, as it may be in anybody's.
"""

from collections.abc import Sequence

import numpy as np

from benchmarks.machines.machine import Machine, Numbers, off
from femlib.arrays import FloatArray
from octmip.gap import FunctionTwin, function_twin

N, HEIGHT, SPRING, MASS, DEPTH = 5, 3.0, 4e7, 2e4, 0.15
"""Storeys, their height [m], stiffness [N/m] and mass [kg], half depth of a column [m]."""
READINGS = {f"f{k}": "Hz" for k in (1, 2, 3)} | {f"u{k}": "mm" for k in range(1, 6)}
READINGS |= {f"s{k}": "microstrain" for k in range(1, 12)}
STOREYS = [f"storey_{k}" for k in range(1, 6)]
UPLIFT = 40.0
"""Force beyond which the base lifts off, or a bolt slips [kN]."""


def frame(parameters: Numbers, loads: Numbers) -> Sequence[float]:
    """Return the readings of the user's model."""
    springs = SPRING * np.array([parameters[name] for name in STOREYS])
    heights, mass = HEIGHT * np.arange(1, 6), MASS * np.array([1, 1, 1, 1, parameters["roof_mass"]])
    below = np.minimum.outer(range(N), range(N))
    soft = np.cumsum(1.0 / springs)[below] + parameters["base"] * 1e-9 * np.outer(heights, heights) / 9.0
    root = np.sqrt(mass)
    frequencies = 1.0 / (2.0 * np.pi * np.sqrt(np.linalg.eigvalsh(root[:, None] * soft * root)[::-1][:3]))
    force = 1e3 * loads["force"]
    bent = np.repeat(6e6 * DEPTH * force / (springs * HEIGHT**2), 2)
    return [*frequencies, *(1e3 * force * soft[:, -1]), *bent, 2e-3 * force]


def twin() -> FunctionTwin:
    """Return the user's twin."""
    storeys = dict.fromkeys(STOREYS, (1.0, 0.5, 1.2, "-"))
    other = {"roof_mass": (1.0, 0.7, 1.4, "-"), "base": (1.0, 0.0, 6.0, "nrad/(N m)")}
    return function_twin(frame, READINGS, loads=("force",), parameters={**storeys, **other})


def measure(own: Numbers, faults: Numbers, loads: Numbers) -> FloatArray:
    """Return what the asset shows (n_readings,): displacements and rotations of the floors, condensed."""
    kn = loads["force"]
    beyond = max(0.0, kn - UPLIFT) / 60.0
    ratio = np.array([own[name] * (1.0 + faults.get(name, 0.0)) for name in STOREYS])
    ratio[2] *= 1.0 - faults.get("slipping_bolt", 0.0) * beyond
    ratio *= 1.0 + faults.get("cladding", 0.0) * max(0.0, 1.0 - kn / 60.0)
    bending = ratio * SPRING * HEIGHT**3 / 24.0  # E I of one of the two columns of a storey
    stiff = _stiffness(bending, own["beams"] * 15.0 * SPRING * HEIGHT**3 / 24.0)
    heights = HEIGHT * np.arange(1, 6)
    sway = stiff[:N, :N] - stiff[:N, N:] @ np.linalg.solve(stiff[N:, N:], stiff[N:, :N])
    rocking = (own["base"] + faults.get("base", 0.0)) * 1e-9 * np.outer(heights, heights) / 9.0
    soft = np.linalg.inv(sway - own["weight"] * 2e5 / HEIGHT * np.eye(N)) + rocking
    mass = MASS * np.array([1.0, 1.0, 1.0, 1.0, 1.0 + faults.get("roof_mass", 0.0)])
    root = np.sqrt(mass * own["mass"])
    frequencies = 1.0 / (2.0 * np.pi * np.sqrt(np.linalg.eigvalsh(root[:, None] * soft * root)[::-1][:3]))
    force = 1e3 * kn
    moved = force * soft[:, -1]
    lifted = faults.get("uplift", 0.0) * 1e-3 * beyond**1.5 * heights / heights[-1]
    floors = moved - force * rocking[:, -1]
    turned = np.asarray(-np.linalg.solve(stiff[N:, N:], stiff[N:, :N] @ floors), dtype=np.float64)
    strain = _strains(np.asarray(floors), turned) * 1e6 * DEPTH
    strain[6] *= 1.125
    strain += faults.get("sun", 0.0) * np.cos(np.arange(10.0)) * (1.0 + kn / 100.0)
    return np.array([*frequencies, *(1e3 * (moved + lifted)), *strain, 2e-3 * force * own["brace"]])


def _stiffness(bending: FloatArray, beam: float) -> FloatArray:
    """Return the stiffness (10, 10) of sways and rotations; two columns a storey, a beam bent double on each floor."""
    found = np.zeros((12, 12))
    for k, ei in enumerate(bending):
        h = HEIGHT
        own = 2.0 * ei / h**3 * np.array(
            [[12, -12, 6 * h, 6 * h], [-12, 12, -6 * h, -6 * h],
             [6 * h, -6 * h, 4 * h * h, 2 * h * h], [6 * h, -6 * h, 2 * h * h, 4 * h * h]]
        )  # fmt: skip
        at = [k, k + 1, 6 + k, 7 + k]
        found[np.ix_(at, at)] += own
    found[range(7, 12), range(7, 12)] += 12.0 * beam / 6.0
    free = [*range(1, 6), *range(7, 12)]
    return np.asarray(found[np.ix_(free, free)])


def _strains(floors: FloatArray, turned: FloatArray) -> FloatArray:
    """Return curvature (10,) at the foot and the head of each storey's columns."""
    u, t = np.concatenate([[0.0], floors]), np.concatenate([[0.0], turned])
    drift = (u[1:] - u[:-1]) / HEIGHT
    foot = (6.0 * drift - 4.0 * t[:-1] - 2.0 * t[1:]) / HEIGHT
    head = (6.0 * drift - 2.0 * t[:-1] - 4.0 * t[1:]) / HEIGHT
    return np.ravel(np.stack([foot, head], axis=1))


def own_numbers(rng: np.random.Generator) -> Numbers:
    """Return what makes one frame its own."""
    own = {name: off(rng) for name in (*STOREYS, "beams", "brace", "mass")}
    return {**own, "base": float(rng.uniform(0.5, 1.5)), "weight": float(rng.uniform(0.5, 1.5))}


FRAME = Machine(
    name="frame",
    twin=twin,
    cells=[{"force": f} for f in (20.0, 60.0, 100.0)],
    repeats=8,
    noise=np.array([0.01, 0.03, 0.05] + [0.05] * 5 + [4.0] * 11),
    own=own_numbers,
    measure=measure,
    faults={**dict.fromkeys(STOREYS, (-0.38, -0.12)), "roof_mass": (0.08, 0.3), "base": (0.4, 1.5)},
    outside={
        "slipping_bolt": (0.2, 0.5), "cladding": (0.08, 0.25), "uplift": (1.0, 4.0),
        "sun": (8.0, 25.0),
    },
)  # fmt: skip
