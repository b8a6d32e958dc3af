"""Losses: what a wrong prediction costs; the one part of a Problem that says what its leaves predict."""

from collections.abc import Mapping
from typing import Any

from octmip.errors import ProblemError
from octmip.trees.question.losses.class_costs import SAMPLE_COSTS, ClassCosts
from octmip.trees.question.losses.errors_of_numbers import AbsoluteError, NumberLoss, SquaredError
from octmip.trees.question.losses.loss import Loss
from octmip.trees.question.losses.quantile_error import QuantileError

NUMBER_LOSSES: dict[str, type[NumberLoss]] = {loss.name: loss for loss in (SquaredError, AbsoluteError, QuantileError)}
"""The losses of numbers by their names. A new one is an entry here."""
SPELLINGS = tuple(spelling for loss in NUMBER_LOSSES.values() for spelling in loss.spellings)
"""Losses of numbers as the command and the estimators name them, with a number for each parameter."""


def number_loss(given: str | NumberLoss) -> NumberLoss:
    """Return the loss that a user names: "squared", "absolute", or "quantile:0.9", its parameter behind the colon.

    Raises
    ------
    ProblemError
        there is no such loss, or none with that parameter.
    """
    if isinstance(given, NumberLoss):
        return given
    name, _, values = given.partition(":")
    if name not in NUMBER_LOSSES:
        raise ProblemError(f"loss is {given!r}; expected a loss of numbers, such as {', '.join(SPELLINGS)}")
    return NUMBER_LOSSES[name].of_spelling(values)


def loss_of(content: Mapping[str, Any]) -> Loss:
    """Return the loss that `Loss.to_json` has described."""
    name, parameters = content["name"], {key: value for key, value in content.items() if key != "name"}
    if name in (ClassCosts.name, SAMPLE_COSTS):
        return ClassCosts(**parameters, per_sample=name == SAMPLE_COSTS)
    return NUMBER_LOSSES[name](**parameters)


__all__ = [
    "NUMBER_LOSSES",
    "SAMPLE_COSTS",
    "SPELLINGS",
    "AbsoluteError",
    "ClassCosts",
    "Loss",
    "NumberLoss",
    "QuantileError",
    "SquaredError",
    "loss_of",
    "number_loss",
]
