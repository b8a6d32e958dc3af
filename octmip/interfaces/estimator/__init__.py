"""octmip behind scikit-learn's contract, for pipelines, cross-validation and grid search."""

from octmip.interfaces.estimator.classifier import OptimalTreeClassifier
from octmip.interfaces.estimator.regressor import OptimalTreeRegressor

__all__ = ["OptimalTreeClassifier", "OptimalTreeRegressor"]
