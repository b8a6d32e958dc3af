"""Mutants of what is said about structures and readings: credible sets, beliefs, gap evidence, estimates of femlib."""

from benchmarks.mutants.mutant import Mutant

NEARLY = "test_octmip/test_claims_nearly_right.py"
CREDIBLE = (NEARLY, "test_octmip/test_uncertainty.py")
EVIDENCE = (
    "test_octmip/test_gap_tails_and_projections.py",
    "test_octmip/test_gap_evidence.py",
    "test_octmip/test_gap_inference.py",
)
DIAGNOSIS = (*EVIDENCE, "test_octmip/test_gap_diagnosis.py", "test_octmip/test_gap_doubts.py")
FILTER = (
    NEARLY,
    "test_octmip/test_monitor_filter.py",
)
QUALITY = ("test_femlib/test_quality.py", "test_femlib/test_structure.py")
REDUCED = ("test_femlib/test_rom_bound.py", "test_femlib/test_rom.py", "test_femlib/test_reduced_modes.py")

MODELS = (
    Mutant("octmip/trees/uncertainty/credible.py", "scores <= self.thresholds)", "scores < self.thresholds)", CREDIBLE),
    Mutant(
        "octmip/trees/uncertainty/credible.py",
        "coverage * (running[-1] + weight.max())",
        "coverage * running[-1]",
        CREDIBLE,
    ),
    Mutant("octmip/trees/uncertainty/credible.py", "1.0 - confidence)", "confidence)", CREDIBLE),
    Mutant(
        "octmip/trees/uncertainty/credible.py", "rng.random((len(scores), 1)) <= self.ties", "self.ties > 0", CREDIBLE
    ),
    Mutant(
        "octmip/trees/uncertainty/leaf_distribution.py",
        "(weights + strength * towards)",
        "(weights + strength)",
        CREDIBLE,
    ),
    Mutant(
        "octmip/trees/uncertainty/calibration.py",
        "np.ceil(given * n_bins).astype(int) - 1",
        "np.floor(given * n_bins).astype(int)",
        CREDIBLE,
    ),
    Mutant(
        "octmip/monitor/belief.py", "(threshold - (states - width / 2)) / width", "(threshold - states) / width", FILTER
    ),
    Mutant("octmip/monitor/belief.py", "levels[at] + (share - 0.5) * width", "levels[at] + share * width", FILTER),
    Mutant("octmip/monitor/belief.py", 'method="higher"', 'method="lower"', FILTER),
    Mutant(
        "octmip/gap/inference/evidence.py",
        "((eta * size).sum(axis=-1) - (mean**2 / sd**2).sum(axis=-1) - log_det)",
        "((eta * size).sum(axis=-1) - log_det)",
        EVIDENCE,
    ),
    Mutant(
        "octmip/gap/inference/evidence.py",
        "np.logaddexp.reduce(logs, axis=1) - np.log(len(choices))",
        "np.logaddexp.reduce(logs, axis=1)",
        EVIDENCE,
    ),
    Mutant("octmip/gap/inference/evidence.py", "turned = low > 0.0  #", "turned = low > 1e9  #", EVIDENCE),
    Mutant(
        "octmip/gap/inference/evidence.py",
        "covariance = covariance * ratio[..., :, None] * ratio[..., None, :]",
        "covariance = covariance * 1.0",
        EVIDENCE,
    ),
    Mutant(
        "octmip/gap/inference/evidence.py",
        "covariance = second - size[:, :, None] * size[:, None, :]",
        "covariance = second",
        EVIDENCE,
    ),
    Mutant(
        "octmip/gap/inference/evidence.py",
        "gain = white.signatures.T @ left - solved[:, :-1].T @ solved[:, -1]",
        "gain = white.signatures.T @ left",
        EVIDENCE,
    ),
    Mutant(
        "octmip/gap/inference/evidence.py",
        "share = log_between(size, spread, bounds) - log_between(mean, sd, bounds)",
        "share = log_between(size, spread, bounds)",
        EVIDENCE,
    ),
    Mutant(
        "octmip/gap/inference/confounding.py",
        "cross -= with_others.T @ inverse @ with_others[:, member]",
        "cross -= 0.0",
        DIAGNOSIS,
    ),
    Mutant(
        "octmip/gap/inference/confounding.py",
        "np.where(discrete, mean, np.clip(needed, *prior.bounds))",
        "np.where(discrete, mean, needed)",
        DIAGNOSIS,
    ),
    Mutant("octmip/gap/inference/unknown.py", "- np.log1p(gain), axis=1)", "- gain, axis=1)", DIAGNOSIS),
    Mutant(
        "octmip/gap/inference/unknown.py",
        "float(logsumexp(every)) - log_kinds, log_kinds",
        "float(logsumexp(every)), log_kinds",
        DIAGNOSIS,
    ),
    Mutant(
        "octmip/gap/inference/search.py",
        " - log(max(comb(inputs.priors.n_effects, k), 1))",
        "",
        DIAGNOSIS,
    ),
    Mutant("femlib/assembly/quality.py", "TRIANGLE = 2.0", "TRIANGLE = 1.0", QUALITY),
    Mutant("femlib/assembly/quality.py", "if not error <= limit:", "if not error <= 2 * limit:", QUALITY),
    Mutant("femlib/assembly/quality.py", "    quality.refuse(limit)\n", "", QUALITY),
    Mutant("femlib/rom/bound.py", "gamma / (1.0 - gamma) * sharp", "gamma * sharp", REDUCED),
    Mutant("femlib/rom/bound.py", "both += ((r / diagonal) * d).sum(axis=0)", "both += 0.0", REDUCED),
    Mutant("femlib/rom/bound.py", "first_bound = np.abs(left) + plain", "first_bound = plain", REDUCED),
    Mutant("femlib/rom/bound.py", "return np.inf\n", "return float(self.joint[-1])\n", REDUCED),
    Mutant("femlib/rom/bound.py", "np.maximum(own[:, None], own))", "np.minimum(own[:, None], own))", REDUCED),
    Mutant(
        "femlib/rom/bound.py", "np.sqrt(own[:, None] * own) / levels[level]", "np.sqrt(own[:, None] * own)", REDUCED
    ),
    Mutant(
        "femlib/rom/bound.py",
        "weights = (mu[k] / (1.0 - mu[k]), 1.0 / diagonal)",
        "weights = (mu[k], 1.0 / diagonal)",
        REDUCED,
    ),
    Mutant(
        "femlib/rom/bound.py",
        "return min(of_blocks, float(self.joint",
        "return 0.1 * min(of_blocks, float(self.joint",
        REDUCED,
    ),
    Mutant("femlib/rom/model.py", "return np.asarray(bound + rounding)", "return np.asarray(bound)", REDUCED),
)
