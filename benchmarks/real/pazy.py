"""The Pazy wing: measured tip deflections of a very flexible wing against a linear twin.

The wing with skin was loaded by masses at its tip, at mid-chord (bending) and ahead of the leading edge (torsion).
The twin is linear: the deflection that an aeroelastic code (SHARPy) computes for small masses, continued in
proportion. The library holds scale effects, an offset, and large deflection: what the same code computes beyond
proportion. Heavy masses are held out.

`python -m benchmarks.real.pazy [--picture FILE]` prints the tables of docs/gap/pazy.md.
"""

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, field

import matplotlib.pyplot as plt
import numpy as np

from benchmarks.data import SHARED
from benchmarks.main_program import run_main
from femlib.arrays import FloatArray
from octmip.gap import CHAIN, Campaign, Diagnosis, diagnose
from octmip.interfaces.report.diagnosis.phrases import cause_words, likely, size_words
from octmip.interfaces.report.diagnosis.recommendation import recommend
from octmip.twin import Effect, State, Twin

DATA = SHARED / "pazy"
SETUPS = ("bending", "torsion")
SMALL = 0.3
"""Masses [kg] over which the model's curve is taken as straight."""
HELD_OUT = 1.6
"""Masses above this [kg] are predicted from those up to it."""


@dataclass(frozen=True)
class Curve:
    """A computed deflection curve: mass [kg], deflection below that without mass [mm]."""

    mass: FloatArray
    deflection: FloatArray

    @property
    def slope(self) -> float:
        """Slope for small masses [mm/kg]."""
        small = self.mass <= SMALL
        return float(self.mass[small] @ self.deflection[small] / (self.mass[small] @ self.mass[small]))

    def beyond(self, mass: float) -> float:
        """Return what the curve adds to its own slope [mm]."""
        return float(np.interp(mass, self.mass, self.deflection)) - self.slope * mass


def curve(setup: str) -> Curve:
    """Return the curve of SHARPy for a setup."""
    name = {"bending": "bending/bending_sharpy_w_skin.txt", "torsion": "torsion/torsion_SHARPy_w_skin.txt"}[setup]
    table = np.loadtxt(DATA / name)
    return Curve(table[:, 0], -1000.0 * (table[:, 1] - table[0, 1]))


@dataclass(frozen=True)
class LargeDeflection:
    """What the nonlinear model adds to its own small-mass slope, times size."""

    curves: Mapping[str, Curve]
    name: str = "large_deflection"
    parameter: str = "geometric nonlinearity, 1 is the nonlinear model's"
    unit: str = "-"
    prior_mean: float = 1.0
    prior_sd: float = 0.2
    prior_source: str = "the nonlinear model gives 1, and is trusted to a fifth"
    is_one_sided: bool = True
    separated_by: str = "it grows faster than the load, a scale with the load"
    load_power: None = None

    def places(self, twin: Twin) -> tuple[str, ...]:
        """Return the places: the whole wing."""
        return ("",)

    def signature(self, twin: Twin, state: State, load_factor: float, place: str = "", time: float = 0.0) -> FloatArray:
        """Return the change of both deflections [mm] per unit of size."""
        return np.array([self.curves[setup].beyond(load_factor) for setup in twin.gauges])


@dataclass(frozen=True)
class PazyTwin:
    """The linear twin: two "gauges", the tip deflections of the two setups [mm]; the load factor is the mass [kg]."""

    curves: Mapping[str, Curve]
    gauges: tuple[str, ...] = SETUPS
    parameters: tuple[str, ...] = ()
    effects: Mapping[str, Effect] = field(default_factory=dict)

    def predict(self, state: State, load_factor: float) -> FloatArray:
        """Return both deflections [mm] under a mass of `load_factor` [kg]."""
        return np.array([self.curves[setup].slope * load_factor for setup in self.gauges])


def pazy_twin() -> PazyTwin:
    """Return the linear twin with its effects."""
    curves = {setup: curve(setup) for setup in SETUPS}
    own = LargeDeflection(curves)
    return PazyTwin(curves, effects={own.name: own})


def measured() -> Campaign:
    """Return the measured deflections [mm], relative to the mean without mass."""
    rows = []
    for column, setup in enumerate(SETUPS):
        table = np.loadtxt(DATA / setup / f"{setup}_technion_experimental_w_skin.txt")
        rest = table[table[:, 0] == 0.0, 1].mean()
        for mass, height in table[:, :2]:
            reading = np.full(len(SETUPS), np.nan)
            reading[column] = -1000.0 * (height - rest)
            rows.append((setup, mass, reading))
    n = len(rows)
    return Campaign(
        gauges=SETUPS,
        parameters=(),
        test=tuple(row[0] for row in rows),
        load_factor=np.round([row[1] for row in rows], 6),
        states=np.zeros((n, 0)),
        readings=np.array([row[2] for row in rows]),
        time=np.full(n, np.nan),
        temperature=np.full(n, np.nan),
    )


