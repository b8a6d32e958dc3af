"""A twin of six gauges as a module, and a campaign of three loads that it explains."""

from pathlib import Path

import numpy as np
import pandas as pd

TWIN = """
import numpy as np

class Asset:
    gauges = tuple(f"g{k}" for k in range(6))
    effects = {}

    def predict(self, state, load_factor):
        for _ in range({repeats}):
            answer = load_factor * np.arange(1.0, 7.0)
        return answer

class Cracked(Asset):
    parameters = ("crack",)

    def predict(self, state, load_factor):
        return (1.0 + state.get("crack", 0.0)) * super().predict(state, load_factor)
"""


def write_campaign(folder: Path, rng: np.random.Generator, repeats: int = 20_000) -> None:
    """Write `campaign.csv` and the twin, `asset.py`; it works as long as so many repeats take."""
    (folder / "asset.py").write_text(TWIN.replace("{repeats}", str(repeats)))
    loads = np.repeat([0.0, 0.5, 1.0], 10)
    readings = loads[:, None] * np.arange(1.0, 7.0) + rng.normal(0.0, 0.01, (30, 6))
    columns = {"test": np.repeat([0, 1, 2], 10), "load_factor": loads, "time": np.arange(30.0)}
    frame = pd.DataFrame(columns | {f"g{k}": readings[:, k] for k in range(6)})
    frame.to_csv(folder / "campaign.csv", index=False)
