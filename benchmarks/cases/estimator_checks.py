"""scikit-learn's own checks of both estimators without any argument, and with hyperplanes.

The tests run the same checks with a depth, or without time, which is sooner done.
"""

import os
import time
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

os.environ["SCIPY_ARRAY_API"] = "1"  # scipy reads it when it is imported; without it some checks are skipped

from sklearn.utils.estimator_checks import check_estimator

from benchmarks.tables import Line
from octmip import OptimalTreeClassifier, OptimalTreeRegressor

HYPERPLANES: dict[str, Any] = {"split": "hyperplane", "split_size": 2}
ESTIMATORS: dict[str, Callable[..., Any]] = {
    "classifier": OptimalTreeClassifier,
    "classifier, hyperplanes": partial(OptimalTreeClassifier, **HYPERPLANES),
    "regressor": OptimalTreeRegressor,
}


def results(limit: float, threads: list[int]) -> Iterator[Line]:
    """Yield one line for each estimator; `limit` [s] is that of each of its fits."""
    for name, estimator in ESTIMATORS.items():
        start = time.process_time()
        found = checked(estimator(seconds=limit, n_jobs=threads[0]))
        others = [f"{check}: {status} {why}" for check, status, why in found if status != "passed"]
        line: Line = {"case": name, "checks": len(found), "passed": len(found) - len(others), "others": others}
        yield line | {"cpu_seconds": time.process_time() - start}


def checked(estimator: Any) -> list[tuple[str, str, str]]:
    """Return of every check its name, "passed", "failed" or "skipped", and the reason."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = check_estimator(estimator, on_skip=None, on_fail=None)
    return [(check["check_name"], check["status"], str(check["exception"])) for check in found]
