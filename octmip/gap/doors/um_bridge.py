"""A model behind UM-Bridge as a twin, and any twin as a server of UM-Bridge.

UM-Bridge (Seelinger et al. (2023), J. Open Source Software 8) asks models over HTTP: a list of vectors in, a list of
vectors out. Here the vectors in are one of all parameters and states and one of all loads, the vector out is one of all
readings, each in the order of the card. UM-Bridge knows no names, so the card must be at hand on this side.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from octmip.errors import DataError, TwinError, needed_by
from octmip.gap.doors.card import Card, read_card
from octmip.gap.doors.function import FunctionTwin

NAME = "twin"
"""Name of a served model."""


def um_bridge_twin(address: str, card: str | Path | Card) -> FunctionTwin:
    """Return the twin of a model at an address such as http://localhost:4242/wing.

    Raises
    ------
    MissingExtraError
        the package umbridge is missing.
    DataError
        no model of that name there, or its vectors are not as long as the card says.
    """
    with needed_by("a twin behind UM-Bridge"):
        import umbridge
    known = card if isinstance(card, Card) else read_card(card)
    server, _, name = address.rpartition("/")
    if not urlsplit(server).netloc:
        raise DataError(f"um-bridge address is {address!r}; expected http://HOST:PORT/NAME; name the model")
    try:
        model = umbridge.HTTPModel(server, name)
        asked, answered = model.get_input_sizes({}), model.get_output_sizes({})
    except Exception as error:
        raise DataError(
            f"um-bridge {address}: {error}; expected a model that answers there; start its server"
        ) from error
    wanted = [len(known.parameters) + len(known.states), len(known.loads)], [len(known.readings)]
    if (list(asked), list(answered)) != wanted:
        raise DataError(
            f"um-bridge {address} takes vectors of {list(asked)} numbers and gives {list(answered)}; its card says "
            f"{wanted[0]} (parameters with states, loads) and {wanted[1]} (readings); correct the card"
        )

    def function(parameters: Mapping[str, float], loads: Mapping[str, float]) -> Any:
        try:
            return model([list(parameters.values()), list(loads.values())])[0]
        except Exception as error:
            raise TwinError(
                f"um-bridge {address}: {error}; expected readings; look at the server's own output"
            ) from error

    return FunctionTwin(function, known)


def served(twin: FunctionTwin, name: str = NAME) -> Any:
    """Return a twin as a model that `umbridge.serve_models` serves.

    Raises
    ------
    MissingExtraError
        the package umbridge is missing.
    """
    with needed_by("a server of UM-Bridge"):
        import umbridge
    card = twin.card
    names = [*card.parameters, *card.states]

    class Served(umbridge.Model):  # type: ignore[misc]
        """The twin, by the protocol."""

        def __init__(self) -> None:
            super().__init__(name)

        def get_input_sizes(self, config: Mapping[str, Any]) -> list[int]:
            """Return the lengths of the vectors that are asked with."""
            return [len(names), len(card.loads)]

        def get_output_sizes(self, config: Mapping[str, Any]) -> list[int]:
            """Return the length of the answer."""
            return [len(card.readings)]

        def __call__(self, asked: list[list[float]], config: Mapping[str, Any]) -> list[list[float]]:
            answer = twin.function(
                dict(zip(names, asked[0], strict=True)), dict(zip(card.loads, asked[1], strict=True))
            )
            values = [answer[name] for name in card.readings] if isinstance(answer, Mapping) else answer
            return [[float(value) for value in values]]

        def supports_evaluate(self) -> bool:
            """Return that it can be asked."""
            return True

    return Served()


def serve(twin: FunctionTwin, port: int = 4242, name: str = NAME) -> None:
    """Serve a twin over HTTP until it is interrupted.

    Raises
    ------
    MissingExtraError
        the package umbridge is missing.
    """
    model = served(twin, name)
    import umbridge

    umbridge.serve_models([model], port)
