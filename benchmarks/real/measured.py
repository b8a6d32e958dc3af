"""The UAV wing as it was measured: a tip-load test and two natural frequencies, against femlib's wing.

The twin has three "gauges" that are no strains: the tip deflection [mm] under a hung mass (the load factor, [kg]) and
the squares of the two lowest flapping periods, which are linear in compliance and in mass. The library holds what a
real wing may have: modulus, skin taper, planform as manufactured, mount, structural mass, point masses of unknown
place, the dial gauge's zero and the scale of the masses that were hung.

`python -m benchmarks.real.measured [--picture FILE]` prints the diagnosis and the tables of docs/gap/measured.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import eigh

from benchmarks.data import tip_test, vibration_test
from benchmarks.main_program import run_main
from benchmarks.real.telling import picture_path, show_causes
from femlib.arrays import FloatArray
from femlib.assembly import Mode, matrix_modes, point_masses
from femlib.wing import Wing, tapered_wing
from femlib.wing.effects.planform import manufactured_wing
from femlib.wing.effects.root_flexibility import rolled
from femlib.wing.loads import GRAVITY
from femlib.wing.structure import WingMaterials
from octmip.gap import CHAIN, Campaign, Diagnosis, diagnose
from octmip.twin import Effect, State, Twin

REFINEMENT = 0.5
GAUGES = ("tip", "period_1_squared", "period_2_squared")
SCALES = np.array([1.0, 1e3, 1e4])
"""Millimetres; 1e-3 s^2; 1e-4 s^2: three numbers of one size."""
RINGING_LOAD = 1.0
"""Load factor in whose row the periods stand; they do not depend on it."""
FREQUENCY_SD = 0.002
"""Relative sd of a measured frequency. Assumed: it was published to four decimals without repeats."""
TYPICAL_MASS = 0.3
"""Point mass [kg] up to which the periods are taken as straight lines."""
STATIONS = tuple(float(eta) for eta in np.linspace(0.3, 1.0, 15).round(2))
"""Span fractions at which a point mass may sit."""


@dataclass(frozen=True)
class Answer:
    """What a wing answers: tip deflection [mm] per hung kilogram, periods squared [SCALES], its modes."""

    tip: float
    periods_squared: FloatArray


def answer(wing: Wing, masses: Mapping[float, float] | None = None) -> Answer:
    """Return the answer of a wing that carries point masses [kg] by span fraction."""
    shells = wing.structure.shells
    nodes = {_cap(wing, eta): mass for eta, mass in (masses or {}).items()}
    mass = shells.mass() + point_masses(shells.mesh, nodes)
    modes = matrix_modes(shells.stiffness(), mass, wing.structure.supports, 4)
    flapping = [mode for mode in modes if _flaps(wing, mode.shape)][:2]
    squares = np.array([mode.frequency**-2 for mode in flapping])
    return Answer(1e3 * GRAVITY / wing.tip_stiffness(), SCALES[1:] * squares)


def carrying(wing: Wing, modes: list[Mode], eta: float, mass: float) -> FloatArray:
    """Return the periods squared [SCALES] with a point mass, from modes of the bare wing: m adds m R' R to the masses.

    R holds the three displacements of the mass's node in each mode. Against a solution of the whole structure the
    periods differ by less than a tenth of a per cent (the table of `main`).
    """
    shapes = np.stack([mode.shape for mode in modes], axis=1)
    start = 6 * _cap(wing, eta)
    rows = shapes[start : start + 3]
    stiffness = np.diag([(2.0 * np.pi * mode.frequency) ** 2 for mode in modes])
    squares, mixed = eigh(stiffness, np.eye(len(modes)) + mass * rows.T @ rows)
    flapping = [k for k in range(len(modes)) if _flaps(wing, shapes @ mixed[:, k])][:2]
    return np.asarray(SCALES[1:] * (2.0 * np.pi) ** 2 / squares[flapping])


def _cap(wing: Wing, eta: float) -> int:
    return int(wing.grid.upper[int(np.abs(wing.grid.eta - eta).argmin()), wing.grid.spar_column])


def _flaps(wing: Wing, shape: FloatArray) -> bool:
    tip = 6 * _cap(wing, 1.0)
    return bool(abs(shape[tip + 2]) > abs(shape[tip]))


@dataclass(frozen=True)
class Shift:
    """An effect as its change of the answer per unit of size; the tip's part grows with the load."""

    name: str
    parameter: str
    unit: str
    prior_sd: float
    prior_source: str
    separated_by: str
    changes: Mapping[str, FloatArray]
    is_one_sided: bool = False
    prior_mean: float = 0.0
    load_power: int | None = None

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the places."""
        return tuple(self.changes)

    def signature(self, twin: Twin, state: State, load_factor: float, place: str = "", time: float = 0.0) -> FloatArray:
        """Return the change of the three readings per unit of size."""
        return np.asarray(self.changes[place] * np.array([load_factor, 1.0, 1.0]))


@dataclass(frozen=True)
class DialZero(Shift):
    """The dial gauge's zero: the same at every load."""

    def signature(self, twin: Twin, state: State, load_factor: float, place: str = "", time: float = 0.0) -> FloatArray:
        """Return the change of the three readings per unit of size."""
        return self.changes[place]


