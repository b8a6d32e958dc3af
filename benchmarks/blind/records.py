"""Records that a scorer reads back from files: the diagnosis of a case, and its opened key."""

from typing import NotRequired, TypedDict

from benchmarks.blind.sealing import Facts
from benchmarks.blind.truths import Extra


class ParameterRecord(TypedDict):
    """One effect of a cause, its place, and its size with a 90 % interval."""

    effect: str
    place: str
    size: float
    low: float
    high: float


class CauseRecord(TypedDict):
    """A cause as the diagnosis writes it: names of its effects, probability, sizes."""

    effects: list[str]
    probability: float
    parameters: list[ParameterRecord]


class AugmentedRecord(TypedDict):
    """The parts of an augmented twin: additions (effect, place, size), calibration at a load, end of the campaign."""

    additions: list[tuple[str, str, float]]
    calibration: list[float]
    load: float
    end: float


class Found(TypedDict):
    """The diagnosis of one case, with the commissioning run (`calibrated`) or without.

    `names` holds for each cause of `which` the groups of names that cannot be told apart, `credible` the same for the
    causes of the 95 % set. `ranking`, `residual` and `lasso` are the baselines'.
    """

    name: str
    calibrated: bool
    seconds: float
    which: list[CauseRecord]
    credible: list[list[list[str]]]
    names: list[list[list[str]]]
    unknown_probability: float
    inclusion: dict[str, float]
    findings: list[str]
    stuck: list[str]
    significant: list[str]
    correction: list[float]
    ranking: str
    residual: list[float]
    lasso: str | None
    augmented: AugmentedRecord


class TruthRecord(TypedDict):
    """A truth as it was sealed."""

    name: str
    size: float
    place: str
    extra: Extra


class CaseRecord(TypedDict):
    """A case as it was sealed."""

    name: str
    stratum: str
    truths: list[TruthRecord]
    states: list[list[float]]
    is_known: bool
    loads: list[float]
    noise: str
    family: str


class Key(Facts):
    """The opened key of a case; `tree_means` (n_states, n_gauges) where its retrained tree is scored."""

    case: CaseRecord
    salt: str
    tree_means: NotRequired[list[list[float]]]


Pair = tuple[Found, Key]
"""A diagnosis and the opened key of its case."""
