"""Effects of other people, completed: what an effect does not say has a default, what it must say is asked for."""

from collections.abc import Mapping
from typing import Any

from octmip.errors import TwinError
from octmip.twin import Effect, Twin

NEEDED = ("name", "unit", "prior_sd", "signature")
"""What every effect says itself."""
WHOLE = ("",)


def _anywhere(twin: Twin) -> tuple[str, ...]:
    return WHOLE


DEFAULTS: Mapping[str, Any] = {
    "parameter": "its size",
    "prior_mean": 0.0,
    "prior_source": "said by the author of the effect",
    "is_one_sided": False,
    "separated_by": "a measurement of the quantity itself shows it",
    "load_power": None,
    "places": _anywhere,
}
"""What an effect is taken to say where it does not: it may go either way and acts on the whole."""


class Completed:
    """An effect with defaults for what it does not say.

    Attributes
    ----------
    effect
        as its author wrote it.
    """

    def __init__(self, effect: Any) -> None:
        self.effect = effect

    def __getattr__(self, name: str) -> Any:
        if name != "effect" and name in DEFAULTS and not hasattr(self.effect, name):
            return DEFAULTS[name]
        return getattr(self.effect, name)


def completed(effects: Mapping[str, Any]) -> dict[str, Effect]:
    """Return effects, those that lack something optional with its default.

    Raises
    ------
    TwinError
        an effect lacks its name, its unit, its prior sd or its signature, or two have one name.
    """
    found: dict[str, Effect] = {}
    for key, effect in effects.items():
        missing = [name for name in NEEDED if not hasattr(effect, name)]
        if missing:
            raise TwinError(
                f"effect {key!r} ({type(effect).__name__}) has no {missing[0]}; expected {', '.join(NEEDED)}, or a "
                "SimpleEffect(name, unit, prior_sd, apply), which needs no more; add it"
            )
        found[key] = effect if all(hasattr(effect, name) for name in DEFAULTS) else Completed(effect)
    names = [effect.name for effect in found.values()]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise TwinError(f"two effects are called {twice[0]!r}; expected a name each; rename one")
    return found
