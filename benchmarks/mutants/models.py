"""Mutants of what is said about structures and readings: credible sets, beliefs, gap evidence, estimates of femlib."""

from benchmarks.mutants.mutant import mutants_of

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
    *mutants_of(
        "octmip/trees/uncertainty/credible.py",
        CREDIBLE,
        ("scores <= self.thresholds)", "scores < self.thresholds)"),
        ("coverage * (running[-1] + weight.max())", "coverage * running[-1]"),
        ("1.0 - confidence)", "confidence)"),
        ("rng.random((len(scores), 1)) <= self.ties", "self.ties > 0"),
    ),
    *mutants_of(
        "octmip/trees/uncertainty/leaf_distribution.py",
        CREDIBLE,
        ("(weights + strength * towards)", "(weights + strength)"),
    ),
    *mutants_of(
        "octmip/trees/uncertainty/calibration.py",
        CREDIBLE,
        ("np.ceil(given * n_bins).astype(int) - 1", "np.floor(given * n_bins).astype(int)"),
    ),
    *mutants_of(
        "octmip/monitor/belief.py",
        FILTER,
        ("(threshold - (states - width / 2)) / width", "(threshold - states) / width"),
        ("levels[at] + (share - 0.5) * width", "levels[at] + share * width"),
    ),
    *mutants_of(
        "octmip/gap/inference/evidence.py",
        EVIDENCE,
        (
            "((eta * size).sum(axis=-1) - (mean**2 / sd**2).sum(axis=-1) - log_det)",
            "((eta * size).sum(axis=-1) - log_det)",
        ),
        ("np.logaddexp.reduce(logs, axis=1) - np.log(len(choices))", "np.logaddexp.reduce(logs, axis=1)"),
        ("turned = low > 0.0  #", "turned = low > 1e9  #"),
        ("covariance = covariance * ratio[..., :, None] * ratio[..., None, :]", "covariance = covariance * 1.0"),
        ("covariance = second - size[:, :, None] * size[:, None, :]", "covariance = second"),
        ("gain = white.T @ left - solved[:, :-1].T @ solved[:, -1]", "gain = white.T @ left"),
        (
            "share = log_between(size, spread, bounds) - log_between(mean, sd, bounds)",
            "share = log_between(size, spread, bounds)",
        ),
    ),
    *mutants_of(
        "octmip/gap/inference/confounding.py",
        DIAGNOSIS,
        ("cross -= with_others.T @ inverse @ with_others[:, member]", "cross -= 0.0"),
        ("np.where(discrete, mean, np.clip(needed, *prior.bounds))", "np.where(discrete, mean, needed)"),
    ),
    *mutants_of(
        "octmip/gap/inference/unknown.py",
        DIAGNOSIS,
        ("- np.log1p(gain), axis=1)", "- gain, axis=1)"),
        ("float(logsumexp(every)) - log_kinds, log_kinds", "float(logsumexp(every)), log_kinds"),
    ),
    *mutants_of(
        "octmip/gap/inference/posterior.py",
        DIAGNOSIS,
        (" - log(max(comb(inputs.priors.n_effects, k), 1))", ""),
    ),
    *mutants_of(
        "femlib/assembly/quality.py",
        QUALITY,
        ("TRIANGLE = 2.0", "TRIANGLE = 1.0"),
        ("if not error <= limit:", "if not error <= 2 * limit:"),
        ("    quality.refuse(limit)\n", ""),
    ),
    *mutants_of(
        "femlib/rom/bound.py",
        REDUCED,
        ("gamma / (1.0 - gamma) * sharp", "gamma * sharp"),
        ("both += ((r / diagonal) * d).sum(axis=0)", "both += 0.0"),
        ("first_bound = np.abs(left) + plain", "first_bound = plain"),
        ("return np.inf\n", "return float(self.joint[-1])\n"),
        ("np.maximum(own[:, None], own))", "np.minimum(own[:, None], own))"),
        ("np.sqrt(own[:, None] * own) / levels[level]", "np.sqrt(own[:, None] * own)"),
        ("weights = (mu[k] / (1.0 - mu[k]), 1.0 / diagonal)", "weights = (mu[k], 1.0 / diagonal)"),
        ("return min(of_blocks, float(self.joint", "return 0.1 * min(of_blocks, float(self.joint"),
    ),
    *mutants_of(
        "femlib/rom/model.py",
        REDUCED,
        ("return np.asarray(bound + rounding)", "return np.asarray(bound)"),
    ),
)
