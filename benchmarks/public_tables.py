"""Public tables as arrays, and the yardstick on them: CART, pruned as scikit-learn's users prune it."""

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from sklearn.model_selection import StratifiedKFold
from sklearn.tree import DecisionTreeClassifier

from benchmarks.data import SHARED
from octmip.formats.columns import Columns

MOST_TEXTS = 50
"""A column of text with more values names its rows, and is left out."""
MOST_ALPHAS = 25
"""Prices that the pruning of CART tries, at quantiles of those of its own path."""


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


class PrunedCart:
    """scikit-learn's CART with cost-complexity pruning, its price of least error over five folds."""

    def fit(self, X: NDArray[np.float64], y: NDArray[Any]) -> "PrunedCart":
        """Choose the price, and grow the tree with it."""
        path = DecisionTreeClassifier(random_state=0).cost_complexity_pruning_path(X, y).ccp_alphas
        alphas = np.unique(np.quantile(np.maximum(path, 0.0), np.linspace(0, 1, MOST_ALPHAS), method="nearest"))
        prices = np.sqrt(alphas * np.append(alphas[1:], alphas[-1]))
        errors = np.zeros(len(prices))
        for train, held in StratifiedKFold(5, shuffle=True, random_state=0).split(X, y):
            for k, price in enumerate(prices):
                tree = DecisionTreeClassifier(random_state=0, ccp_alpha=price).fit(X[train], y[train])
                errors[k] += (tree.predict(X[held]) != y[held]).sum()
        least = np.flatnonzero(errors == errors.min())[-1]  # of equals the smallest tree
        self.tree = DecisionTreeClassifier(random_state=0, ccp_alpha=prices[least]).fit(X, y)
        return self

    def predict(self, X: NDArray[np.float64]) -> NDArray[Any]:
        """Return the class of each row."""
        found: NDArray[Any] = self.tree.predict(X)
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
