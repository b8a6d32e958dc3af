"""The map: which solver answers which pair of loss and split, by method, and who cannot answer what may be asked for.

A new method is a line of `REGISTRY`; what it cannot answer are its name in lines of `CAPABILITIES`, of which every
refusal is made. There "levels" are calls that go through trees level by level, "numbers" all losses of numbers.

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


_FORMS = ("oct", "oct_h", "flow", "flow of planes", "benders")
_LINES = ("lines", "lines of depth 3")
_NO_PARTS = ("cart", "search", "search of numbers", *_LINES, "exact of numbers", *_FORMS, "levels")


@dataclass(frozen=True, slots=True)
class Capability:
    """What may be asked for.

    Attributes
    ----------
    kind
        a setting of a Problem, an option of a method, a word of the command, or a call beside a solve.
    lacking
        who cannot answer it.
    words
        what a sentence calls it, "" its name; of what numbers lack: what it is about.
    cures
        what helps beside another method.
    """

    kind: Literal["setting", "option", "word", "call"]
    lacking: tuple[str, ...]
    words: str = ""
    cures: tuple[str, ...] = ()


CAPABILITIES: Mapping[str, Capability] = {
    "any_depth": Capability(
        "setting",
        ("oct", "flow", "flow of planes", "benders", "exact of numbers", "levels"),
        "depth of None",
        ("give a depth, such as 3",),
    ),
    "leaf_weight": Capability("setting", (*_FORMS, "levels")),
    "takes_missing": Capability(
        "setting",
        ("exact of numbers", "search of numbers"),
        "missing readings",
        ("fill missing readings, or let an estimator or the command encode them", "leave those rows out"),
    ),
    "leaf_model": Capability("setting", ("exact of numbers",)),
    "sensor_budget": Capability("setting", ("exact of shapes", "lines of depth 3")),
    "max_splits": Capability("setting", (*_LINES, "benders", "exact of numbers", "levels")),
    "monotone": Capability("setting", (*_LINES, "exact of numbers", *_FORMS, "levels")),
    "integer_normals": Capability("setting", ("search of numbers", "lines of depth 3")),
    "fixed_splits": Capability("setting", _NO_PARTS),
    "path_rules": Capability("setting", _NO_PARTS),
    "max_changes": Capability("setting", _NO_PARTS),
    "cluster": Capability(
        "option", ("exact of shapes", *(who for who in _NO_PARTS if who not in ("search", "levels")))
    ),
    "proof": Capability("option", ("exact of shapes", "exact of any depth", "lines of depth 3")),
    "every": Capability("option", ("exact of shapes", "exact of numbers", "lines of depth 3")),
    "mu": Capability("option", ("oct", "flow")),
    "perturbations": Capability("option", ("search of numbers",)),
    "costs": Capability("word", ("numbers",), "prices of taking one class for another"),
    "numbers_are_classes": Capability("word", ("numbers",), "a label of classes"),
    "class_order": Capability("word", ("numbers",), "an order of classes"),
    "class_weight": Capability("word", ("numbers",), "weights of classes"),
    "near_optimal": Capability(
        "call", ("numbers",), "trees are counted by whole costs, and errors of numbers are none"
    ),
    "sensor_roles": Capability(
        "call", ("numbers",), "what a sensor is worth is counted by whole costs, and errors of numbers are none"
    ),
    "leaves_on_fresh_rows": Capability("call", ("numbers",), "probabilities are those of classes"),
    "shared_budget": Capability("call", ("numbers",), "labels are classes"),
}
"""Where a problem asks for several settings, the first that a solver lacks is named."""
BY_LEVEL = ("near_optimal", "sensor_roles")
"""Calls that go through trees level by level."""


def lacked(who: str, kind: str) -> tuple[str, ...]:
    """Return the capabilities of a kind that a solver lacks, by name."""
    return tuple(name for name, row in CAPABILITIES.items() if row.kind == kind and who in row.lacking)


def first_lacked(problem: Problem, who: str) -> str | None:
    """Return the first setting that a problem asks for and a solver does not know, None where it knows all."""
    return next((name for name in lacked(who, "setting") if _is_asked(problem, name)), None)


def _is_asked(problem: Problem, setting: str) -> bool:
    if setting == "takes_missing":
        return problem.samples.takes_missing
    value = getattr(problem.shape, "limited_splits" if setting == "max_splits" else setting)
    return value is not None and value is not False and value != "constant"  # 0 is a limit like any other


def words_and_cures(setting: str) -> tuple[str, str]:
    """Return what a sentence calls a setting, and what helps."""
    row = CAPABILITIES[setting]
    return row.words or setting, " or ".join(row.cures or (f"leave {setting} out",))


@dataclass(frozen=True, slots=True)
class Registration:
    """A method's solver: module and function, whether it proves (and so wants an incumbent first), whether by HiGHS."""

    name: str
    """In `CAPABILITIES`."""
    module: str
    function: str
    proves: bool
    is_mixed_integer: bool = False
    alone_to_depth: int = 0
    """To this depth its own start finds the optimum early, and a search first would take as long as many a proof."""

    @property
    def cannot(self) -> tuple[str, ...]:
        """Settings of a Problem that it does not know: asked for, they are refused in one sentence."""
        return lacked(self.name, "setting")

    @property
    def without(self) -> tuple[str, ...]:
        """Options of its method's class (`octmip.trees.methods.options`) that it does not take."""
        return lacked(self.name, "option")

    def refusal(self, problem: Problem) -> str | None:
        """Return the first setting of a problem that the solver does not know, None where it knows all."""
        return first_lacked(problem, self.name)

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