@dataclass(frozen=True)
class MeasuredTwin:
    """The wing with the three readings."""

    own: Answer
    gauges: tuple[str, ...] = GAUGES
    parameters: tuple[str, ...] = ()
    effects: Mapping[str, Effect] = field(default_factory=dict)

    def predict(self, state: State, load_factor: float) -> FloatArray:
        """Return the three readings under a hung mass of `load_factor` [kg]."""
        return np.concatenate([[load_factor * self.own.tip], self.own.periods_squared])


def _apart(other: Answer, own: Answer) -> FloatArray:
    return np.concatenate([[other.tip - own.tip], other.periods_squared - own.periods_squared])


def library(wing: Wing, own: Answer) -> dict[str, Effect]:
    """Return the effects, each from the finite elements."""
    cards = wing.materials
    flat = np.concatenate([[own.tip], own.periods_squared])
    heavier = replace(cards, skin_density=1.1 * cards.skin_density, wood_density=1.1 * cards.wood_density)
    fuller = replace(cards, skin_taper=cards.skin_taper + 0.05)
    found: list[Effect] = [
        Shift("modulus", "all moduli above the model's", "%", 3.0, "batches of fabric and plywood differ by so much",
              "a density changes the periods and not the deflection", {"": -0.01 * flat}),
        Shift("skin_taper", "stiffness of the skin at the tip over that at the root, above the model's", "-", 0.05,
              "fitted to strains to some hundredths", "it changes the second period most",
              {"": _apart(answer(_with(fuller)), own) / 0.05}),
        Shift("planform", "share of the way from the designed to the manufactured planform", "-", 1.0,
              "the published measurement of the built wing is 1", "a tape measure",
              {"": _apart(answer(manufactured_wing(wing)), own)}),
        Shift("root_flexibility", "turn of the mount per bending moment at the root", "rad/(kN m)", 0.1,
              "a stiff mount has some hundredths", "as a modulus, but the tip feels three quarters of it",
              {"": _mount(wing)}, is_one_sided=True),
        Shift("structural_mass", "mass of the structure above the model's", "%", 5.0,
              "the wing's weight was never published; 2.3 kg is assumed", "the deflection does not feel it",
              {"": _apart(answer(_with(heavier)), own) / 10.0}),
        Shift("payload_inertia", "mass in the wing that the model does not have", "kg", 0.3,
              "by the published fit servos and pitot weigh 0.47 kg together", "the deflection does not feel it",
              _masses(wing, own), is_one_sided=True),
        DialZero("dial_zero", "zero of the dial gauge", "mm", 0.5, "a hung mass seats the mount by some tenths",
                 "it is the same at every load", {"": np.array([1.0, 0.0, 0.0])}),
    ]  # fmt: skip
    return {effect.name: effect for effect in found} | {"load_factor_error": CHAIN["load_factor_error"]}


