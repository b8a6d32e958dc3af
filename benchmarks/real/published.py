"""The published strain table as the asset, femlib's wing as the twin: a real gap between two models of one wing.

The table holds means without noise; noise of the study's recipe (variance 1000, 50 readings) is added so that the
diagnosis has repeats to estimate it from. There is no commissioning run: the difference of the two models is the
subject.
"""

import csv
from pathlib import Path

import numpy as np

from femlib.wing import uav_twin
from octmip.gap import Campaign, diagnose
from octmip.gap.words import page_of_words

DATA = Path(__file__).resolve().parents[2].parent / "shared" / "uav" / "strains.csv"
STATES = ((0, 0), (40, 0), (0, 40), (60, 60))
REPEATS, VARIANCE = 50, 1000.0


def campaign(seed: int = 0) -> Campaign:
    """Return the table's means in some states at load factors 2 and 3, with noise."""
    rng = np.random.default_rng(seed)
    names = tuple(f"g{k:02d}" for k in range(1, 25))
    rows = []
    with DATA.open() as file:
        for row in csv.DictReader(file):
            state = (int(row["mu1_percent"]), int(row["mu2_percent"]))
            if row["kind"] != "mean" or state not in STATES:
                continue
            mean = np.array([float(row[f"strain_{k:02d}"]) for k in range(1, 25)])
            load = float(row["load_factor"])
            noise = rng.standard_normal((REPEATS, 24)) * np.sqrt(VARIANCE)
            rows += [(f"{state[0]}-{state[1]}", load, state, reading) for reading in mean + noise]
    n = len(rows)
    return Campaign(
        gauges=names,
        parameters=("mu1", "mu2"),
        test=tuple(row[0] for row in rows),
        load_factor=np.array([row[1] for row in rows]),
        states=np.array([row[2] for row in rows]) / 100.0,
        readings=np.array([row[3] for row in rows]),
        time=np.full(n, np.nan),
        temperature=np.full(n, np.nan),
    )


if __name__ == "__main__":
    print(page_of_words(diagnose(campaign(), uav_twin())))
