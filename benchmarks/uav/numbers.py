"""mu as a number: regression trees beside the classification tree, CART and the Bayes estimator.

The classes of the study are five losses of stiffness; a tree that predicts a number may say any other, and is judged by
how far off it is: mean absolute error (MAE) and root of the mean squared error (RMSE), on training and test readings.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

from benchmarks.tables import markdown
from benchmarks.uav.bayes import class_posterior
from benchmarks.uav.study import LABELS
from femlib.dataset import Dataset
from octmip import Limits, Problem, Solution, predict, predict_values, solve
from octmip.trees.losses import number_loss
from octmip.trees.tree import Node

Floats = NDArray[np.float64]
Rule = Callable[[Floats], Floats]
HEADER = ("label", "predicts", "depth", "MAE train", "MAE test", "RMSE train", "RMSE test", "objective", "proven")


def rows_of(data: Dataset, depths: Sequence[int], seconds: float) -> Iterator[dict[str, object]]:
    """Yield a row for every label and rule: regression trees, classification tree, CART, Bayes estimators."""
    for label in LABELS:
        levels = getattr(data, label).astype(float)
        for name, depth, rule, claim in _rules(data, label, depths, seconds):
            row: dict[str, object] = {"label": label, "rule": name, "depth": depth, **claim}
            for part, rows in (("train", data.is_train), ("test", ~data.is_train)):
                misses = rule(data.features[rows]) - levels[rows]
                row[f"mae_{part}"] = float(np.abs(misses).mean())
                row[f"rmse_{part}"] = float(np.sqrt((misses**2).mean()))
            yield row


def _rules(
    data: Dataset, label: str, depths: Sequence[int], seconds: float
) -> Iterator[tuple[str, int | None, Rule, dict[str, object]]]:
    features, levels = data.features[data.is_train], getattr(data, label)[data.is_train]
    targets = levels.astype(float)
    for depth in depths:
        for loss in ("squared", "absolute"):
            asked = Problem(features, targets, depth=depth, loss=number_loss(loss))
            solution = solve(asked, limits=Limits(seconds=seconds))
            tree = solution.tree
            assert tree is not None
            yield f"regression tree, {loss} error", depth, partial(predict_values, tree), _claim(solution)
        problem = Problem(features, levels, depth=depth)
        found = solve(problem, limits=Limits(seconds=seconds))
        assert found.tree is not None
        names = np.array(problem.class_names, dtype=float)
        yield "classification tree, errors", depth, partial(_class_of, found.tree, names), _claim(found)
        for model in (DecisionTreeRegressor(max_depth=depth, random_state=0), DecisionTreeClassifier(max_depth=depth)):
            fitted = model.fit(features, targets)
            yield f"scikit-learn {type(model).__name__}", depth, fitted.predict, {}
    values, class_of_state = np.unique(data.states_percent[:, LABELS.index(label)], return_inverse=True)

    def posterior(x: Floats) -> Floats:
        return class_posterior(x, data.mean_features, data.noise_sd, class_of_state, len(values))

    yield "Bayes, posterior mean", None, lambda x: posterior(x) @ values, {}
    yield "Bayes, posterior median", None, lambda x: _median(posterior(x), values), {}


def _claim(solution: Solution) -> dict[str, object]:
    return {"objective": solution.objective, "gap": solution.gap}


def _class_of(tree: Node, names: Floats, features: Floats) -> Floats:
    return np.asarray(names[predict(tree, features)])


def _median(posterior: Floats, values: NDArray[np.int64]) -> Floats:
    return np.asarray(values[(np.cumsum(posterior, axis=1) >= 0.5).argmax(axis=1)], dtype=np.float64)


def text_of(rows: Sequence[dict[str, object]]) -> str:
    """Return the table, errors in percent loss of stiffness."""
    cells = []
    for row in rows:
        figures = [f"{row[f'{measure}_{part}']:.2f}" for measure in ("mae", "rmse") for part in ("train", "test")]
        gap = row.get("gap")
        proven = "-" if gap is None else ("yes" if gap == 0 else f"gap {100 * float(str(gap)):.1f} %")
        objective = f"{row['objective']:.10g}" if "objective" in row else "-"
        cells.append([row["label"], row["rule"], row["depth"] or "-", *figures, objective, proven])
    return f"# mu as a number\n\nErrors in percent loss of stiffness; all gauges.\n\n{markdown(HEADER, cells)}\n"
