"""Mutants of what checks a claim: certificates, recounts, limits of a problem, readers of proofs and of tree files."""

from benchmarks.mutants.mutant import Mutant

NEARLY = "test_octmip/test_claims_nearly_right.py"
CERTIFICATE = (NEARLY, "test_octmip/test_certificate.py")
SETS = (NEARLY, "test_octmip/test_near_sets.py")
WORST = (NEARLY, "test_octmip/test_worst_case.py")
NUMBERS = (
    NEARLY,
    "test_octmip/test_regression_grid.py",
    "test_octmip/test_regression.py",
    "test_octmip/test_regression_proof.py",
)
TREE_FILE = (
    "test_octmip/test_tree_file.py",
    "test_octmip/test_tree_file_table.py",
    "test_octmip/test_hostile_files.py",
)

CLAIMS = (
    Mutant(
        "octmip/trees/certificate.py",
        "if solution.bound > objective + slack + most:",
        "if solution.bound > 2 * objective + slack + most:",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        "if abs(solution.objective - objective) > slack:",
        "if solution.objective - objective > slack:",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        "slack = 0.0 if is_exact else 1e-12 * abs(objective)",
        "slack = 1e-12 * abs(objective)",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        "if solution.bound > leaf + (0.0 if",
        "if solution.bound > 2 * leaf + (0.0 if",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/solution.py",
        "return tolerance == 0 or 0 < tolerance < least_saving",
        "return tolerance == 0 or 0 < tolerance <= least_saving",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        "sizes[smallest] < problem.leaf_size:",
        "sizes[smallest] + 1 < problem.leaf_size:",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        "if problem.sensor_cost_of(tree) > problem.sensor_limit:",
        "if len(problem.sensors_used(tree)) > problem.sensor_limit:",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        "if depth(tree) > problem.depth and",
        "if depth(tree) > problem.depth + 1 and",
        CERTIFICATE,
    ),
    Mutant(
        "octmip/trees/set_certificate.py",
        "if claimed.optimum != found.least:",
        "if claimed.optimum is not None and claimed.optimum > found.least:",
        SETS,
    ),
    Mutant("octmip/trees/set_certificate.py", "+= n * m", "+= n + m", SETS),
    Mutant("octmip/trees/set_certificate.py", "counts[cost + more + self.price, sensor] -= 1", "pass", SETS),
    Mutant("octmip/trees/set_certificate.py", "parts = feature, min(left, right)", "parts = feature, left", SETS),
    Mutant(
        "octmip/trees/set_certificate.py",
        "if claimed.limit is not None and exact > claimed.limit:",
        "if claimed.limit is not None and float(exact) > float(claimed.limit):",
        SETS,
    ),
    Mutant("octmip/trees/set_certificate.py", "rel_tol=1e-12", "rel_tol=1e-3", SETS),
    Mutant(
        "octmip/trees/set_certificate.py",
        "if claim is not None and claim != counted:",
        "if claim is not None and claim > counted:",
        SETS,
    ),
    Mutant(
        "octmip/trees/worst_case/recount.py",
        "if abs(solution.objective - found.worst) > slack:",
        "if solution.objective - found.worst > slack:",
        WORST,
    ),
    Mutant(
        "octmip/trees/worst_case/recount.py",
        "if solution.bound > least + solution.tolerance:",
        "if solution.bound > 2 * least + solution.tolerance:",
        WORST,
    ),
    Mutant(
        "octmip/trees/worst_case/recount.py",
        "min(found.worst, problem.baseline) + slack",
        "found.worst + slack",
        WORST,
    ),
    Mutant(
        "octmip/trees/worst_case/recount.py",
        "high[:, node.feature] > node.threshold",
        "high[:, node.feature] >= node.threshold",
        WORST,
    ),
    Mutant(
        "octmip/trees/worst_case/recount.py",
        "combinations(read, min(off, len(read)))",
        "combinations(read, min(1, len(read)))",
        WORST,
    ),
    Mutant(
        "octmip/trees/certificate.py",
        'most = solution.tolerance if problem.loss.predicts == "class" else 0.0',
        "most = solution.bound",
        NUMBERS,
    ),
    Mutant(
        "octmip/trees/problem.py",
        'if self.loss.predicts == "class" else LEAST_SAVING * objective',
        'if self.loss.predicts == "class" else 2 * LEAST_SAVING * objective',
        NUMBERS,
    ),
    Mutant(
        "octmip/trees/losses/class_costs.py",
        "return int(self.class_costs(weights, codes).argmin())",
        "return int(self.class_costs(weights, codes).argmax())",
        ("test_octmip/test_problem.py", "test_octmip/test_losses.py"),
    ),
    Mutant(
        "octmip/trees/losses/errors_of_numbers.py",
        "np.average((misses / largest) ** 2, weights=weights)",
        "np.average((misses / largest) ** 2)",
        ("test_octmip/test_losses.py",),
    ),
    Mutant(
        "octmip/trees/losses/class_costs.py",
        "return sum(w * c for w, c in zip(whole, prices, strict=True)) * Fraction(2) ** -(unit + grain)",
        "return sum(w * c for w, c in zip(whole, prices, strict=True)) * Fraction(2) ** -unit",
        ("test_octmip/test_losses.py",),
    ),
    Mutant(
        "octmip/trees/shape.py",
        "else self.sensor_budget + 1e-9 * max(1.0, self.sensor_budget)",
        "else self.sensor_budget",
        ("test_octmip/test_problem.py", *CERTIFICATE, "test_octmip/test_exact.py"),
    ),
    Mutant(
        "octmip/trees/shape.py",
        "used = {int(self.sensor_index[feature]) for feature in features_used(tree)}\n        return math.fsum",
        "used = [int(self.sensor_index[feature]) for feature in features_used(tree)]\n        return math.fsum",
        ("test_octmip/test_problem.py", *CERTIFICATE, "test_octmip/test_exact.py"),
    ),
    Mutant(
        "octmip/sensing/shared/solution.py",
        "if joint.bound > min(objective, least) + slack:",
        "if joint.bound > 2 * min(objective, least) + slack:",
        ("test_octmip/test_shared_budget.py",),
    ),
    Mutant(
        "octmip/sensing/shared/sensor_sets.py",
        "bound = min(self.closed, best, *(node.bound for node in self.open))",
        "bound = min(self.closed, best)",
        ("test_octmip/test_shared_budget.py",),
    ),
    Mutant(
        "octmip/trees/mip/blocks/thresholds.py",
        'rows.add("max_splits", -np.inf, max_splits,',
        'rows.add("max_splits", -np.inf, max_splits + 1,',
        ("test_octmip/test_mip_rows.py", "test_octmip/test_mip.py", "test_octmip/test_path.py"),
    ),
    Mutant(
        "octmip/trees/mip/oct.py",
        'rows.add("max_splits", -np.inf, problem.max_splits,',
        'rows.add("max_splits", -np.inf, problem.max_splits + 1,',
        ("test_octmip/test_mip_rows.py", "test_octmip/test_mip.py"),
    ),
    Mutant(
        "octmip/trees/proof.py",
        "if found.bound < bound:",
        "if found.bound < bound - 1:",
        ("test_octmip/test_proof.py", "test_octmip/test_exact_proof.py"),
    ),
    Mutant(
        "octmip/trees/regression/proof_log.py",
        "math.floor(wanted * unit)",
        "math.ceil(wanted * unit)",
        ("test_octmip/test_regression_proof.py",),
    ),
    Mutant("octmip/formats/tree_file.py", "if version != VERSION:", "if version < 0:", TREE_FILE),
    Mutant(
        "octmip/formats/tree_file.py",
        'if total != training["n_samples"]:',
        'if total > training["n_samples"]:',
        TREE_FILE,
    ),
    Mutant(
        "octmip/formats/tree_file.py",
        "if found.columns.feature_names != features:",
        "if len(found.columns.feature_names) != len(features):",
        TREE_FILE,
    ),
    Mutant(
        "octmip/formats/tree_nodes.py",
        "terms = sorted(zip(read, coefficients, strict=True))",
        "terms = list(zip(read, coefficients, strict=True))",
        TREE_FILE,
    ),
    Mutant("octmip/formats/tree_nodes.py", "if len(set(names)) < len(names):", "if not names:", TREE_FILE),
    Mutant(
        "octmip/formats/checked.py",
        "if type(value) in (int, float) and self.low <= value <= self.high:",
        "if type(value) in (int, float) and self.low <= value:",
        ("test_octmip/test_checked.py", *TREE_FILE),
    ),
    Mutant(
        "octmip/formats/solves_file.py",
        "run.method, run.seed, limits, options]",
        "run.method, limits, options]",
        ("test_octmip/test_solves_file.py",),
    ),
    Mutant(
        "octmip/formats/solves_file.py",
        "hexdigest()[:N_DIGITS].encode() != digits:",
        "hexdigest()[:N_DIGITS].encode() == b'':",
        ("test_octmip/test_solves_file.py",),
    ),
)
