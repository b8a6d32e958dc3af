"""Distributions of the classes in leaves, their calibration, and sets of classes with a stated coverage.

leaf_distribution   probabilities of the classes in each leaf: smoothing, priors, Bayes' rule
calibration         do probabilities hold? reliability, expected calibration error, Brier score
credible            sets of classes that hold the truth with a stated probability, whatever the distribution is
"""

from octmip.trees.uncertainty.calibration import Brier, ReliabilityBin, brier_score, calibration_error, reliability
from octmip.trees.uncertainty.credible import CredibleSets, calibrate_sets
from octmip.trees.uncertainty.leaf_distribution import LeafDistribution, posterior, smoothed_shares

__all__ = [
    "Brier",
    "CredibleSets",
    "LeafDistribution",
    "ReliabilityBin",
    "brier_score",
    "calibrate_sets",
    "calibration_error",
    "posterior",
    "reliability",
    "smoothed_shares",
]
