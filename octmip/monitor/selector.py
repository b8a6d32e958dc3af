"""Model selector: trees that map a reading to the state of the library whose model the asset is taken to follow.

Several trees, one per parameter, are one tree: the second appended to every leaf of the first. The distribution of a
selection is Bayes' rule over the library's states (`octmip.trees.uncertainty.posterior`), where what was seen is the
leaf that was reached.

Source: the data-driven model selection d = T(x), and the tree of the second parameter under every leaf of the first's:
M. G. Kapteyn, K. E. Willcox, From Physics-Based Models to Predictive Digital Twins via Interpretable Machine Learning
(2020), section 3.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from octmip.errors import DataError, OctmipError, TreeError
from octmip.formats.tree_file import TreeFile
from octmip.formats.tree_schema import NODE
from octmip.input.checked import ListOf, MapOf, Number, Record, Text, maybe
from octmip.input.files import PathLike, read_json_object, write_bytes
from octmip.input.messages import several, shown
from octmip.monitor.compiled import CompiledTree
from octmip.monitor.leaf_likelihood import LeafLikelihood
from octmip.monitor.library import Applied, Library
from octmip.trees.nodes.tree import Leaf, Node, features_used, leaves
from octmip.trees.nodes.tree_nodes import decode_tree, different, encode_tree
from octmip.trees.uncertainty import posterior
from octmip.twin import Loads

Floats = NDArray[np.float64]
FORMAT, VERSION = "octmip-selector", 1


@dataclass(frozen=True, slots=True)
class ParameterTree:
    """A tree that predicts one state parameter.

    Attributes
    ----------
    parameter
        its name.
    tree
        over readings per unit of load factor.
    values
        value of the parameter by class index, damage as a fraction.
    gauges
        (n_features,) names of what the tree reads.

    Examples
    --------
    >>> tree = Split(0, 125.0, Leaf(0), Leaf(1))  # of the gauge g1
    >>> one = ParameterTree("crack", tree, values=(0.0, 0.4), gauges=("g1",))
    >>> one.over(("g0", "g1")).tree
    Split(1, 125.0, Leaf(0), Leaf(1))
    """

    parameter: str
    tree: Node
    values: tuple[float, ...]
    gauges: tuple[str, ...]

    @classmethod
    def of(cls, file: TreeFile, parameter: str, unit: float = 0.01) -> "ParameterTree":
        """Return the tree of a tree file whose classes are numbers; `unit`: a class of 1 in fractions (percent)."""
        values = tuple(round(float(name) * unit, 12) for name in file.class_names)
        return cls(parameter, file.tree, values, file.feature_names)

    def over(self, gauges: tuple[str, ...]) -> "ParameterTree":
        """Return the tree with its features numbered in the order of other gauges, its own among them.

        Raises
        ------
        TreeError
            it names a gauge that is not among them.
        """
        missing = [name for name in self.gauges if name not in gauges]
        if missing:
            raise TreeError(f"the tree for {self.parameter} names the gauges {missing}, which the library lacks")
        classes = tuple(range(len(self.values)))
        return replace(
            self, tree=decode_tree(encode_tree(self.tree, self.gauges, classes), gauges, classes), gauges=gauges
        )


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """The state that one reading selects, with the probability of every other.

    Attributes
    ----------
    state
        index in the library.
    name
        of the state.
    distribution
        (n_states,) probability of every state of the library.
    path
        preorder numbers of the splits passed, and of the leaf.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> selection = ModelSelector(library, Split(0, 125.0, Leaf(0), Leaf(1))).select([148, 201], load_factor=1.0)
    >>> selection.name, selection.distribution.round(2).tolist()
    ('crack=0.4', [0.01, 0.99])
    """

    state: int
    name: str
    distribution: Floats
    path: tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class ModelSelector:
    """One tree whose classes are the states of a library.

    Attributes
    ----------
    library
        the states.
    tree
        leaf labels are indices of states; features are the library's gauges, per unit of load factor.

    Examples
    --------
    >>> library = Library(("crack",), [[0.0], [0.4]], ("g1", "g2"), [[100, 200], [150, 200]], noise_sd=10.0)
    >>> tree = Split(0, 125.0, Leaf(0), Leaf(1))  # of the gauge g1
    >>> selector = ModelSelector(library, tree)
    >>> selector.select([148, 201], load_factor=1.0).name, selector.gauges_read
    ('crack=0.4', ('g1',))
    """

    library: Library
    tree: Node
    compiled: CompiledTree = field(init=False, repr=False)
    likelihood: LeafLikelihood = field(init=False, repr=False)

    def __post_init__(self) -> None:
        highest = max(leaf.label for leaf in leaves(self.tree))
        if highest >= self.library.n_states:
            raise TreeError(
                f"the tree selects state {highest} but the library has {self.library.n_states}; give the tree's library"
            )
        object.__setattr__(self, "compiled", CompiledTree(self.tree, self.library.gauges))
        object.__setattr__(self, "likelihood", LeafLikelihood(self.tree, self.library))

    @classmethod
    def of_trees(cls, library: Library, trees: Sequence[ParameterTree]) -> "ModelSelector":
        """Return the selector of one tree per parameter, each appended to every leaf of the one before.

        Raises
        ------
        TreeError
            a tree reads a gauge or predicts a state that the library lacks.
        """
        return cls(library, _appended(library, list(trees), {}))

    def select(
        self, reading: Sequence[float] | Floats, load_factor: Applied, prior: ArrayLike | None = None
    ) -> Selection:
        """Return the selection of a reading (n_gauges,) in microstrain.

        `prior` (n_states,): probability of every state before the reading; None: all as likely.

        Raises
        ------
        ProblemError
            the prior is no distribution over the states.
        DataError
            its length is another, the load is not positive, or it lacks a number where the tree asks.
        """
        row = self.library.features(np.asarray(reading, dtype=np.float64), load_factor)
        leaf = self.compiled.node(row)
        state = self.compiled.label(row)
        log_likelihood = self.likelihood.log_likelihood(np.asarray(reading, dtype=np.float64)[None], load_factor)
        path = tuple(self.compiled.path_to(leaf))
        return Selection(state, self.library.state_names[state], posterior(log_likelihood, prior)[0], path)

    def select_many(self, readings: Floats, load_factor: Applied) -> NDArray[np.int64]:
        """Return the states of readings (n, n_gauges) in microstrain, `REFUSED` where there is none, shape (n,)."""
        return self.compiled.labels(self.library.features(readings, load_factor))

    @property
    def gauges_read(self) -> tuple[str, ...]:
        """Gauges that the tree reads."""
        return tuple(self.library.gauges[j] for j in features_used(self.tree))

    def write(self, path: PathLike) -> None:
        """Write the selector as JSON: tree, gauges, states and strains; floats come back to the last bit.

        Raises
        ------
        DataError
            it cannot be written.
        TreeError
            two states differ only beyond the six digits of their names.
        """
        library = self.library
        different(library.state_names, "state_names")  # two states of one name could not be read apart
        content = {
            "format": FORMAT,
            "version": VERSION,
            "tree": encode_tree(self.tree, library.gauges, library.state_names),
            "parameters": library.parameters,
            "state_names": library.state_names,
            **{name: getattr(library, name).tolist() for name in _ARRAYS},
            "gauges": library.gauges,
            "only_load": library.only_load,
            "reference": None if library.reference is None else dict(library.reference),
        }
        write_bytes(path, (json.dumps(content, indent=1, allow_nan=False) + "\n").encode())

    @classmethod
    def read(cls, path: PathLike) -> "ModelSelector":
        """Return the selector that `write` wrote.

        Raises
        ------
        DataError
            the file cannot be read.
        TreeError
            it is of another kind, or what it holds is no selector.
        """
        content = read_json_object(path)
        if content.get("format") != FORMAT or content.get("version") != VERSION:
            raise TreeError(
                f"{path} is no selector file: format {shown(content.get('format'))}, version "
                f"{shown(content.get('version'))}; expected {FORMAT!r}, {VERSION}; write it with ModelSelector.write"
            )
        try:
            return _selector(CONTENT.take(content))
        except OctmipError as error:
            raise TreeError(
                f"{path} holds no valid selector: {error}; write it again with ModelSelector.write"
            ) from error


STRAIN = Number(-1e15, 1e15)  # microstrain, and slopes of it: what is beyond is no measured thing, and overflows
CONTENT = Record(
    {
        "tree": NODE,
        "parameters": ListOf(Text()),
        "state_names": ListOf(Text(), 1),
        "states": ListOf(ListOf(STRAIN), 1),
        "strains": ListOf(ListOf(STRAIN), 1),
        "noise_sd": ListOf(Number(1e-15, 1e15), 1),
        "widths": ListOf(STRAIN),
        "slopes": ListOf(ListOf(ListOf(STRAIN)), 1),
        "gauges": ListOf(Text(), 1),
        "only_load": maybe(Number(1e-9, 1e9)),
        "reference": maybe(MapOf(STRAIN)),
    }
)
_ARRAYS = ("states", "strains", "noise_sd", "widths", "slopes")


def _selector(content: dict[str, Any]) -> ModelSelector:
    """Return the selector of a file's entries, once their sizes and names fit one another."""
    gauges, names = tuple(content["gauges"]), different(content["state_names"], "state_names")
    arrays = {name: _array(content[name], name) for name in _ARRAYS}
    loads = content["reference"]
    reference = None if loads is None else Loads(tuple(loads), tuple(loads.values()))
    one = content["only_load"]
    library = Library(tuple(content["parameters"]), gauges=gauges, only_load=one, reference=reference, **arrays)
    if names != library.state_names:
        raise TreeError(f"state_names begins {several(names, 2)}; expected those of states, {library.state_names[0]!r}")
    return ModelSelector(library, decode_tree(content["tree"], gauges, names))


def _array(rows: list[Any], name: str) -> Floats:
    try:
        return np.array(rows, dtype=np.float64)
    except ValueError as error:
        raise TreeError(f"{name} has rows of unequal length; expected one length for all") from error


def _appended(library: Library, trees: list[ParameterTree], told: Mapping[str, float]) -> Node:
    """Return the first tree with the others under each leaf; `told`: what the trees above have predicted."""
    if not trees:
        return Leaf(library.index_of(told))
    first, rest = trees[0], trees[1:]

    def appended(node: Node) -> Node:
        if isinstance(node, Leaf):
            try:
                return _appended(library, rest, {**told, first.parameter: first.values[node.label]})
            except (IndexError, DataError) as error:
                raise TreeError(f"the tree for {first.parameter} has a leaf without a value: {error}") from error
        return replace(node, left=appended(node.left), right=appended(node.right))

    return appended(first.over(library.gauges).tree)
