"""The map: which solver answers which pair of loss and split, by method. A new method is a line here.

A `Run` says how a problem is solved: functions that solve several alike hand it on as one.
"""

import importlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any, Literal, Protocol, cast

from octmip.errors import ProblemError, SolverError
from octmip.trees.answer.solution import Limits, ProgressCallback, Solution
from octmip.trees.methods.options import METHODS, NO_OPTIONS, OPTIONS, Options, values_of
from octmip.trees.nodes.tree import Node
from octmip.trees.question.losses import NUMBER_LOSSES
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import MAX_DEPTH

Method = Literal["auto", "search", "exact", "oct", "oct_h", "flow", "benders", "cart"]


@dataclass(frozen=True, slots=True)
class Run:
    """Method, limits, seed, threads, options and progress of a solve; see `octmip.solve`.

    Attributes
    ----------
    method
        name of the solver, or "auto".
    limits
        of each solve.
    seed
        of all random choices.
    n_jobs
        threads.
    options
        of the method's own solver.
    progress
        called now and then with the state of the solver.

    Raises
    ------
    ProblemError
        the options are of none of their classes.
    """

    method: Method = "auto"
    limits: Limits = field(default_factory=Limits)
    seed: int = 0
    n_jobs: int = 1
    options: Options = NO_OPTIONS
    progress: ProgressCallback | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.options, Options):
            kind, given = OPTIONS.get(self.method, Options).__name__, "..."
            if isinstance(self.options, dict):
                given = ", ".join(f"{name}={value!r}" for name, value in self.options.items())
            raise ProblemError(
                f"options is a {type(self.options).__name__}; expected one of the classes of options; write "
                f"options={kind}({given})"
            )


class Solver(Protocol):
    """The call that every solver answers."""

    def __call__(
        self,
        problem: Problem,
        *,
        limits: Limits,
        incumbent: Node | None,
        seed: int,
        n_jobs: int,
        progress: ProgressCallback | None,
        options: Any,
        **study: Any,
    ) -> Solution:
        """Return the best tree found within the limits and the bound proven for it."""


@dataclass(frozen=True, slots=True)
class Registration:
    """A method's solver: module and function, whether it proves (and so wants an incumbent first), whether by HiGHS."""

    module: str
    function: str
    proves: bool
    is_mixed_integer: bool = False
    alone_to_depth: int = 0
    """To this depth its own start finds the optimum early, and a search first would take as long as many a proof."""

    cannot: tuple[str, ...] = ()
    """Settings of a Problem that it does not know: asked for, they are refused in one sentence."""

    without: tuple[str, ...] = ("cluster",)
    """Options of its method's class (`octmip.trees.methods.options`) that it does not take."""

    def refusal(self, problem: Problem) -> str | None:
        """Return the first setting of a problem that the solver does not know, None where it knows all."""
        asked = {name: _setting(problem, name) for name in self.cannot}
        is_usual = [value is None or value is False or value == "constant" for value in asked.values()]
        return next((name for name, usual in zip(asked, is_usual, strict=True) if not usual), None)

    def load(self) -> Solver:
        """Return the solver, its module imported only now: HiGHS and scikit-learn are needed by some methods only.

        Raises
        ------
        SolverError
            the module, or a package that it needs, is not installed.
        """
        try:
            module = importlib.import_module(self.module)
        except ModuleNotFoundError as error:
            raise SolverError(
                f"solver {self.module} needs the module {error.name}, which is not installed; choose another method"
            ) from error
        return cast(Solver, getattr(module, self.function))


def _setting(problem: Problem, name: str) -> object:
    """Return a setting that a solver may not know."""
    return problem.samples.takes_missing if name == "takes_missing" else getattr(problem.shape, name)


