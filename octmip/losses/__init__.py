"""Losses: what a wrong prediction costs; the one part of a Problem that says what its leaves predict."""

from typing import Literal

from octmip.losses.class_costs import ClassCosts
from octmip.losses.errors_of_numbers import AbsoluteError, NumberLoss, SquaredError
from octmip.losses.loss import Loss

NumberLossName = Literal["squared", "absolute"]
NUMBER_LOSSES: dict[str, NumberLoss] = {loss.name: loss for loss in (SquaredError(), AbsoluteError())}
"""The losses of numbers by their names: as the command, the estimators and files name them."""

__all__ = ["NUMBER_LOSSES", "AbsoluteError", "ClassCosts", "Loss", "NumberLoss", "NumberLossName", "SquaredError"]
