"""Options: what a method takes beside problem, limits, incumbent, seed and threads.

Each option stands once, as a field of its class: name, type, default, the values that it may have, and a line of help.
Python checks by it, and the command reads its words and prints its help from it. Settings that only a study of the
solvers changes are no options: they are further arguments of the solver's own function.
"""

import ast
import contextlib
import math
import numbers
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import Field, dataclass, field, fields, replace
from pathlib import Path
from typing import Any, Self, TypeVar

from octmip.errors import ProblemError
from octmip.trees.methods.cluster import Cluster, open_cluster

SET_HERE = frozenset(
    {"time_limit", "mip_abs_gap", "mip_rel_gap", "mip_max_nodes", "mip_feasibility_tolerance", "random_seed", "threads"}
    | {"primal_feasibility_tolerance", "dual_feasibility_tolerance", "parallel", "output_flag", "log_file"}
    | {"log_to_console", "objective_bound", "objective_target"}
)
"""Options of HiGHS that limits, seed, threads and log say, or that its bound is believed by."""
MODEL_FILES = (".mps", ".lp")
"""Endings of the files in which a mixed-integer model can be written."""
T = TypeVar("T", bound="Options")


class Opened:
    """A checkpoint that is more than the name of a file: a `Study`, or the entry of one solve."""

    __slots__ = ()


@dataclass(frozen=True, slots=True)
class Study(Opened):
    """A checkpoint file of many solves: each is made once, and what a limit ended stays as it is.

    Attributes
    ----------
    path
        of the file.

    Examples
    --------
    >>> Options(checkpoint=Study("study.kept")).checkpoint.path
    'study.kept'
    """

    path: str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Values:
    """The values that an option may have.

    Attributes
    ----------
    words
        say what they are, after "expected".
    hold
        whether a value is one of them.
    read
        makes one of a word of the command; it may raise a ValueError.
    """

    words: str
    hold: Callable[[Any], bool]
    read: Callable[[str], Any] = str


def _whole(least: int) -> Values:
    return Values(
        f"a whole number, {least} or more",
        lambda value: isinstance(value, numbers.Integral) and not isinstance(value, bool) and int(value) >= least,
        int,
    )


def _is_path(value: object) -> bool:
    return isinstance(value, str | os.PathLike)


FILE = Values("the name of a file", _is_path)
CHECKPOINT = Values("the name of a file, or a Study of one", lambda value: _is_path(value) or isinstance(value, Opened))
MODEL_FILE = Values(
    f"the name of a file that ends with {' or '.join(MODEL_FILES)}",
    lambda value: _is_path(value) and Path(value).suffix in MODEL_FILES,
)
SECONDS = Values(
    "a finite number of seconds, 0 or more",
    lambda value: isinstance(value, numbers.Real) and 0 <= float(value) < math.inf,
    float,
)
POSITIVE = Values(
    "a finite number above 0", lambda value: isinstance(value, numbers.Real) and 0 < float(value) < math.inf, float
)
ANYONE = Values("'local', the address of a Dask scheduler, a Dask client or an open Cluster", lambda value: True)


def _of_highs(word: str) -> dict[str, bool | int | float | str]:
    """Return the options of HiGHS in a word, each value as Python would read it."""
    found: dict[str, bool | int | float | str] = {}
    for part in word.split(","):
        name, has_value, value = part.partition("=")
        if not has_value:
            raise ValueError
        try:
            read = ast.literal_eval({"true": "True", "false": "False"}.get(value.lower(), value))
        except (ValueError, SyntaxError):
            read = value
        found[name.strip()] = read if isinstance(read, bool | int | float) else value
    return found


def _are_of_highs(value: object) -> bool:
    return isinstance(value, Mapping) and all(
        isinstance(name, str) and name not in SET_HERE and isinstance(one, bool | int | float | str)
        for name, one in value.items()
    )


STARTS_OF_HIGHS = Values("cart or search", lambda value: value in ("cart", "search"))
OF_HIGHS = Values(
    f"HiGHS's options by name, none of {', '.join(sorted(SET_HERE))}, which octmip sets", _are_of_highs, _of_highs
)


