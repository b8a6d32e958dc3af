"""octmip behind scikit-learn's contract, for pipelines, cross-validation and grid search."""

from octmip.estimator.classifier import OptimalTreeClassifier
from octmip.estimator.regressor import OptimalTreeRegressor

__all__ = ["OptimalTreeClassifier", "OptimalTreeRegressor"]
