"""Pictures of docs/gap: `python -m benchmarks.real.pictures SET --data FOLDER --picture FILE.png`."""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from benchmarks.real import beam
from benchmarks.real.quadrotor.flight import READINGS, read_flights

INK, RED, BLUE, GREY = "#1b1f24", "#b3261e", "#2f6db3", "#8a9199"


def draw_beam(folder: Path, path: Path) -> None:
    """Draw both frequencies over the place of the support: twin, what was told, and where the blind stretches lie."""
    known, stretches = beam.knowledge_of(folder)
    roles = pd.read_csv(folder / "tests.csv", index_col="segment").role
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    places = np.linspace(-8.0, 135.0, 60)
    twin = known.twin_in("S")
    sound = twin.ask({}, beam.NO_LOAD, {})
    curve = np.exp([known.sound + twin.ask({}, beam.NO_LOAD, {"support_moved": at}) - sound for at in places])
    sizes = {}
    for one in stretches:
        first = beam.answer(one, known).judged[0]
        if roles[one.case] == "blind" and first.causes:
            sizes[one.case] = first.sizes[0]
    for k, axis in enumerate(axes):
        axis.plot(places, curve[:, k], color=GREY, label="twin, with what it misses")
        for one in stretches:
            if one.case in sizes:
                middle, low, high = sizes[one.case]
                reading = np.exp(one.log[k])
                axis.errorbar(middle, reading, xerr=[[middle - low], [high - middle]], fmt=".", color=BLUE, lw=0.7)
        axis.plot([0.0, *known.moved], np.exp(told_logs(known))[:, k], "o", color=RED, label="told")
        axis.plot([], [], ".", color=BLUE, label="blind, 90 % interval")
        axis.set(xlabel="support moved away from the clamp [mm]", ylabel=f"{('first', 'second')[k]} frequency [Hz]")
    axes[0].legend(frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def told_logs(known: beam.Knowledge) -> np.ndarray:
    """Return the logarithms of the frequencies that commissioning and practice gave (1 + m, 2)."""
    changes = [
        known.twin.ask({}, beam.NO_LOAD, {"support_moved": moved}) - known.twin.ask({}, beam.NO_LOAD, {}) + missed
        for moved, missed in zip(known.moved, known.missed, strict=True)
    ]
    return np.array([known.sound, *(known.sound + change for change in changes)])


def draw_quadrotor(folder: Path, path: Path) -> None:
    """Draw pitch and yaw commands of all flights, and the yaw command's difference between both ways over the roll."""
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.6), layout="constrained")
    practice = pd.read_csv(folder / "practice.csv", index_col="flight").condition
    marks = {"P": "o", "Q": "^"}
    flights = read_flights(folder)
    for axis, (across, up) in zip(axes, (("pitch", "yaw"), ("roll", "yaw_way")), strict=True):
        columns = READINGS.index(across), READINGS.index(up)
        for flight in flights.values():
            x, y = flight.readings[list(columns)]
            colour = {"blind": GREY, "commissioning": BLUE, "practice": RED}[flight.role]
            axis.plot(x, y, marks[flight.airframe], color=colour, markersize=4 if flight.role == "blind" else 6)
            if flight.name in practice.index:
                words = practice[flight.name].replace("weight_", "").replace("_", " ")
                axis.annotate(words, (x, y), (4, 3), textcoords="offset points", fontsize=6, color=RED)
        axis.set(xlabel=f"{across} command [g]", ylabel=f"{up.replace('_way', ', out less back')} command [g]")
    for name, colour in (("commissioning", BLUE), ("practice", RED), ("blind", GREY)):
        axes[0].plot([], [], "o", color=colour, label=name)
    for airframe, mark in marks.items():
        axes[0].plot([], [], mark, color=INK, label=f"airframe {airframe}")
    axes[0].legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    """Read the arguments and draw."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.real.pictures", description=__doc__)
    parser.add_argument("set", choices=("beam", "quadrotor"))
    parser.add_argument("--data", type=Path, required=True, help="folder of the set")
    parser.add_argument("--picture", type=Path, required=True)
    given = parser.parse_args()
    (draw_beam if given.set == "beam" else draw_quadrotor)(given.data, given.picture)


if __name__ == "__main__":
    main()
