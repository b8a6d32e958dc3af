"""Losses: what a wrong prediction costs; the one part of a Problem that says what its leaves predict."""

from collections.abc import Mapping
from typing import Any, Literal

from octmip.trees.losses.class_costs import ClassCosts
from octmip.trees.losses.errors_of_numbers import AbsoluteError, NumberLoss, SquaredError
from octmip.trees.losses.loss import Loss

NumberLossName = Literal["squared", "absolute"]
NUMBER_LOSSES: dict[str, NumberLoss] = {loss.name: loss for loss in (SquaredError(), AbsoluteError())}
"""The losses of numbers by their names: as the command, the estimators and files name them."""


def loss_of(content: Mapping[str, Any]) -> Loss:
    """Return the loss that `Loss.to_json` has described."""
    return ClassCosts(content["costs"]) if content["name"] == ClassCosts.name else NUMBER_LOSSES[content["name"]]


__all__ = [
    "NUMBER_LOSSES",
    "AbsoluteError",
    "ClassCosts",
    "Loss",
    "NumberLoss",
    "NumberLossName",
    "SquaredError",
    "loss_of",
]
