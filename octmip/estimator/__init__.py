"""octmip behind scikit-learn's contract, for pipelines, cross-validation and grid search."""

from octmip.estimator.classifier import OptimalTreeClassifier

__all__ = ["OptimalTreeClassifier"]
