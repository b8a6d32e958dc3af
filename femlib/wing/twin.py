"""The wing as a twin: what a monitor or a diagnosis asks of any model, by shape and without knowing this package."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from femlib.arrays import FloatArray
from femlib.wing.effects import wing_effects
from femlib.wing.model import Wing, uav_wing


@dataclass(frozen=True, slots=True, eq=False)
class WingTwin:
    """A wing that answers with gauge strains.

    Attributes
    ----------
    wing : Wing
        The model.
    effects : mapping
        What a real wing may have that the model lacks, by name.
    """

    wing: Wing
    effects: Mapping[str, object] = field(default_factory=dict)

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges."""
        return self.wing.gauges.names

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the damage parameters."""
        return self.wing.parameters

    @property
    def is_linear_in_load(self) -> bool:
        """Whether strain is proportional to the load factor: it is."""
        return True

    @property
    def gauge_positions(self) -> FloatArray:
        """Places (n_gauges, 2) of the gauges, x aft of the spar and y outboard [m]."""
        return self.wing.gauges.position[:, :2]

    @property
    def outline(self) -> FloatArray:
        """Closed polygon (5, 2) of the planform in (x, y) [m]."""
        return self.wing.outline()

    def predict_states(self, states: FloatArray, load_factor: float) -> FloatArray:
        """Return the strains (n_states, n_gauges) of damage fractions (n_states, n_parameters)."""
        return self.wing.strains_microstrain(states, load_factor)

    def predict(self, state: Mapping[str, float], load_factor: float) -> FloatArray:
        """Return the strains (n_gauges,) in microstrain of a state of damage fractions, compressive positive."""
        return self.wing.strain_microstrain(state, load_factor)


def uav_twin() -> WingTwin:
    """Return the twin of the UAV wing with its 24 installed gauges and the effects that a real wing may have."""
    wing = uav_wing()
    return WingTwin(wing, wing_effects(wing))
