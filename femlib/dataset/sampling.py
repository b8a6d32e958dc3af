"""Sampling of a library of states: loads, readings of each state, noise, gauges, training share."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from femlib.arrays import FloatArray
from femlib.dataset.noise import Noise, WhiteNoise
from femlib.dataset.samples import LOAD_FACTOR
from femlib.errors import InputError, frozen_floats, is_number, is_whole


@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """A load case.

    Attributes
    ----------
    name : str
        Name, in the rows' column `load`.
    factor : float
        Load factor: 1 is steady level flight.
    force : FloatArray, optional
        Nodal forces and moments (n_dofs,) at load factor 1 [N, N m]; the model's own lift if not given.

    Raises
    ------
    InputError
        If the factor or a force is not a finite number.
    """

    name: str
    factor: float
    force: FloatArray | None = None

    def __post_init__(self) -> None:
        if not is_number(self.factor):
            raise InputError(
                f"load {self.name!r} has the factor {self.factor!r}; expected a finite number; 1 is steady level flight"
            )
        if self.force is not None:
            object.__setattr__(self, "force", frozen_floats(self.force, f"force of load {self.name!r}", (-1,)))


@dataclass(frozen=True, slots=True, eq=False)
class Sampling:
    """The draws of readings from each state of a library.

    Attributes
    ----------
    loads : sequence of Load
        Every state is read under every load. The study's load factor 3 if not given.
    samples_per_state : int
        Readings of each state under each load, one after the other.
    noise : sequence of Noise
        Errors that are added, at the load itself; () for none. The study's white noise of variance 1000 microstrain^2
        if not given.
    gauges : sequence of str, optional
        Gauges to read; those outside every damage region if not given.
    divide_by_load : bool
        Divide readings by the load factor, as the study does.
    train_fraction : float
        Probability that a row is for training.
    seed : int
        Seed of noise and training share.

    Raises
    ------
    InputError
        If a number is out of its range, or readings under a load factor of 0 are to be divided by it.
    """

    loads: Sequence[Load] = (Load(f"{LOAD_FACTOR:g} g", LOAD_FACTOR),)
    samples_per_state: int = 100
    noise: Sequence[Noise] = field(default_factory=lambda: (WhiteNoise(float(np.sqrt(1000.0))),))
    gauges: Sequence[str] | None = None
    divide_by_load: bool = True
    train_fraction: float = 0.7
    seed: int = 0

    def __post_init__(self) -> None:
        for name, kind in (("loads", Load), ("noise", Noise)):
            given = getattr(self, name)
            if not isinstance(given, Sequence) or not all(isinstance(one, kind) for one in given):
                raise InputError(f"sampling {name} is {given!r}; expected a list of {kind.__name__}; put it in a list")
            object.__setattr__(self, name, tuple(given))
        names = [load.name for load in self.loads]
        if not names or len(set(names)) != len(names):
            raise InputError(
                f"sampling loads are named {names}; expected one load or more, each name once; rename them"
            )
        if self.divide_by_load and any(load.factor == 0.0 for load in self.loads):
            raise InputError(
                "a load has the factor 0 and readings are divided by it; expected another factor; "
                "say divide_by_load=False to keep microstrain at the load"
            )
        self._check_numbers()

    def _check_numbers(self) -> None:
        if not is_whole(self.samples_per_state) or self.samples_per_state < 1:
            raise InputError(f"samples_per_state is {self.samples_per_state!r}; expected 1 or more; the study uses 100")
        if not is_number(self.train_fraction) or not 0.0 <= self.train_fraction <= 1.0:
            raise InputError(f"train_fraction is {self.train_fraction!r}; expected 0 to 1; the study uses 0.7")
        if not is_whole(self.seed) or self.seed < 0:
            raise InputError(f"seed is {self.seed!r}; expected 0 or more; choose another")

    def divisor(self, load: Load) -> float:
        """Return the divisor of the readings under a load."""
        return load.factor if self.divide_by_load else 1.0
