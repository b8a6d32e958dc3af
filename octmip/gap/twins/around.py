"""What a twin made of another one passes on unchanged."""

from collections.abc import Mapping

from octmip.twin import Effect, Twin, loads_of, state_limits_of, state_parameters


class TwinAround:
    """A twin around another one, with its gauges, states, loads and effects.

    Attributes
    ----------
    twin
        the other one.
    """

    __slots__ = ()
    twin: Twin

    @property
    def gauges(self) -> tuple[str, ...]:
        """Names of the gauges."""
        return self.twin.gauges

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the state parameters."""
        return state_parameters(self.twin)

    @property
    def state_limits(self) -> dict[str, float]:
        """Up to which value each state parameter is looked for."""
        return dict(zip(self.parameters, state_limits_of(self.twin), strict=True))

    @property
    def loads(self) -> tuple[str, ...]:
        """Names of the loads and settings."""
        return loads_of(self.twin)

    @property
    def effects(self) -> Mapping[str, Effect]:
        """The twin's own effects."""
        return self.twin.effects