PARTS = ("fixed_splits", "path_rules", "max_changes")
"""Parts of the tree that are asked for: the exact core knows them, and nobody else."""
CART = Registration("octmip.trees.methods.cart", "greedy_tree", proves=False, cannot=PARTS)
SEARCH = Registration("octmip.trees.methods.search", "local_search", proves=False, without=(), cannot=PARTS)
EXACT = Registration("octmip.trees.methods.exact", "branch_and_bound", proves=True, alone_to_depth=4, without=())
SHAPED = replace(EXACT, cannot=("sensor_budget",), without=("cluster", "proof", "every"))
"""The exact core where `Problem.is_shaped`."""
PARTED = replace(SHAPED, alone_to_depth=MAX_DEPTH)
"""The exact core where parts of the tree are asked for, which no search before it knows."""
SPARSE = replace(EXACT, alone_to_depth=MAX_DEPTH, without=("proof",))
"""The exact core for trees of any depth: a log has no line for the bounds that end them."""
TWO_FEATURE = Registration(
    "octmip.trees.methods.two_feature",
    "two_feature_branch_and_bound",
    proves=True,
    cannot=("max_splits", "monotone", *PARTS),
)
OCT = Registration(
    "octmip.trees.mip.oct",
    "solve_oct",
    proves=True,
    is_mixed_integer=True,
    cannot=("any_depth", "leaf_weight", "monotone", *PARTS),
    without=("cluster", "mu"),
)
OCT_H = Registration(
    "octmip.trees.mip.oct_h",
    "solve_oct_h",
    proves=True,
    is_mixed_integer=True,
    cannot=("leaf_weight", "monotone", *PARTS),
)
FLOW_OF_PLANES = Registration(
    "octmip.trees.mip.flow",
    "solve_flow",
    proves=True,
    is_mixed_integer=True,
    cannot=("any_depth", "leaf_weight", "monotone", *PARTS),
)
FLOW = replace(FLOW_OF_PLANES, without=("cluster", "mu"))
BENDERS = Registration(
    "octmip.trees.mip.benders.solver",
    "solve_benders",
    proves=True,
    cannot=("any_depth", "leaf_weight", "max_splits", "monotone", *PARTS),
)
NUMBERS = Registration(
    "octmip.trees.regression.exact",
    "exact_regression",
    proves=True,
    alone_to_depth=MAX_DEPTH,
    cannot=("any_depth", "takes_missing", "leaf_model", "max_splits", "monotone", *PARTS),
    without=("cluster", "every"),
)
NUMBERS_SEARCH = Registration(
    "octmip.trees.regression.search",
    "search_regression",
    proves=False,
    cannot=("takes_missing", "integer_normals", *PARTS),
    without=("cluster", "perturbations"),
)

REGISTRY: Mapping[tuple[str, str], Mapping[str, Registration]] = {
    ("classes", "axis"): {
        "cart": CART,
        "search": SEARCH,
        "exact": EXACT,
        "oct": OCT,
        "flow": FLOW,
        "benders": BENDERS,
    },
    ("classes", "hyperplane"): {
        "cart": CART,
        "search": SEARCH,
        "exact": TWO_FEATURE,
        "oct_h": OCT_H,
        "flow": FLOW_OF_PLANES,
    },
    **{(loss, "axis"): {"cart": CART, "search": NUMBERS_SEARCH, "exact": NUMBERS} for loss in NUMBER_LOSSES},
    **{(loss, "hyperplane"): {"cart": CART, "search": NUMBERS_SEARCH} for loss in NUMBER_LOSSES},
}
"""Which solver answers which pair of loss and split, by method. Losses of numbers share their solvers: a new one
enters this table by its line in `octmip.trees.question.losses.NUMBER_LOSSES`."""
UNKNOWN = {
    "any_depth": ("depth of None", ["give a depth, such as 3"]),
    "takes_missing": (
        "missing readings",
        ["fill missing readings, or let an estimator or the command encode them", "leave those rows out"],
    ),
}
"""Of settings that a method may not know: how a sentence calls one, and what helps beside another method."""

