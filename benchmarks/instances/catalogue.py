"""The instances: a table of samples, the tree that is wanted of it, and the formulation that it is written in.

    oct      Bertsimas & Dunn's OCT (unsplit nodes closed)      flow     the flow rows, every cut in the model
    oct_h    their OCT-H                                        flow_h   the flow rows with hyperplanes

An objective is the number of misclassified samples. Hyperplanes keep a band of mu = 0.001 away from the samples
(features scaled to a range of 1); the trees of these files are those that do.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from benchmarks.data import Table, first_rows, published, uci
from benchmarks.problem_options import ProblemOptions
from octmip.trees.mip import flow, oct, oct_h
from octmip.trees.mip.incumbent import starting_tree
from octmip.trees.mip.rows import Rows
from octmip.trees.problem import Problem

MU = 1e-3

Encoder = Callable[[Problem], Rows]

ENCODERS: dict[str, Encoder] = {
    "oct": lambda problem: oct.encode(problem).rows,
    "flow": lambda problem: flow.encode(problem, starting_tree(problem, None, 0), fix=0).rows,
    "oct_h": lambda problem: oct_h.encode(problem, MU).rows,
    "flow_h": lambda problem: flow.encode(problem, starting_tree(problem, None, 0), fix=0, mu=MU).rows,
}

TABLES: dict[str, Callable[[], Table]] = {
    "iris": partial(uci, "iris"),
    "wine": partial(uci, "wine"),
    **{
        f"{target}-{n}": partial(lambda target, n: first_rows(published(target, 0), n), target, n)
        for target in ("mu1", "mu2")
        for n in (175, 350, 1750)
    },
}


@dataclass(frozen=True, slots=True)
class Instance:
    """One file: formulation, table, depth, and features in a split (None: as many as there are; 1: axis-aligned)."""

    formulation: str
    table: str
    depth: int
    split_size: int | None = 1

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        size = {1: "", None: "-all"}.get(self.split_size, f"-k{self.split_size}")
        return f"{self.formulation}-{self.table}-d{self.depth}{size}"

    def problem(self) -> Problem:
        """Return the problem."""
        data = TABLES[self.table]()
        options: ProblemOptions = {"depth": self.depth}
        if self.split_size != 1:
            options |= {"split": "hyperplane", "split_size": self.split_size}
        return Problem(data.features, data.labels, **options)

    def rows(self) -> Rows:
        """Return the model."""
        return ENCODERS[self.formulation](self.problem())


INSTANCES: tuple[Instance, ...] = (
    *(
        Instance(formulation, table, depth)
        for table, depth in (
            ("iris", 1),
            ("iris", 2),
            ("iris", 3),
            ("wine", 2),
            ("mu1-175", 2),
            ("mu2-175", 2),
            ("mu1-350", 2),
            ("mu1-350", 3),
            ("mu2-350", 2),
            ("mu1-1750", 2),
            ("mu2-1750", 2),
        )
        for formulation in ("oct", "flow")
    ),
    *(
        Instance(formulation, table, 2, split_size)
        for table, split_size in (("iris", 2), ("wine", 2), ("wine", None))
        for formulation in ("oct_h", "flow_h")
    ),
)
