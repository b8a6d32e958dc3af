"""Public tables as arrays, and the yardstick on them: CART, pruned as scikit-learn's users prune it."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sklearn.impute import SimpleImputer
from sklearn.model_selection import GridSearchCV, KFold, StratifiedKFold
from sklearn.pipeline import make_pipeline
from sklearn.tree import DecisionTreeClassifier, DecisionTreeRegressor

from benchmarks.data import SHARED
from octmip.formats.columns import Columns

MOST_TEXTS = 50
"""A column of text with more values names its rows, and is left out."""
FEWEST_ROWS, FEWEST_VALUES, MOST_ROWS, MOST_COLUMNS = 100, 20, 1000, 12
"""Of a table with a column as targets."""
MOST_ALPHAS = 25
"""Prices that the pruning of CART tries, at quantiles of those of its own path."""
SECONDS = 600.0
"""Of the default and of STreeD: more than they take, so that a busy machine chooses as an idle one."""


def ordered() -> list[tuple[str, str]]:
    """Return every table with its half, in the order of the runs."""
    names = sorted(path.stem for path in (SHARED / "uci").glob("*.csv"))
    half = {name: "odd" if k % 2 == 0 else "even" for k, name in enumerate(names)}
    size = {name: (SHARED / "uci" / f"{name}.csv").stat().st_size for name in names}
    return [(name, half[name]) for name in sorted(names, key=lambda name: (half[name], size[name]))]


def samples(table: str) -> tuple[NDArray[np.float64], NDArray[Any]]:
    """Return features and classes of a table; columns of text that name the rows are left out."""
    frame = pd.read_csv(SHARED / "uci" / f"{table}.csv", na_values=["?"], low_memory=False)
    label = frame.columns[-1]
    frame = frame[frame[label].notna()]
    columns = frame.drop(columns=[label]).dropna(axis=1, how="all")
    texts = [name for name in columns if not pd.api.types.is_numeric_dtype(columns[name])]
    columns = columns.drop(columns=[name for name in texts if columns[name].nunique() > MOST_TEXTS])
    features = Columns.learn(columns, categories="yes-no", missing="either-side").encode(columns)
    return np.ascontiguousarray(features), frame[label].astype(str).to_numpy()


def numbers(table: str) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return whole columns of numbers and, as targets, the one of most values; None where few rows or columns are left.

    The class is left out. Of more than `MOST_ROWS` rows so many are drawn, of more than `MOST_COLUMNS` the first taken.
    """
    frame = pd.read_csv(SHARED / "uci" / f"{table}.csv", na_values=["?"], low_memory=False).iloc[:, :-1]
    columns = frame.select_dtypes("number").dropna(axis=1)
    n_values = columns.nunique()
    if len(columns) < FEWEST_ROWS or columns.shape[1] < 3 or n_values.max() < FEWEST_VALUES:
        return None
    drawn = columns.sample(min(len(columns), MOST_ROWS), random_state=0)
    target = n_values.idxmax()
    return drawn.drop(columns=[target]).to_numpy(np.float64)[:, :MOST_COLUMNS], drawn[target].to_numpy(np.float64)


class PrunedCart:
    """scikit-learn's CART with cost-complexity pruning, its price of least error over five folds.

    Attributes
    ----------
    is_class
        whether errors are counted, or squares of misses added.
    """

    def __init__(self, is_class: bool = True) -> None:
        self.is_class = is_class

    def fit(self, X: NDArray[np.float64], y: NDArray[Any]) -> "PrunedCart":
        """Choose the price, and grow the tree with it."""
        grower = DecisionTreeClassifier if self.is_class else DecisionTreeRegressor
        folds = StratifiedKFold if self.is_class else KFold
        path = grower(random_state=0).cost_complexity_pruning_path(X, y).ccp_alphas
        alphas = np.unique(np.quantile(np.maximum(path, 0.0), np.linspace(0, 1, MOST_ALPHAS), method="nearest"))
        prices = np.sqrt(alphas * np.append(alphas[1:], alphas[-1]))
        errors = np.zeros(len(prices))
        for train, held in folds(5, shuffle=True, random_state=0).split(X, y):
            for k, price in enumerate(prices):
                found = grower(random_state=0, ccp_alpha=price).fit(X[train], y[train]).predict(X[held])
                errors[k] += (found != y[held]).sum() if self.is_class else ((found - y[held]) ** 2).sum()
        least = np.flatnonzero(errors == errors.min())[-1]  # of equals the smallest tree
        self.tree = grower(random_state=0, ccp_alpha=prices[least]).fit(X, y)
        return self

    def predict(self, X: NDArray[np.float64]) -> NDArray[Any]:
        """Return the class of each row."""
        found: NDArray[Any] = self.tree.predict(X)
        return found


def grid_cart() -> GridSearchCV:
    """Return CART with depth and leaf size by GridSearchCV: 24 points, five folds."""
    grid = {"max_depth": [2, 3, 4, 5, 8, None], "min_samples_leaf": [1, 5, 10, 20]}
    return GridSearchCV(DecisionTreeClassifier(random_state=0), grid, cv=5)


class TunedStreed:
    """STreeD's optimal tree of depth 3, ten cuts of a feature, its size tuned by its own cross-validation."""

    def fit(self, X: NDArray[np.float64], y: NDArray[Any]) -> "TunedStreed":
        """Tune the number of splits; missing numbers are the median of their column."""
        from pystreed import STreeDClassifier

        self.classes, codes = np.unique(y, return_inverse=True)
        self.model = make_pipeline(
            SimpleImputer(strategy="median"),
            STreeDClassifier(max_depth=3, n_thresholds=10, hyper_tune=True, time_limit=SECONDS),
        )
        self.model.fit(X, codes)
        return self

    def get_n_leaves(self) -> int:
        """Return the leaves of the tree."""
        return int(self.model[-1].get_n_leaves())

    def predict(self, X: NDArray[np.float64]) -> NDArray[Any]:
        """Return the class of each row."""
        found: NDArray[Any] = self.classes[self.model.predict(X)]
        return found


class CartOfLeaves:
    """scikit-learn's CART, pruned by cost-complexity to so many leaves at most."""

    def __init__(self, n_leaves: int) -> None:
        self.n_leaves = n_leaves

    def fit(self, X: NDArray[np.float64], y: NDArray[Any]) -> "CartOfLeaves":
        """Grow the tree with the least price that leaves it small enough."""
        prices = np.maximum(DecisionTreeClassifier(random_state=0).cost_complexity_pruning_path(X, y).ccp_alphas, 0.0)
        low, high = 0, len(prices) - 1  # the last price leaves the root alone
        while low < high:
            middle = (low + high) // 2
            fits = _grown(X, y, prices[middle]).get_n_leaves() <= self.n_leaves
            low, high = (low, middle) if fits else (middle + 1, high)
        self.tree = _grown(X, y, prices[low])
        return self

    def predict(self, X: NDArray[np.float64]) -> NDArray[Any]:
        """Return the class of each row."""
        found: NDArray[Any] = self.tree.predict(X)
        return found


def _grown(X: NDArray[np.float64], y: NDArray[Any], price: float) -> DecisionTreeClassifier:
    # A price from the path prunes the link that it belongs to only if it is no less by rounding.
    return DecisionTreeClassifier(random_state=0, ccp_alpha=price * (1 + 1e-9)).fit(X, y)
