"""What damage does to the wing's buckling load, beside CalculiX.

    python -m benchmarks.wing.buckling [--wing built_wing] [--refinement R] [--sound] [--calculix]

Prints Markdown: the least load factors at which the wing buckles, in states of damage. With --calculix (needs `ccx`)
also those of quadratic shells on the same corners.
"""

import argparse
import tempfile
from collections.abc import Iterable
from pathlib import Path

from benchmarks.ccx import need_ccx, run_deck
from benchmarks.main_program import run_main
from femlib.arrays import FloatArray
from femlib.export.calculix_results import read_buckling_factors
from femlib.wing import Wing, buckle, tapered_wing, uav_wing
from femlib.wing.built import built_wing
from femlib.wing.export.calculix import write_deck

N_MODES = 2
WINGS = {"uav_wing": uav_wing, "built_wing": built_wing, "tapered_wing": tapered_wing}
ANY = 100.0
"""Estimated error up to which factors are printed: the default mesh of the wing is refused."""
STATES: tuple[dict[str, float], ...] = (
    {},
    {"mu1": 0.4},
    {"mu1": 0.8},
    {"mu2": 0.4},
    {"mu2": 0.8},
    {"mu1": 0.8, "mu2": 0.8},
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="benchmarks.wing.buckling", description=__doc__)
    parser.add_argument("--refinement", type=float, default=1.0)
    parser.add_argument("--wing", choices=WINGS, default="uav_wing")
    parser.add_argument("--sound", action="store_true", help="the undamaged state alone")
    parser.add_argument("--calculix", action="store_true", help="solve the same states by CalculiX")
    options = parser.parse_args()
    if options.calculix:
        need_ccx()
    wing = WINGS[options.wing](refinement=options.refinement)
    print("| state | load factors, femlib |" + (" CalculiX | first, difference |" if options.calculix else ""))
    print("|---|---|" + ("---|---|" if options.calculix else ""))
    for state in STATES[: 1 if options.sound else None]:
        ours = [mode.factor for mode in buckle(wing, state, N_MODES, limit=ANY)]
        cells = [", ".join(f"{name} {100 * mu:.0f} %" for name, mu in state.items()) or "undamaged", _listed(ours)]
        if options.calculix:
            theirs = calculix_factors(wing, state)
            cells += [_listed(theirs), f"{100 * (ours[0] / theirs[0] - 1.0):+.1f} %"]
        print("| " + " | ".join(cells) + " |", flush=True)


def calculix_factors(wing: Wing, state: dict[str, float]) -> FloatArray:
    """Return the load factors at which CalculiX's model of the wing buckles."""
    with tempfile.TemporaryDirectory() as folder:
        deck = Path(folder) / "wing.inp"
        write_deck(wing, deck, state, 1.0)
        # a step of buckling takes no temperature and prints no strains
        structure, _, step = deck.read_text(encoding="ascii").partition("*INITIAL CONDITIONS")
        forces = step.partition("*CLOAD")[2].partition("*EL PRINT")[0]
        ending = f"*STEP\n*BUCKLE\n{N_MODES}\n*CLOAD{forces}*END STEP\n"
        deck.write_text(structure + ending, encoding="ascii")
        run_deck(deck)
        return read_buckling_factors(deck.with_suffix(".dat"))


def _listed(factors: Iterable[float]) -> str:
    return ", ".join(f"{factor:.3g}" for factor in factors)


if __name__ == "__main__":
    run_main(main)