OF_CLASSES_ALONE: Mapping[str, str] = {
    "costs": "prices of taking one class for another",
    "numbers_are_classes": "a label of classes",
    "class_order": "an order of classes",
    "class_weight": "weights of classes",
}
"""What the command asks of classes alone, and what it is about: refused in one sentence with a loss of numbers."""


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of a problem of classes beside a solve: why of classes alone, and whether level by level.

    What goes through trees level by level knows nothing of `Problem.is_shaped`.
    """

    of_classes: str
    by_level: bool = False


ASKED: Mapping[str, Asked] = {
    "near_optimal": Asked("trees are counted by whole costs, and errors of numbers are none", by_level=True),
    "sensor_roles": Asked("what a sensor is worth is counted by whole costs, and errors of numbers are none", True),
    "leaves_on_fresh_rows": Asked("probabilities are those of classes"),
    "shared_budget": Asked("labels are classes"),
}
"""What is asked beside a solve, by name: refused in one sentence with what it does not know."""


def refuse_unknown(problem: Problem, asked: str) -> None:
    """Check that a problem asks for nothing that what is asked of it does not know.

    Raises
    ------
    ProblemError
        its loss is one of numbers, or the trees gone through level by level have no depth or a shape of their own.
    """
    shape = problem.shape
    row = ASKED[asked]
    if row.by_level and shape.any_depth:
        raise ProblemError(f"{asked} goes through trees level by level and depth is None; give a depth, such as 3")
    if row.by_level and (shape.is_shaped or shape.leaf_weight is not None):
        names = ("leaf_weight", "monotone", *PARTS, "max_splits")
        name = next(name for name in names if getattr(problem.shape, name) is not None)
        raise ProblemError(
            f"{asked} goes through trees level by level and knows nothing of {name}; leave {name} out, or ask solve, "
            "trace_frontier or choose_tree"
        )
    if problem.loss.predicts == "number":
        raise ProblemError(
            f"{asked} is for classes, as {row.of_classes}; got the loss {problem.loss.spelling!r}; sort the numbers "
            "into classes, or ask solve, trace_frontier or choose_tree, which answer every loss"
        )


def options_by_method() -> dict[str, dict[str, dict[str, Any]]]:
    """Return the options that each method takes for some loss and split: default, values, help, as JSON holds them."""
    found: dict[str, dict[str, dict[str, Any]]] = {method: {} for method in OPTIONS}
    for solvers in REGISTRY.values():
        for method, solver in solvers.items():
            for one in fields(OPTIONS[method]):
                if one.name not in solver.without:
                    said = {"default": one.default, "values": values_of(one).words, "help": one.metadata["help"]}
                    found[method][one.name] = said
    return found


def taken(problem: Problem, method: str) -> tuple[str, ...]:
    """Return the options that a method takes for a loss and split; none where it does not answer them."""
    solver = solvers_of(problem).get(method)
    return () if solver is None else tuple(name for name in OPTIONS[method].names() if name not in solver.without)


def read_options(problem: Problem, method: str, words: Mapping[str, str]) -> Options:
    """Return the options that words of the command give by name; the rest as in `Options.of_kind`.

    Raises
    ------
    ProblemError
        as `Options.of_kind`, or a word is none of the values of its option.
    """
    return OPTIONS[method].read(words, *taker(problem, method))


def taker(problem: Problem, method: str) -> tuple[str, tuple[str, ...]]:
    """Return a method in words, with what of the problem keeps options from it, and the options it does not take."""
    solver = solvers_of(problem)[method]
    shaped = " of a problem with max_splits, monotone or parts that are asked for"
    kept = {SHAPED: shaped, PARTED: shaped, SPARSE: " of a problem without a depth"}.get(solver, "")
    return f"method {method!r}{kept}", solver.without


def solvers_of(problem: Problem) -> Mapping[str, Registration]:
    """Return the solvers that answer a problem's loss, split and shape, by method."""
    shape = problem.shape
    known = REGISTRY[problem.loss.name, shape.split]
    if known.get("exact") is not EXACT or not (shape.is_shaped or shape.any_depth):
        return known
    shaped = PARTED if shape.has_parts else SHAPED
    return {**known, "exact": shaped if shape.is_shaped else SPARSE}


def chosen_method(problem: Problem, method: str) -> str:
    """Return the name of the solver that a method means for a problem.

    Raises
    ------
    ProblemError
        there is no such method, or none for this loss and split.
    """
    known = solvers_of(problem)
    if method not in METHODS:
        raise ProblemError(f"method is {method!r}; expected one of {', '.join(METHODS)}")
    if method not in ("auto", *known):
        raise ProblemError(
            f"method {method!r} finds no {problem.shape.split} trees for the loss {problem.loss.name!r}; expected one "
            f"of {', '.join(('auto', *known))}"
        )
    wanted = ("exact", "search") if problem.shape.split == "axis" and problem.is_provable else ("search",)
    able = [name for name, solver in known.items() if solver.refusal(problem) is None]
    chosen = method if method != "auto" else next((name for name in wanted if name in able), wanted[0])
    if (setting := known[chosen].refusal(problem)) is not None:
        others = [f"use method {' or '.join(map(repr, able))}"] if able else []
        named, cures = UNKNOWN.get(setting, (setting, [f"leave {setting} out"]))
        raise ProblemError(
            f"method {chosen!r} with the loss {problem.loss.name!r} does not know the problem's {named}; "
            + " or ".join([*others, *cures])
        )
    return chosen
