"""Sampling of a library of states: loads, readings of each state, gauges."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from femlib.arrays import FloatArray
from femlib.dataset.samples import LOAD_FACTOR, Recipe
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

    Examples
    --------
    >>> Load("pull-up", factor=3.0).force is None
    True
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
    recipe : Recipe
        Readings of each state under each load, their white noise and the share for training; the study's if not given.
    gauges : sequence of str, optional
        Gauges to read; those outside every damage region if not given.
    seed : int
        Seed of noise and training share.

    Raises
    ------
    InputError
        If a number is out of its range or a load factor is 0: readings are divided by it, as the study does.

    Examples
    --------
    >>> sampling = Sampling(loads=(Load("1 g", 1.0), Load("3 g", 3.0)), gauges=("g01", "g05"), seed=7)
    >>> len(sampling.loads), sampling.recipe.samples_per_state
    (2, 100)
    """

    loads: Sequence[Load] = (Load(f"{LOAD_FACTOR:g} g", LOAD_FACTOR),)
    recipe: Recipe = field(default_factory=Recipe)
    gauges: Sequence[str] | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.loads, Sequence) or not all(isinstance(one, Load) for one in self.loads):
            raise InputError(f"sampling loads is {self.loads!r}; expected a list of Load; put it in a list")
        object.__setattr__(self, "loads", tuple(self.loads))
        names = [load.name for load in self.loads]
        if not names or len(set(names)) != len(names):
            raise InputError(
                f"sampling loads are named {names}; expected one load or more, each name once; rename them"
            )
        if any(load.factor == 0.0 for load in self.loads):
            raise InputError("a load has the factor 0 and readings are divided by it; expected another; correct it")
        if not is_whole(self.seed) or self.seed < 0:
            raise InputError(f"seed is {self.seed!r}; expected 0 or more; choose another")