def _means(values: Values, words: str) -> dict[str, Any]:
    """Return what a field says of its option: its values, and a line of help."""
    return {"values": values, "help": words}


def values_of(option: "Field[Any]") -> Values:
    """Return the values that an option may have."""
    values: Values = option.metadata["values"]
    return values


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Options of every method.

    Raises
    ------
    ProblemError
        a value is none of those that its option may have.

    Examples
    --------
    >>> Options(checkpoint="found.kept").given()
    {'checkpoint': 'found.kept'}
    """

    checkpoint: Any = field(
        default=None,
        metadata=_means(CHECKPOINT, "file that keeps what was found: the same question again goes on from it"),
    )
    cluster: Any = field(
        default=None,
        metadata=_means(
            ANYONE, "local, or the address of a Dask scheduler: workers that share the work; the tree is the same"
        ),
    )

    def __post_init__(self) -> None:
        for one in fields(self):
            value, values = getattr(self, one.name), values_of(one)
            if value is not one.default and not values.hold(value):
                raise ProblemError(
                    f"{one.name} is {value!r}; expected {values.words}; give one, or leave {one.name} out"
                )

    def given(self) -> dict[str, Any]:
        """Return the options that differ from their defaults, by name."""
        values = {one.name: (getattr(self, one.name), one.default) for one in fields(self)}
        return {name: value for name, (value, default) in values.items() if value is not default}

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the options that name a file which a solver writes."""
        given = self.given()
        return tuple(one.name for one in fields(self) if one.name in given and values_of(one) in (FILE, MODEL_FILE))

    def asked(self) -> dict[str, Any]:
        """Return the options given that change what is found, by name."""
        without = {*self.outputs, "cluster", "checkpoint", "every"}
        return {name: value for name, value in self.given().items() if name not in without}

    def of_study(self) -> Self:
        """Return the options with the checkpoint as a file of many solves."""
        given = self.checkpoint
        return self if given is None or isinstance(given, Opened) else replace(self, checkpoint=Study(given))

    @contextlib.contextmanager
    def opened(self, n_workers: int | None) -> Iterator[Self]:
        """Return the options with an open cluster where they name one, so that several solves share it.

        Raises
        ------
        DataError, MissingExtraError
            as `open_cluster`.
        """
        if self.cluster is None or isinstance(self.cluster, Cluster):
            yield self
            return
        with open_cluster(self.cluster, n_workers) as cluster:
            yield replace(self, cluster=cluster)

    def of_kind(self, kind: type[T], who: str, without: tuple[str, ...] = ()) -> T:
        """Return these options as those of another class.

        Parameters
        ----------
        kind
            the class.
        who
            takes them, as in "method 'cart'".
        without
            options of the class that it does not take all the same.

        Raises
        ------
        ProblemError
            one that is given is none of those that `who` takes.
        """
        given = self.given()
        kind.refuse_unknown(given, who, without)
        return kind(**given)

    @classmethod
    def refuse_unknown(cls, names: Iterable[str], who: str, without: tuple[str, ...]) -> None:
        """Raise a ProblemError where one of the names is no option of this class that `who` takes."""
        takes = [name for name in cls.names() if name not in without]
        unknown = [name for name in names if name not in takes]
        if unknown:
            raise ProblemError(
                f"{who} takes no option {unknown[0]!r}; expected some of: {', '.join(sorted(takes))}; leave it out, or "
                "choose another method"
            )

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Return the names of the options."""
        return tuple(one.name for one in fields(cls))

    @classmethod
    def read(cls, words: Mapping[str, str], who: str, without: tuple[str, ...] = ()) -> Self:
        """Return the options that words of the command give by name; the rest as in `of_kind`.

        Raises
        ------
        ProblemError
            there is no such option, or the word is none of its values.
        """
        cls.refuse_unknown(words, who, without)
        known = {one.name: values_of(one) for one in fields(cls)}
        found = {}
        for name, word in words.items():
            try:
                found[name] = known[name].read(word)
            except ValueError as error:
                raise ProblemError(f"{name} is {word!r}; expected {known[name].words}; give one") from error
        return cls(**found)


NO_OPTIONS = Options()


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions(Options):
    """Options of the local search.

    >>> problem = Problem([[0], [1], [2]], ["a", "b", "a"], depth=2)
    >>> solve(problem, "search", options=SearchOptions(restarts=3)).tree
    Split(0, 0.5, Leaf(0), Split(0, 1.5, Leaf(1), Leaf(0)))
    """

    restarts: int | None = field(
        default=None,
        metadata=_means(_whole(1), "independent starts; by default more for small problems, 10 for trees of numbers"),
    )
    perturbations: int | None = field(
        default=None,
        metadata=_means(
            _whole(0), "a restart ends after so many in a row without a better tree; by default as restarts"
        ),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ExactOptions(Options):
    """Options of the exact cores.

    >>> problem = Problem([[0], [1], [2]], ["a", "b", "a"], depth=2)
    >>> solve(problem, options=ExactOptions(proof="tree.proof")).bound
    0.0
    """

    proof: str | Path | None = field(
        default=None,
        metadata=_means(
            FILE, "file for a proof log that certify --proof and check_proof verify; a second search writes it"
        ),
    )
    every: float | None = field(
        default=None,
        metadata=_means(SECONDS, "a proof of classes writes its state to the checkpoint so often [s] (default 60)"),
    )

    def __post_init__(self) -> None:
        Options.__post_init__(self)
        if self.every is not None and self.checkpoint is None:
            raise ProblemError(
                f"every is {self.every!r} without a checkpoint; expected the name of a file that is written so often; "
                "give checkpoint too, or leave every out"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class BendersOptions(Options):
    """Options of the methods that HiGHS proves for.

    >>> BendersOptions(start="search").given()
    {'start': 'search'}
    """

    start: str = field(
        default="cart", metadata=_means(STARTS_OF_HIGHS, "tree to start from: cart, or search for one of local search")
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class MipOptions(BendersOptions):
    """Options of the mixed-integer models.

    >>> MipOptions(write="model.mps").outputs
    ('write',)
    """

    highs: Mapping[str, bool | int | float | str] | None = field(
        default=None, metadata=_means(OF_HIGHS, "options of HiGHS itself, KEY=VALUE,KEY=VALUE")
    )
    log: str | Path | None = field(
        default=None, metadata=_means(FILE, "file for HiGHS's own log, to be written over; /dev/stderr shows it")
    )
    mu: float | None = field(
        default=None,
        metadata=_means(
            POSITIVE, "least distance of a sample from a hyperplane, in scaled features; by default by the data"
        ),
    )
    write: str | Path | None = field(
        default=None, metadata=_means(MODEL_FILE, "file for the model, .mps or .lp, before it is solved")
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class OctOptions(MipOptions):
    """Options of OCT."""

    root_rows: int | None = field(
        default=None,
        metadata=_means(
            _whole(0), "rows that say what the trees below each cut of the root cost, by so many subproblems of Benders"
        ),
    )


OPTIONS: Mapping[str, type[Options]] = {
    "cart": Options,
    "search": SearchOptions,
    "exact": ExactOptions,
    "oct": OctOptions,
    "oct_h": MipOptions,
    "flow": MipOptions,
    "benders": BendersOptions,
}
"""The class of each method's options."""
METHODS = ("auto", *OPTIONS)


def all_options() -> dict[str, "Field[Any]"]:
    """Return the fields of all options by name."""
    return {one.name: one for kind in OPTIONS.values() for one in fields(kind)}


def methods_with(name: str) -> list[str]:
    """Return the methods whose class has an option."""
    return [method for method, kind in OPTIONS.items() if name in kind.names()]


def help_of(name: str) -> str:
    """Return the line of help of an option, with the methods that take it."""
    methods = methods_with(name)
    whose = "" if len(methods) == len(OPTIONS) else f" ({', '.join(methods)})"
    return f"{all_options()[name].metadata['help']}{whose}"
