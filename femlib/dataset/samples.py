"""From mean strains to the training samples of the study.

The paper's recipe: for each of 25 states (mu1, mu2 in 0, 20, 40, 60, 80 % loss of stiffness) draw s noisy readings at
load factor L = 3, N(mean, 1000 I) microstrain^2, divide by L, leave out the gauges inside the damage regions, and
split the rows 70 / 30 at random into training and test. The same recipe takes the wing's strains or the published
table's.

Source: M. G. Kapteyn, K. E. Willcox, From Physics-Based Models to Predictive Digital Twins via Interpretable Machine
Learning (2020), section 4.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from femlib.arrays import BoolArray, FloatArray, IntArray
from femlib.dataset.gauge_draws import table_noise
from femlib.errors import InputError, frozen_floats, frozen_ints, is_number, is_whole

LEVELS_PERCENT = (0, 20, 40, 60, 80)
"""Losses of stiffness of the study."""
STUDY_PARAMETERS = ("mu1", "mu2")
LOAD_FACTOR = 3.0
"""Load factor at which the study measures."""


class GaugePlaces(Protocol):
    """Names of gauges, and which of them lie outside every region."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names (n_gauges,)."""

    @property
    def is_usable(self) -> BoolArray:
        """Whether each gauge may be used (n_gauges,)."""