LIBRARY = ("gauge_gain", "gauge_bias", "load_factor_error", "common_gain")
"""The measuring chain's effects that a deflection can have."""


def diagnosis() -> Diagnosis:
    """Return the diagnosis of all masses."""
    twin = pazy_twin()
    return diagnose(measured(), twin, {name: CHAIN[name] for name in LIBRARY} | dict(twin.effects))


def fitted_to(limit: float) -> Diagnosis:
    """Return the diagnosis of the masses up to `limit` [kg]."""
    twin, campaign = pazy_twin(), measured()
    heavy = {k for k, cell in enumerate(campaign.cells) if cell.load_factor > limit}
    return diagnose(campaign.without(heavy), twin, {name: CHAIN[name] for name in LIBRARY} | dict(twin.effects))


def held_out(limit: float = HELD_OUT) -> tuple[float, float, float]:
    """Fit on masses up to `limit`; return rms before and after [mm], and the share of the squared gap closed beyond."""
    twin, campaign = pazy_twin(), measured()
    heavy = {k for k, cell in enumerate(campaign.cells) if cell.load_factor > limit}
    augmented = fitted_to(limit).augmented(twin)
    before: list[float] = []
    after: list[float] = []
    for k in sorted(heavy):
        cell = campaign.cells[k]
        seen = cell.count > 0
        before += (cell.mean - twin.predict({}, cell.load_factor))[seen].tolist()
        after += (cell.mean - augmented.predict({}, cell.load_factor))[seen].tolist()
    first, second = float(np.mean(np.square(before))), float(np.mean(np.square(after)))
    return float(np.sqrt(first)), float(np.sqrt(second)), 1.0 - second / first


def picture(path: str) -> None:
    """Draw measured, linear and corrected deflections of both set-ups, fitted to masses up to HELD_OUT."""
    twin, campaign = pazy_twin(), measured()
    augmented = fitted_to(HELD_OUT).augmented(twin)
    mass = np.linspace(0.0, 3.2, 65)
    linear = np.array([twin.predict({}, m) for m in mass])
    corrected = np.array([augmented.predict({}, m) for m in mass])
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained", sharey=True)
    for k, (axis, setup) in enumerate(zip(axes, SETUPS, strict=True)):
        told = np.isfinite(campaign.readings[:, k])
        axis.plot(campaign.load_factor[told], campaign.readings[told, k], ".", color="#1b1f24", label="measured")
        axis.plot(mass, linear[:, k], "--", color="#b3261e", label="linear twin")
        axis.plot(mass, corrected[:, k], color="#2f6db3", label=f"corrected, fitted up to {HELD_OUT:g} kg")
        axis.axvspan(HELD_OUT, mass[-1], color="#f3f6fa", zorder=0)
        axis.set(title=setup, xlabel="mass at the tip [kg]")
    axes[0].set_ylabel("tip deflection [mm]")
    axes[0].legend(frameon=False, loc="upper left")
    axes[1].text(2.4, 40.0, "held out", ha="center", color="#57606a")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def show_causes(found: Diagnosis) -> None:
    """Print verdict, causes of more than 2 %, inclusion of more than 5 %, chi-squared, the held-out share."""
    print(recommend(found).replace("microstrain", "mm"))
    for cause in found.which:
        if cause.probability > 0.02:
            print(f"  {likely(cause.probability):>12}  {cause_words(cause)}")
    print("  among the causes:", {name: round(p, 3) for name, p in found.inclusion.items() if p > 0.05})
    closing = found.shrinkage
    if closing is not None:
        print(
            f"  chi-squared per reading {closing.chi2_before:.3g} -> {closing.chi2_after:.3g}, chance of the rest "
            f"{closing.p_after:.2g}"
        )
        print(f"  held out: {closing.before:.1f} -> {closing.after:.1f}, closed {closing.closed:.3f}")


def main() -> None:
    """Print the causes and the held-out gaps, and draw."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.pazy", description=__doc__)
    parser.add_argument("--picture", metavar="FILE.png")
    path = parser.parse_args().picture
    found = diagnosis()
    show_causes(found)
    for size in found.which[0].parameters:
        print(f"  {size_words(size)}")
    print("| fitted up to | rms gap beyond | closed |\n|---|---|---|")
    for limit in (1.2, 1.6, 2.0, 2.4):
        before, after, closed = held_out(limit)
        print(f"| {limit} kg | {before:.0f} -> {after:.1f} mm | {closed:.3f} |")
    if path:
        picture(path)


if __name__ == "__main__":
    run_main(main)
