"""Distributions of the classes in leaves: smoothing, priors, Bayes' rule."""

from octmip.trees.uncertainty.leaf_distribution import LeafDistribution, posterior, smoothed_shares

__all__ = ["LeafDistribution", "posterior", "smoothed_shares"]
