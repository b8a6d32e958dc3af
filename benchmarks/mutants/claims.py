"""Mutants of what checks a claim: certificates, recounts, limits of a problem, readers of proofs and of tree files."""

from benchmarks.mutants.mutant import mutants_of

NEARLY = "test_octmip/test_claims_nearly_right.py"
CERTIFICATE = (NEARLY, "test_octmip/test_certificate.py")
SETS = (NEARLY, "test_octmip/test_near_sets.py")
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
    *mutants_of(
        "octmip/trees/certificate.py",
        CERTIFICATE,
        ("if solution.bound > objective + slack + most:", "if solution.bound > 2 * objective + slack + most:"),
        ("if abs(solution.objective - objective) > slack:", "if solution.objective - objective > slack:"),
        ("slack = 0.0 if is_exact else 1e-12 * abs(objective)", "slack = 1e-12 * abs(objective)"),
        ("if solution.bound > leaf + (0.0 if", "if solution.bound > 2 * leaf + (0.0 if"),
        ("sizes[smallest] < problem.leaf_size:", "sizes[smallest] + 1 < problem.leaf_size:"),
        (
            "if problem.sensor_cost_of(tree) > problem.sensor_limit:",
            "if len(problem.sensors_used(tree)) > problem.sensor_limit:",
        ),
        ("if depth(tree) > problem.depth and", "if depth(tree) > problem.depth + 1 and"),
    ),
    *mutants_of(
        "octmip/trees/solution.py",
        CERTIFICATE,
        (
            "return tolerance == 0 or 0 < tolerance < least_saving",
            "return tolerance == 0 or 0 < tolerance <= least_saving",
        ),
    ),
    *mutants_of(
        "octmip/trees/set_certificate.py",
        SETS,
        ("if claimed.optimum != found.least:", "if claimed.optimum is not None and claimed.optimum > found.least:"),
        ("+= n * m", "+= n + m"),
        ("counts[cost + more + self.price, sensor] -= 1", "pass"),
        ("parts = feature, min(left, right)", "parts = feature, left"),
        (
            "if claimed.limit is not None and exact > claimed.limit:",
            "if claimed.limit is not None and float(exact) > float(claimed.limit):",
        ),
        ("rel_tol=1e-12", "rel_tol=1e-3"),
        ("if claim is not None and claim != counted:", "if claim is not None and claim > counted:"),
    ),
    *mutants_of(
        "octmip/trees/certificate.py",
        NUMBERS,
        ('most = solution.tolerance if problem.loss.predicts == "class" else 0.0', "most = solution.bound"),
    ),
    *mutants_of(
        "octmip/trees/shape.py",
        ("test_octmip/test_problem.py", *CERTIFICATE, "test_octmip/test_exact.py"),
        ("else self.sensor_budget + 1e-9 * max(1.0, self.sensor_budget)", "else self.sensor_budget"),
    ),
    *mutants_of(
        "octmip/trees/problem.py",
        NUMBERS,
        (
            'if self.loss.predicts == "class" else LEAST_SAVING * objective',
            'if self.loss.predicts == "class" else 2 * LEAST_SAVING * objective',
        ),
    ),
    *mutants_of(
        "octmip/trees/losses/class_costs.py",
        ("test_octmip/test_problem.py", "test_octmip/test_losses.py"),
        (
            "return int(self.class_costs(weights, codes).argmin())",
            "return int(self.class_costs(weights, codes).argmax())",
        ),
    ),
    *mutants_of(
        "octmip/trees/losses/errors_of_numbers.py",
        ("test_octmip/test_losses.py",),
        ("np.average((misses / largest) ** 2, weights=weights)", "np.average((misses / largest) ** 2)"),
    ),
    *mutants_of(
        "octmip/trees/losses/class_costs.py",
        ("test_octmip/test_losses.py",),
        (
            "return sum(w * c for w, c in zip(whole, prices, strict=True)) * Fraction(2) ** -(unit + grain)",
            "return sum(w * c for w, c in zip(whole, prices, strict=True)) * Fraction(2) ** -unit",
        ),
    ),
    *mutants_of(
        "octmip/trees/problem.py",
        ("test_octmip/test_problem.py", *CERTIFICATE, "test_octmip/test_exact.py"),
        (
            "used = {int(self.sensor_index[feature]) for feature in features_used(tree)}\n        return math.fsum",
            "used = [int(self.sensor_index[feature]) for feature in features_used(tree)]\n        return math.fsum",
        ),
    ),
    *mutants_of(
        "octmip/sensing/joint_solution.py",
        ("test_octmip/test_shared_budget.py",),
        ("if joint.bound > min(objective, least) + ", "if joint.bound > 2 * min(objective, least) + "),
    ),
    *mutants_of(
        "octmip/sensing/sensor_sets.py",
        ("test_octmip/test_shared_budget.py",),
        (", *(one.bound for one in self.open))", ")"),
    ),
    *mutants_of(
        "octmip/trees/mip/blocks/thresholds.py",
        ("test_octmip/test_path.py",),
        ('rows.add("max_splits", -np.inf, max_splits,', 'rows.add("max_splits", -np.inf, max_splits + 1,'),
    ),
    *mutants_of(
        "octmip/trees/mip/oct.py",
        ("test_octmip/test_mip_splits.py",),
        (
            'rows.add("max_splits", -np.inf, problem.max_splits,',
            'rows.add("max_splits", -np.inf, problem.max_splits + 1,',
        ),
    ),
    *mutants_of(
        "octmip/trees/proof.py",
        ("test_octmip/test_proof.py", "test_octmip/test_exact_proof.py"),
        ("if found.bound < bound:", "if found.bound < bound - 1:"),
    ),
    *mutants_of(
        "octmip/trees/regression/proof_log.py",
        ("test_octmip/test_regression_proof.py",),
        ("math.floor(wanted * unit)", "math.ceil(wanted * unit)"),
    ),
    *mutants_of(
        "octmip/formats/tree_file.py",
        TREE_FILE,
        ("if version != VERSION:", "if version < 0:"),
        ('if total != training["n_samples"]:', 'if total > training["n_samples"]:'),
        ("if found.columns.feature_names != features:", "if len(found.columns.feature_names) != len(features):"),
    ),
    *mutants_of(
        "octmip/trees/tree_nodes.py",
        TREE_FILE,
        ("terms = sorted(zip(read, coefficients, strict=True))", "terms = list(zip(read, coefficients, strict=True))"),
        ("if len(set(names)) < len(names):", "if not names:"),
    ),
    *mutants_of(
        "octmip/input/checked.py",
        ("test_octmip/test_checked.py", *TREE_FILE),
        (
            "if type(value) in (int, float) and self.low <= value <= self.high:",
            "if type(value) in (int, float) and self.low <= value:",
        ),
    ),
    *mutants_of(
        "octmip/trees/solves_file.py",
        ("test_octmip/test_solves_file.py",),
        ("run.method, run.seed, limits, options]", "run.method, limits, options]"),
        ("hexdigest()[:N_DIGITS].encode() != digits:", "hexdigest()[:N_DIGITS].encode() == b'':"),
    ),
)