CART = Registration("cart", "octmip.trees.methods.cart", "greedy_tree", proves=False)
SEARCH = Registration("search", "octmip.trees.methods.search", "local_search", proves=False)
EXACT = Registration("exact", "octmip.trees.methods.exact", "branch_and_bound", proves=True, alone_to_depth=4)
SHAPED = replace(EXACT, name="exact of shapes")
"""The exact core where the shape `is_shaped`."""
PARTED = replace(SHAPED, alone_to_depth=MAX_DEPTH)
"""The exact core where parts of the tree are asked for, which no search before it knows."""
SPARSE = replace(EXACT, name="exact of any depth", alone_to_depth=MAX_DEPTH)
"""The exact core for trees of any depth: a log has no line for the bounds that end them."""
TWO_FEATURE = Registration("lines", "octmip.trees.methods.two_feature", "two_feature_branch_and_bound", proves=True)
DEEP_LINES = replace(TWO_FEATURE, name="lines of depth 3")
"""The same core at depth 3, which shares no sensors among its subtrees and has no log."""
OCT = Registration("oct", "octmip.trees.mip.oct", "solve_oct", proves=True, is_mixed_integer=True)
OCT_H = Registration("oct_h", "octmip.trees.mip.oct_h", "solve_oct_h", proves=True, is_mixed_integer=True)
FLOW = Registration("flow", "octmip.trees.mip.flow", "solve_flow", proves=True, is_mixed_integer=True)
FLOW_OF_PLANES = replace(FLOW, name="flow of planes")
BENDERS = Registration("benders", "octmip.trees.mip.benders.solver", "solve_benders", proves=True)
NUMBERS = Registration(
    "exact of numbers", "octmip.trees.regression.exact", "exact_regression", proves=True, alone_to_depth=MAX_DEPTH
)
NUMBERS_SEARCH = Registration("search of numbers", "octmip.trees.regression.search", "search_regression", proves=False)

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


def pauses(problem: Problem, method: str) -> bool:
    """Whether a method proves by an exact core that shows its bound, and a search knows all that is asked for."""
    solvers = solvers_of(problem)
    return (
        solvers[method] in (EXACT, SHAPED, NUMBERS, TWO_FEATURE, DEEP_LINES)
        and solvers["search"].refusal(problem) is None
    )


def refuse_unknown(problem: Problem, call: str) -> None:
    """Check that a problem asks for nothing that a call beside a solve does not know.

    Raises
    ------
    ProblemError
        its loss is one of numbers, or the trees gone through level by level have no depth or a shape of their own.
    """
    setting = first_lacked(problem, "levels") if call in BY_LEVEL else None
    if setting is not None:
        words, cures = words_and_cures(setting)
        raise ProblemError(
            f"{call} goes through trees level by level and does not know the problem's {words}; {cures}, or ask solve, "
            "trace_frontier or choose_tree"
        )
    row = CAPABILITIES[call]
    if problem.loss.predicts == "number" and "numbers" in row.lacking:
        raise ProblemError(
            f"{call} is for classes, as {row.words}; got the loss {problem.loss.spelling!r}; sort the numbers into "
            "classes, or ask solve, trace_frontier or choose_tree, which answer every loss"
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


def settings_unknown_to() -> dict[str, list[str]]:
    """Return the settings of a Problem that each solver does not know, of solvers that lack some, as doctor prints."""
    solvers = [*(solver for row in REGISTRY.values() for solver in row.values()), SHAPED, DEEP_LINES]
    return {solver.name: list(solver.cannot) for solver in solvers if solver.cannot}


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
    if known.get("exact") is TWO_FEATURE and shape.depth == 3:
        return {**known, "exact": DEEP_LINES}
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
        named, cures = words_and_cures(setting)
        raise ProblemError(
            f"method {chosen!r} with the loss {problem.loss.name!r} does not know the problem's {named}; "
            + " or ".join([*others, cures])
        )
    return chosen
