"""Plan of a stream: a model, a library of states and a sampling that fit each other."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np

from femlib.arrays import FloatArray, IntArray
from femlib.dataset.samples import GaugePlaces
from femlib.dataset.sampling import Sampling
from femlib.dataset.states import StateLibrary
from femlib.errors import InputError

UNITS = {
    "gauges": "microstrain, compressive positive, divided by load_factor",
    "parameters": "fraction of stiffness lost",
    "load_factor": "multiples of steady level flight",
    "noise_variance": "microstrain^2 at the load factor, before any division",
}
StrainMap = Callable[[FloatArray], FloatArray]
"""From states (n_states, n_parameters) to strains (n_states, n_gauges) [microstrain] under one load."""


@runtime_checkable
class SampledModel(Protocol):
    """A model that a stream can sample: a wing, or a reduced wing."""

    @property
    def gauges(self) -> GaugePlaces | tuple[str, ...]:
        """The gauges, or their names where the model does not know which lie outside the damage regions."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters: the columns of a state array."""

    @property
    def model_hash(self) -> str:
        """Fingerprint of the model."""

    def strains_microstrain(self, states: FloatArray, load_factor: float) -> FloatArray:
        """Return strains (n_states, n_gauges) of damage fractions (n_states, n_parameters), compressive positive."""


@runtime_checkable
class MapsStrains(Protocol):
    """A model that can prepare a load; the map that it returns is called for many states, in other processes too."""

    def strain_map(self, load_factor: float, lift: FloatArray | None = None) -> StrainMap:
        """Return the map from states to strains under a load."""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A model, a library and a sampling that fit each other.

    Attributes
    ----------
    model : SampledModel
        The model.
    library : StateLibrary
        The states.
    sampling : Sampling
        What is drawn of each.
    columns : IntArray
        Column of each library parameter among the model's (n_library_parameters,).
    kept : IntArray
        Place of each gauge of the dataset among the model's (n_gauges,).
    """

    model: SampledModel
    library: StateLibrary
    sampling: Sampling
    columns: IntArray
    kept: IntArray

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the dataset's gauges."""
        names = _gauge_names(self.model)
        return tuple(names[k] for k in self.kept)

    def states(self, first: int, stop: int) -> FloatArray:
        """Return states of the library in the model's columns; parameters that it does not name are undamaged."""
        wide = np.zeros((stop - first, len(self.model.parameters)))
        wide[:, self.columns] = self.library.between(first, stop)
        return wide


def fitted(model: SampledModel, library: StateLibrary, sampling: Sampling) -> Plan:
    """Return the plan of a model, a library and a sampling.

    Raises
    ------
    InputError
        If they do not fit each other.
    """
    if not isinstance(model, SampledModel):
        raise InputError(
            f"model is a {type(model).__name__}; expected one with gauges, parameters, model_hash and "
            "strains_microstrain, as a Wing has; of a twin, pass its wing"
        )
    if not isinstance(library, StateLibrary):
        raise InputError(
            f"library is a {type(library).__name__}; expected a StateLibrary; listed_states makes one of rows"
        )
    unknown = [name for name in library.parameters if name not in model.parameters]
    if unknown:
        raise InputError(
            f"the library has the parameters {unknown}; expected some of the model's, {model.parameters}; name those"
        )
    if not len(library):
        raise InputError("the library has no states; expected at least one; give grid_states a level or add a library")
    if any(load.force is not None for load in sampling.loads) and not isinstance(model, MapsStrains):
        raise InputError(f"a load has forces, which a {type(model).__name__} does not take; expected a full model")
    columns = np.array([list(model.parameters).index(name) for name in library.parameters])
    return Plan(model, library, sampling, columns, _kept_gauges(model, sampling))


def _gauge_names(model: SampledModel) -> tuple[str, ...]:
    return model.gauges if isinstance(model.gauges, tuple) else model.gauges.names


def _kept_gauges(model: SampledModel, sampling: Sampling) -> IntArray:
    names = list(_gauge_names(model))
    if sampling.gauges is None:
        if isinstance(model.gauges, tuple):
            raise InputError(
                f"sampling names no gauges, and a {type(model).__name__} does not know which of its {len(names)} lie "
                "outside the damage regions; expected their names; take the usable ones of the full wing"
            )
        kept = np.flatnonzero(model.gauges.is_usable)
    else:
        unknown = [name for name in sampling.gauges if name not in names]
        if unknown or len(set(sampling.gauges)) != len(sampling.gauges):
            raise InputError(
                f"sampling names the gauges {unknown or sorted(sampling.gauges)}; expected each once, among "
                f"{names[0]} to {names[-1]}; correct the names"
            )
        kept = np.array([names.index(name) for name in sampling.gauges], dtype=np.int64)
    if not len(kept):
        raise InputError(f"none of {len(names)} gauges is left; expected at least one outside the regions; name some")
    return kept


def described(plan: Plan) -> dict[str, Any]:
    """Return the entries of the side file: everything that the rows lack."""
    sampling = plan.sampling
    return {
        "seed": sampling.seed,
        "parameters": list(plan.library.parameters),
        "gauges": list(plan.gauges),
        "n_states": len(plan.library),
        "states": [part.describe() for part in plan.library.parts],
        "loads": [
            {"name": one.name, "factor": one.factor, "has_force": one.force is not None} for one in sampling.loads
        ],
        "recipe": asdict(sampling.recipe),
        "model_hash": plan.model.model_hash,
        "units": UNITS,
    }