def _masses(wing: Wing, own: Answer) -> dict[str, FloatArray]:
    """Return what a kilogram at each station changes, as the secant to TYPICAL_MASS."""
    shells = wing.structure.shells
    modes = matrix_modes(shells.stiffness(), shells.mass(), wing.structure.supports, 12)
    loaded = {eta: Answer(own.tip, carrying(wing, modes, eta, TYPICAL_MASS)) for eta in STATIONS}
    return {f"eta {eta:g}": _apart(other, own) / TYPICAL_MASS for eta, other in loaded.items()}


def _with(materials: WingMaterials) -> Wing:
    return tapered_wing(refinement=REFINEMENT, materials=materials)


def _mount(wing: Wing) -> FloatArray:
    """Return what a mount of 1 rad/(kN m) adds: a turn c M of the root, c = 1e-3 rad/(N m).

    The tip falls by c F span^2. By Rayleigh's quotient of flexibilities a mode phi of unit modal mass has
    1 / omega^2 + c (r' M phi)^2 with r the wing turned by one radian.
    """
    shells = wing.structure.shells
    turned, mass = rolled(wing), shells.mass()
    modes = matrix_modes(shells.stiffness(), mass, wing.structure.supports, 4)
    flapping = [mode for mode in modes if _flaps(wing, mode.shape)][:2]
    moment = np.array([float(turned @ (mass @ mode.shape)) for mode in flapping])
    tip = 1e3 * GRAVITY * 1e-3 * wing.span**2
    return np.concatenate([[tip], SCALES[1:] * (2.0 * np.pi) ** 2 * 1e-3 * moment**2])


@cache
def measured_twin() -> MeasuredTwin:
    """Return the twin with its effects: a handful of eigenvalue problems."""
    wing = tapered_wing(refinement=REFINEMENT)
    own = answer(wing)
    return MeasuredTwin(own, effects=library(wing, own))


def campaign() -> Campaign:
    """Return the measurements: two repeats of four masses, and the two frequencies in a row of their own."""
    tip = tip_test("measurements")
    ringing = SCALES[1:] * np.array(vibration_test().measured) ** -2
    readings = [[value, np.nan, np.nan] for value in tip.deflection] + [[np.nan, *ringing]]
    n = len(readings)
    return Campaign(
        gauges=GAUGES,
        parameters=(),
        test=("tip load",) * (n - 1) + ("ringing",),
        load_factor=np.round([*(tip.load / GRAVITY), RINGING_LOAD], 2),
        states=np.zeros((n, 0)),
        readings=np.array(readings),
        time=np.full(n, np.nan),
        temperature=np.full(n, np.nan),
    )


def noise() -> dict[str, float]:
    """Return the sd of one reading: of the dial from its two repeats, of the periods as assumed."""
    pairs = tip_test("measurements").deflection.reshape(2, -1)
    periods = campaign().readings[-1, 1:]
    own = float(np.sqrt(np.mean((pairs[0] - pairs[1]) ** 2) / 2.0))
    return dict(zip(GAUGES, [own, *(2.0 * FREQUENCY_SD * periods).tolist()], strict=True))


def frequencies(reading: FloatArray) -> FloatArray:
    """Return the frequencies [Hz] of a reading (3,)."""
    return np.sqrt(SCALES[1:] / reading[1:])


def without_second_frequency() -> Campaign:
    """Return the measurements without the second frequency, which is then predicted."""
    whole = campaign()
    readings = whole.readings.copy()
    readings[:, 2] = np.nan
    return replace(whole, readings=readings)


