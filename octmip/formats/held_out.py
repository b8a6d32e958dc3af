"""HeldOut: what a tree file says of samples that its tree was not trained on."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from octmip.errors import TreeError
from octmip.input.messages import several
from octmip.trees.question.losses import Loss


@dataclass(frozen=True, slots=True)
class HeldOut:
    """What the tree loses on samples that it was not trained on.

    Attributes
    ----------
    share, seed
        the rows of the training's table that were held out (`octmip.trees.tradeoff.held_out`); the share is None where
        the samples are another table's.
    n_samples, measures, cost
        their number, what predictions are judged by (`Loss.measures`), and their weighted cost.
    """

    share: float | None
    seed: int
    n_samples: int
    measures: Mapping[str, float]
    cost: float


def held_out_of(content: dict[str, Any] | None, loss: Loss) -> HeldOut | None:
    """Return what the entry of a tree file holds whose kinds were checked.

    Raises
    ------
    TreeError
        the loss is judged by other measures.
    """
    if content is None:
        return None
    if set(content["measures"]) != set(loss.measured):
        raise TreeError(
            f"held_out.measures has the entries {several(content['measures'])}; expected {several(loss.measured)}, by "
            f"which the loss {loss.name!r} is judged"
        )
    return HeldOut(**content)