@runtime_checkable
class StrainModel(Protocol):
    """A model that a dataset can be made of."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""

    @property
    def gauges(self) -> GaugePlaces:
        """The gauges."""

    @property
    def model_hash(self) -> str:
        """Fingerprint of the model."""

    def strains_microstrain(self, states: FloatArray, load_factor: float) -> FloatArray:
        """Return strains (n_states, n_gauges) of damage fractions (n_states, 2), compressive positive."""


@dataclass(frozen=True, slots=True, eq=False)
class MeanStrains:
    """Noise-free strains of a library of states.

    Attributes
    ----------
    states_percent : IntArray
        Loss of stiffness (n_states, 2) of mu1 and mu2 [%].
    strain_microstrain : FloatArray
        Strains (n_states, n_gauges) at `load_factor`, compressive positive.
    load_factor : float
        Load factor of the strains.
    gauges : tuple of str
        Names (n_gauges,).
    is_usable : BoolArray
        Whether a gauge enters the dataset (n_gauges,).
    source : str
        Where the strains come from.
    model_hash : str
        Fingerprint of the model, "" for a table.

    Examples
    --------
    >>> states = study_states_percent()  # 25 of mu1 and mu2
    >>> strains = 900.0 - 5.0 * states  # (25, 2): one gauge for each damage
    >>> usable = np.array([True, True])
    >>> means = MeanStrains(states, strains, 3.0, ("g1", "g2"), usable, source="a formula", model_hash="")
    >>> means.strain_microstrain[-1].tolist()
    [500.0, 500.0]
    """

    states_percent: IntArray
    strain_microstrain: FloatArray
    load_factor: float
    gauges: tuple[str, ...]
    is_usable: BoolArray
    source: str
    model_hash: str

    def __post_init__(self) -> None:
        n_states, n_gauges = len(self.states_percent), len(self.gauges)
        object.__setattr__(self, "states_percent", frozen_ints(self.states_percent, "states_percent", (-1, 2)))
        strains = frozen_floats(self.strain_microstrain, "strain_microstrain", (n_states, n_gauges))
        object.__setattr__(self, "strain_microstrain", strains)


def study_states_percent() -> IntArray:
    """Return the 25 states (25, 2), mu1 slowest [%].

    >>> study_states_percent()[:3].tolist()
    [[0, 0], [0, 20], [0, 40]]
    """
    mu1, mu2 = np.meshgrid(LEVELS_PERCENT, LEVELS_PERCENT, indexing="ij")
    return np.stack([mu1.ravel(), mu2.ravel()], axis=1).astype(np.int64)


def simulated_strains(model: StrainModel, load_factor: float = LOAD_FACTOR) -> MeanStrains:
    """Return the strains of the 25 states from a model.

    Raises
    ------
    InputError
        If the model has other parameters than mu1 and mu2, or the load factor is not finite.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> def strains(states, load_factor):
    ...     return load_factor * (np.array([900.0, 600.0]) - 200.0 * states)
    >>> gauges = SimpleNamespace(names=("g1", "g2"), is_usable=np.array([True, True]))
    >>> names = {"parameters": ("mu1", "mu2"), "gauges": gauges, "model_hash": ""}
    >>> model = SimpleNamespace(**names, strains_microstrain=strains)
    >>> simulated_strains(model, load_factor=3.0).strain_microstrain[-1].tolist()
    [2220.0, 1320.0]
    """
    if tuple(model.parameters) != STUDY_PARAMETERS:
        raise InputError(
            f"model has the parameters {model.parameters}; expected {STUDY_PARAMETERS}, those of the study; "
            "for other libraries of states use stream_dataset"
        )
    states = study_states_percent()
    strains = model.strains_microstrain(states / 100.0, load_factor)
    return MeanStrains(
        states, strains, load_factor, model.gauges.names, model.gauges.is_usable, "femlib wing", model.model_hash
    )


@dataclass(frozen=True, slots=True)
class Recipe:
    """The recipe of the readings of each state.

    Attributes
    ----------
    samples_per_state : int
        Readings of each state.
    noise_variance : float
        Variance of a reading at the load factor of the strains, before the division [microstrain^2].
    train_fraction : float
        Share of the rows for training.

    Examples
    --------
    >>> Recipe(samples_per_state=10).noise_variance
    1000.0
    """

    samples_per_state: int = 100
    noise_variance: float = 1000.0
    train_fraction: float = 0.7

    def __post_init__(self) -> None:
        if not is_whole(self.samples_per_state) or self.samples_per_state < 1:
            raise InputError(f"samples_per_state is {self.samples_per_state!r}; expected 1 or more; the study uses 100")
        if not is_number(self.noise_variance) or self.noise_variance < 0.0:
            raise InputError(
                f"noise_variance is {self.noise_variance!r}; expected 0 or more microstrain^2; the study uses 1000"
            )
        if not is_number(self.train_fraction) or not 0.0 < self.train_fraction < 1.0:
            raise InputError(f"train_fraction is {self.train_fraction!r}; expected between 0 and 1; the study uses 0.7")


@dataclass(frozen=True, slots=True, eq=False)
class Dataset:
    """Noisy load-normalised readings with their states.

    Attributes
    ----------
    features : FloatArray
        Readings over the load factor (n, n_gauges) [microstrain].
    states : IntArray
        Index of each row's state (n,).
    states_percent : IntArray
        Loss of stiffness (n_states, 2) of mu1 and mu2 [%].
    mean_features : FloatArray
        Noise-free features (n_states, n_gauges) [microstrain].
    gauges : tuple of str
        Names of the columns.
    is_train : BoolArray
        Whether a row is for training (n,).
    load_factor : float
        Load factor of the readings, by which they are divided.
    recipe : Recipe
        How they were drawn.
    seed : int
        Seed of noise and split.
    source, model_hash : str
        Where the mean strains come from.

    Examples
    --------
    >>> states = study_states_percent()  # 25 of mu1 and mu2
    >>> strains = 900.0 - 5.0 * states  # (25, 2): one gauge for each damage
    >>> usable = np.array([True, True])
    >>> means = MeanStrains(states, strains, 3.0, ("g1", "g2"), usable, source="a formula", model_hash="")
    >>> data = build_dataset(means, Recipe(samples_per_state=10))
    >>> data.gauges, data.states_percent[data.states[-1]].tolist(), int(data.is_train.sum())
    (('g1', 'g2'), [80, 80], 175)
    """

    features: FloatArray
    states: IntArray
    states_percent: IntArray
    mean_features: FloatArray
    gauges: tuple[str, ...]
    is_train: BoolArray
    load_factor: float
    recipe: Recipe
    seed: int
    source: str
    model_hash: str

    def __post_init__(self) -> None:
        n, n_gauges = len(self.states), len(self.gauges)
        object.__setattr__(self, "features", frozen_floats(self.features, "features", (n, n_gauges)))
        object.__setattr__(self, "states", frozen_ints(self.states, "states", (n,)))
        object.__setattr__(self, "states_percent", frozen_ints(self.states_percent, "states_percent", (-1, 2)))
        object.__setattr__(self, "mean_features", frozen_floats(self.mean_features, "mean_features", (-1, n_gauges)))
        mask = np.array(self.is_train, dtype=bool)
        mask.flags.writeable = False
        object.__setattr__(self, "is_train", mask)

    @property
    def mu1(self) -> IntArray:
        """Loss of stiffness of region 1 of each row (n,) [%]."""
        return np.asarray(self.states_percent[self.states, 0])

    @property
    def mu2(self) -> IntArray:
        """Loss of stiffness of region 2 of each row (n,) [%]."""
        return np.asarray(self.states_percent[self.states, 1])

    @property
    def noise_sd(self) -> float:
        """Standard deviation of a feature [microstrain], after the division by the load factor."""
        return float(np.sqrt(self.recipe.noise_variance) / self.load_factor)


def build_dataset(means: MeanStrains, recipe: Recipe | None = None, seed: int = 0) -> Dataset:
    """Draw the readings of the recipe (the paper's if not given) from a seed: noise first, then the split.

    A gauge has the same readings, and a row is in the same part, in whatever set and order the gauges come.

    Raises
    ------
    InputError
        If no gauge is usable or the seed is negative.

    Examples
    --------
    >>> states = study_states_percent()  # 25 of mu1 and mu2
    >>> strains = 900.0 - 5.0 * states  # (25, 2): one gauge for each damage
    >>> usable = np.array([True, True])
    >>> means = MeanStrains(states, strains, 3.0, ("g1", "g2"), usable, source="a formula", model_hash="")
    >>> data = build_dataset(means, Recipe(samples_per_state=10), seed=0)
    >>> data.features.shape, data.mean_features[0].tolist()
    ((250, 2), [300.0, 300.0])
    """
    drawn = Recipe() if recipe is None else recipe
    if not is_whole(seed) or seed < 0:
        raise InputError(f"seed is {seed!r}; expected 0 or more; choose another")
    if not means.is_usable.any():
        raise InputError(
            f"none of {len(means.gauges)} gauges is usable; expected at least one outside the regions; move one"
        )
    rng = np.random.default_rng(seed)
    clean = means.strain_microstrain[:, means.is_usable]
    gauges = tuple(name for name, usable in zip(means.gauges, means.is_usable, strict=True) if usable)
    states = np.repeat(np.arange(len(clean)), drawn.samples_per_state)
    deviation = float(np.sqrt(drawn.noise_variance))
    readings = clean[states] + table_noise(gauges, len(states), deviation, seed, rng)
    is_train = np.zeros(len(states), dtype=bool)
    is_train[rng.permutation(len(states))[: round(drawn.train_fraction * len(states))]] = True
    return Dataset(
        readings / means.load_factor,
        states,
        means.states_percent,
        clean / means.load_factor,
        gauges,
        is_train,
        means.load_factor,
        drawn,
        seed,
        means.source,
        means.model_hash,
    )
