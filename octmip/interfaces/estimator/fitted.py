"""FittedTree: everything that both estimators do and say, apart from reading labels and predictions."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix
from sklearn.utils import Tags
from sklearn.utils.validation import check_is_fitted

from octmip.errors import ProblemError, SolverError
from octmip.formats.columns import Columns
from octmip.formats.table.preparation import Preparation, with_written_cuts
from octmip.formats.tree_file import record_tree
from octmip.input.files import PathLike
from octmip.input.messages import several
from octmip.interfaces.estimator.drawing import figure_of, notebook_picture, words_of, write_page
from octmip.interfaces.estimator.importance import feature_savings
from octmip.interfaces.estimator.paths import leaf_nodes, node_indicator
from octmip.interfaces.estimator.progress import Told
from octmip.interfaces.estimator.proof import method_proves, warn_unproven
from octmip.interfaces.estimator.samples import read_samples, test_samples
from octmip.interfaces.estimator.settings import (
    AUTO,
    Settings,
    depth_of,
    directions_of_columns,
    leaf_size_of,
    leaf_weight_of,
    seed_of,
    sensors_of,
    threads_of,
)
from octmip.trees.answer.certificate import Certificate, certify
from octmip.trees.answer.solution import Limits, Solution, Stop
from octmip.trees.methods.options import NO_OPTIONS
from octmip.trees.nodes.tree import Node, depth, leaves, with_sides_for_missing
from octmip.trees.question.parts import rules_of_columns
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import splits_of
from octmip.trees.runs.drawn_rows import search_seconds
from octmip.trees.runs.registry import Run
from octmip.trees.solver import solve_run
from octmip.trees.tradeoff import Choice
from octmip.trees.tradeoff.default import solve_default

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class FittedTree(Settings):
    """How an estimator finds its tree, and what it says about it: its figures, its words, a picture and a page."""

    problem_: Problem
    solution_: Solution
    certificate_: Certificate
    columns_: Columns
    choice_: Choice | None
    _routes: Node
    """The tree with a side for missing cells at every split: where training had none, that of more weight."""
    _label_name: str | None

    def __sklearn_tags__(self) -> Tags:
        tags = super().__sklearn_tags__()  # type: ignore[misc]
        tags.input_tags.allow_nan = self.split == "axis" and self.missing != "refuse"
        tags.input_tags.string = tags.input_tags.categorical = self.categories != "refuse"
        return tags

    def _answer(
        self,
        features: NDArray[np.float64],
        labels: NDArray[Any],
        weights: NDArray[np.float64],
        start: float,
        **own: Any,
    ) -> Run:
        """Solve the problem of the samples that weigh something, keep what is known of its tree, and return the run.

        `own` are the fields of the Problem that the other estimator has not; `start` is when the fit began [s].
        """
        limits, seed, threads = Limits(seconds=self.seconds), seed_of(self.random_state), threads_of(self.n_jobs)
        told = Told() if self.verbose else None
        kept = weights != 0
        problem = Problem(
            features[kept],
            labels[kept],
            depth=depth_of(self),
            split=self.split,
            split_size=self.split_size,
            leaf_size=leaf_size_of(self.min_samples_leaf, int(kept.sum())),
            leaf_weight=leaf_weight_of(self.min_weight_fraction_leaf, weights),
            monotone=directions_of_columns(self.columns_, self.monotonic_cst),
            fixed_splits=self.fixed_splits,
            path_rules=rules_of_columns(self.path_rules or (), self.columns_.column_of_feature),
            max_splits=splits_of(self.max_leaf_nodes, self.split, "max_leaf_nodes"),
            leaf_penalty=self.leaf_penalty,
            weights=weights[kept],
            sensor_of_feature=sensors_of(self.columns_, self.sensor_of_feature),
            sensor_cost=self.sensor_cost,
            sensor_budget=self.sensor_budget,
            feature_names=self.columns_.feature_names,
            **own,
        )
        # Samples were read and copied within the limit, and the tree is checked and given its sides within it.
        seconds = search_seconds(problem, limits.remaining(start).seconds)
        run = Run(self.method, replace(limits, seconds=seconds), seed, threads, self.options or NO_OPTIONS, told)
        if self.max_depth == AUTO:
            found = solve_default(problem, replace(run, method="auto"), told)
            problem, solution, self.choice_ = found.problem, found.solution, found.choice
        else:
            solution, self.choice_ = solve_run(problem, run), None
        if solution.tree is None:
            raise SolverError(f"{solution.solver} found no tree within {self.seconds} s; give it more seconds")
        self.problem_, self.solution_ = problem, with_written_cuts(problem, solution, self.columns_)
        self.certificate_ = certify(problem, self.solution_)
        self._routes = with_sides_for_missing(self.tree_, problem.samples.features, problem.samples.weights)
        return run

    def _say_how_it_ended(self) -> None:
        """Raise the Ctrl-C that ended the fit, or warn of a proof that a limit ended."""
        if self.solution_.stop is Stop.INTERRUPTED:
            raise KeyboardInterrupt("the best tree so far is fitted")
        if self.max_depth != AUTO:
            warn_unproven(self.solution_, method_proves(self.problem_, self.method), self.seconds)

    @property
    def tree_(self) -> Node:
        """The tree, over the features of `problem_`."""
        check_is_fitted(self, "solution_")
        tree = self.solution_.tree
        return tree

    @property
    def objective_(self) -> float:
        """Cost of the training samples, in units of weight times cost or error, and the price of the splits."""
        check_is_fitted(self, "solution_")
        return self.solution_.objective

    @property
    def bound_(self) -> float:
        """No tree of the problem has a training objective below it; -inf without a proof."""
        check_is_fitted(self, "solution_")
        return self.solution_.bound

    @property
    def gap_(self) -> float:
        """Relative gap between training objective and bound: 0 when proven optimal, +inf without a proof."""
        check_is_fitted(self, "solution_")
        return self.solution_.gap

    @property
    def is_optimal_(self) -> bool:
        """Whether it is proven that no tree of the problem has a smaller training objective."""
        check_is_fitted(self, "solution_")
        return self.solution_.is_optimal

    @property
    def sensors_(self) -> tuple[str, ...]:
        """The sensors that the tree reads: columns of X, or what `sensor_of_feature` calls them."""
        check_is_fitted(self, "solution_")
        return self.certificate_.sensors

    def get_depth(self) -> int:
        """Return the number of splits on the longest path from the root to a leaf."""
        return depth(self.tree_)

    def get_n_leaves(self) -> int:
        """Return the number of leaves."""
        return len(leaves(self.tree_))

    def apply(self, X: ArrayLike) -> NDArray[np.int64]:
        """Return the number of the leaf that each row of X reaches, shape (n_samples,).

        Nodes are numbered in preorder: the root 0, a node before its left side, that before its right side.
        """
        check_is_fitted(self, "solution_")
        return leaf_nodes(self._routes, read_samples(self, X))

    def decision_path(self, X: ArrayLike) -> csr_matrix:
        """Return which nodes each row of X passes, a sparse matrix (n_samples, n_nodes); nodes as in `apply`."""
        check_is_fitted(self, "solution_")
        return node_indicator(self._routes, read_samples(self, X))

    @property
    def feature_importances_(self) -> NDArray[np.float64]:
        """Share of each column of X in what the splits save of the training cost, shape (n_features_in_,).

        A split saves the cost of the best answer for its samples minus those of its two sides; the shares add up to 1,
        or are all 0 where no split saves anything. See `octmip.interfaces.estimator.importance`.
        """
        saved = feature_savings(self.problem_, self.tree_)
        of_column = np.repeat(np.arange(len(self.columns_.columns)), [len(c.features) for c in self.columns_.columns])
        shares = np.bincount(of_column, saved, len(self.columns_.columns))
        return np.asarray(shares / shares.sum() if shares.sum() > 0 else shares)

    def export_text(self) -> str:
        """Return the tree as indented lines, with the training samples of each leaf; of classes how many are wrong."""
        check_is_fitted(self, "solution_")
        return words_of(self.problem_, self.tree_, self.columns_)

    def plot(
        self,
        title: str | None = None,
        *,
        histograms: bool = False,
        sample: ArrayLike | None = None,
        dark: bool = False,
    ) -> "Figure":
        """Return a drawing of the tree, a matplotlib Figure made without pyplot; save it with ``figure.savefig``.

        Parameters
        ----------
        title
            above the tree.
        histograms
            whether each split shows the values of the training samples that come to it, and its threshold.
        sample
            one row like those of X, shape (1, n_features_in_), whose way through the tree is marked.
        dark
            light lines on a dark ground.

        Raises
        ------
        MissingExtraError
            matplotlib is not installed.
        ProblemError
            `sample` has more rows than one.
        """
        check_is_fitted(self, "solution_")
        row = None if sample is None else read_samples(self, sample)
        if row is not None and len(row) != 1:
            raise ProblemError(
                f"sample has {len(row)} rows; expected one of the columns {several(self.columns_.names)}; "
                "give one row, as X[:1]"
            )
        how = {"histograms": histograms, "sample": row, "dark": dark}
        tree = self._routes if row is not None and np.isnan(row).any() else self.tree_
        return figure_of(self.problem_, tree, self.columns_, title, **how)

    def report(
        self, path: PathLike, X_test: ArrayLike | None = None, y_test: ArrayLike | None = None, seconds: float = 10.0
    ) -> None:
        """Write a page about the tree, its errors and its proof: one HTML file that needs nothing else.

        Parameters
        ----------
        path
            of the file.
        X_test, y_test
            samples and targets that were not trained on, by which the page judges the tree; None: without them.
        seconds
            for the best tree of every lower depth, with which the page compares this one [s]; 0: without them.

        Raises
        ------
        MissingExtraError
            what draws the page is not installed.
        DataError
            the file cannot be written, or y_test holds what is no class of the training, or no number.
        """
        check_is_fitted(self, "solution_")
        held_out = None if X_test is None else test_samples(self, X_test, y_test)
        preparation = Preparation(self.columns_)
        lacks = held_out is not None and np.isnan(held_out.features).any()
        solution = replace(self.solution_, tree=self._routes) if lacks else self.solution_
        file = record_tree(self.problem_, solution, self._label_name, preparation=preparation)
        write_page(path, self.problem_, file, held_out, seconds)

    def _repr_html_inner(self) -> str:
        return self._with_picture(str(super()._repr_html_inner()))  # type: ignore[misc]

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, str]:
        bundle: dict[str, str] = super()._repr_mimebundle_(**kwargs)  # type: ignore[misc]
        if "text/html" in bundle:
            bundle["text/html"] = self._with_picture(bundle["text/html"])
        return bundle

    def _with_picture(self, diagram: str) -> str:
        """Return scikit-learn's diagram, with the tree below it once there is one."""
        if not hasattr(self, "solution_"):
            return diagram
        return diagram + notebook_picture(self.problem_, self.solution_, self.columns_)
