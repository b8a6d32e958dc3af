"""Training samples from strains: libraries of states, loads, noise, the study's recipe, files of any length."""

from femlib.dataset.published import published_strains
from femlib.dataset.samples import (
    Dataset,
    MeanStrains,
    Recipe,
    build_dataset,
    simulated_strains,
    study_states_percent,
)
from femlib.dataset.sampling import Load, Sampling
from femlib.dataset.states import StateLibrary, grid_states, listed_states, random_states
from femlib.dataset.stream import StoredDataset, open_dataset, stream_dataset

__all__ = [
    "Dataset",
    "Load",
    "MeanStrains",
    "Recipe",
    "Sampling",
    "StateLibrary",
    "StoredDataset",
    "build_dataset",
    "grid_states",
    "listed_states",
    "open_dataset",
    "published_strains",
    "random_states",
    "simulated_strains",
    "stream_dataset",
    "study_states_percent",
]