def diagnosis(readings: Campaign | None = None) -> Diagnosis:
    """Return the diagnosis of the measurements."""
    twin = measured_twin()
    return diagnose(campaign() if readings is None else readings, twin, dict(twin.effects), noise_sd=noise())


def table(found: Diagnosis) -> list[tuple[str, float, float, float]]:
    """Return (name, tip stiffness [N/mm], f1 [Hz], f2 [Hz]) of twin, corrected twin, exact solution and measurement."""
    twin = measured_twin()
    masses = {float(p.place.removeprefix("eta ")): p.size for p in found.which[0].parameters if p.unit == "kg"}
    exact = answer(tapered_wing(refinement=REFINEMENT), masses)
    cells = campaign().cells
    tip = np.array([(c.load_factor, c.mean[0]) for c in cells if c.test == "tip load"])
    slope = float(tip[:, 0] @ tip[:, 1] / (tip[:, 0] @ tip[:, 0]))
    lines = [
        ("femlib's bare wing", twin.predict({}, 1.0)),
        ("with the first cause, as diagnosed", found.augmented(twin).predict({}, 1.0)),
        ("with its masses, solved again", np.concatenate([[exact.tip], exact.periods_squared])),
        ("measured", np.array([slope, *campaign().readings[-1, 1:]])),
    ]
    rows: list[tuple[str, float, float, float]] = []
    for name, reading in lines:
        first, second = frequencies(reading).tolist()
        rows.append((name, GRAVITY / reading[0], first, second))
    rows.insert(3, ("published model, masses fitted", tip_test("model").stiffness, *vibration_test().model))
    return rows


def picture(found: Diagnosis, path: str) -> None:
    """Draw deflection over load, and both frequencies of all models over the measured ones."""
    rows = table(found)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    tip = tip_test("measurements")
    left.plot(tip.load, tip.deflection, "o", color="#1b1f24", label="measured, two repeats")
    load = np.linspace(0.0, 10.0, 2)
    for (name, stiffness, *_), style in zip(rows[:2], ("--", "-"), strict=True):
        left.plot(load, load / stiffness, style, color="#2f6db3", label=name)
    left.set(xlabel="tip load [N]", ylabel="tip deflection [mm]", title="Tip load")
    left.legend(frameon=False, loc="upper left")
    wanted = np.array(rows[-1][2:])
    names = [rows[0][0], rows[1][0], rows[3][0]]
    share = np.array([100.0 * (np.array(rows[k][2:]) / wanted - 1.0) for k in (0, 1, 3)])
    for k, colour in enumerate(("#2f6db3", "#8c959f")):
        bars = right.barh(np.arange(3) + 0.2 - 0.4 * k, share[:, k], 0.38, color=colour, label=f"frequency {k + 1}")
        right.bar_label(bars, fmt="%+.1f %%", padding=3)
    right.set_yticks(range(3), names)
    right.invert_yaxis()
    right.axvline(0.0, color="black", linewidth=0.8)
    right.set(xlabel="computed over measured - 1 [%]", title="Natural frequencies", xlim=(-10, 24))
    right.legend(frameon=False, loc="lower right")
    right.margins(y=0.05)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    """Print the causes and the tables, and draw."""
    path = picture_path(__doc__)
    found = diagnosis()
    show_causes(found)
    print("\n| wing | tip stiffness, N/mm | f1, Hz | f2, Hz |\n|---|---|---|---|")
    for name, stiffness, first, second in table(found):
        print(f"| {name} | {stiffness:.3f} | {first:.2f} | {second:.2f} |")
    print("\nWithout the second frequency:")
    shorter = diagnosis(without_second_frequency())
    show_causes(shorter)
    predicted = frequencies(shorter.augmented(measured_twin()).predict({}, 1.0))
    print(f"it predicts {predicted[0]:.2f} and {predicted[1]:.2f} Hz")
    if path:
        picture(found, path)


if __name__ == "__main__":
    run_main(main)
