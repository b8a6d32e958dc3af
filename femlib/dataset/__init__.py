"""Training samples from strains: mean strains of a library of states, noisy readings, files."""

from femlib.dataset.files import read_dataset, write_dataset
from femlib.dataset.samples import (
    Dataset,
    MeanStrains,
    Recipe,
    build_dataset,
    published_strains,
    simulated_strains,
    study_states_percent,
)

__all__ = [
    "Dataset",
    "MeanStrains",
    "Recipe",
    "build_dataset",
    "published_strains",
    "read_dataset",
    "simulated_strains",
    "study_states_percent",
    "write_dataset",
]
