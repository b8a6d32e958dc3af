"""Mutants of what finds and proves trees: grids of costs, regression, near-optimal sets, roles, frontiers, solver."""

from benchmarks.mutants.mutant import mutants_of

COSTS = ("test_octmip/test_encoding_costs.py", "test_octmip/test_exact_numerics.py", "test_octmip/test_fuzz_corpus.py")
NUMBERS = (
    "test_octmip/test_regression_grid.py",
    "test_octmip/test_regression.py",
    "test_octmip/test_regression_proof.py",
)
QUESTIONS = ("test_octmip/test_regression_questions.py",)
SETS = ("test_octmip/test_claims_nearly_right.py", "test_octmip/test_near_sets.py")
ROLES = ("test_octmip/test_near_sensors.py",)
FRONTIER = ("test_octmip/test_claims_nearly_right.py", "test_octmip/test_frontier.py")
PATH = ("test_octmip/test_path.py",)

PROOFS = (
    *mutants_of(
        "octmip/trees/encoding/costs.py",
        COSTS,
        ("self.loss += len(members) + float(past.sum(dtype=float))", "self.loss += 0"),
        ("self.loss += len(equal) * (1.0 + max(past))", "self.loss += 0"),
        ("self.loss += loss", "self.loss += 0"),
        ("(float(price - penalty) * n_prices if price < self.cap else 0)", "0.0"),
        ("self.cap = -(-above // self.step)", "self.cap = (above // self.step)"),
        ("if is_exact and self.step == 1 and (price", "if is_exact and (price"),
        ("min(self.cap, int(scaled * price)) for price", "int(scaled * price) for price"),
    ),
    *mutants_of(
        "octmip/trees/encoding/costs.py",
        COSTS,
        ("return nearest if Fraction(nearest) <= exact else math.nextafter(nearest, -math.inf)", "return nearest"),
    ),
    *mutants_of(
        "octmip/trees/solution.py",
        COSTS,
        (
            "return distance if is_tolerable(hidden, least_saving) else -1.0",
            "return distance if is_tolerable(hidden, 2 * least_saving) else -1.0",
        ),
    ),
    *mutants_of(
        "octmip/trees/regression/grid.py",
        NUMBERS,
        ("rounding = 2.0**-44 * size", "rounding = 0.0"),
        ("        exact -= self.base\n", ""),
        ("exact = exact - Fraction(moved) if", "exact = exact if"),
        ("exact -= Fraction(self.distance) * Fraction(self.total)", "exact -= 0"),
        ("        if self.is_whole:\n", "        if self.loss.slopes is not None:\n"),
        ("+ self.rounding) * (1 + 1e-12)", ") * (1 - 1e-3)"),
    ),
    *mutants_of(
        "octmip/trees/regression/exact.py",
        NUMBERS,
        ("least = min([closed, *(part.bound for part in open_parts)])", "least = closed"),
        ("if extra is None or self.stop is not Stop.OPTIMAL:", "if extra is None:"),
        (
            "if problem.sensor_cost_of(tree) <= problem.sensor_limit:",
            "if len(problem.sensors_used(tree)) <= problem.sensor_limit:",
        ),
    ),
    *mutants_of(
        "octmip/trees/regression/best_split.py",
        QUESTIONS,
        ("self.problem.leaf_penalty * (len(plane.features) - 1)", "0.0"),
        ("(k >= size) & (len(values) - k >= size)", "(k >= size) & (len(values) - k >= 1)"),
        ("/ np.where(left > 0, left, 1.0)", "/ np.maximum(left, 1.0)"),
    ),
    *mutants_of(
        "octmip/trees/regression/leaf_models.py",
        QUESTIONS,
        (
            "np.searchsorted(below, below[-1] * slopes.up / (slopes.up + slopes.down))",
            'np.searchsorted(below, below[-1] * slopes.up / (slopes.up + slopes.down), side="right")',
        ),
    ),
    *mutants_of(
        "octmip/trees/near_sets/counting.py",
        SETS,
        ("if entry[0] <= self.units]", "if entry[0] < self.units]"),
        ("first.is_optimal and first.tolerance == 0 and Fraction(first.bound) >= known", "first.is_optimal"),
        ("else Fraction(max(0.0, first.bound))", "else known"),
        ("not self.open_features and all(cut.trees is not None for cut in cuts)", "not self.open_features"),
        ("else Fraction(str(number))", "else Fraction(number)"),
        ("any(masks) or (self.is_complete and not self.cuts)", "any(masks)"),
        ("if total >= UNCOUNTABLE:", "if total < 0:"),
    ),
    *mutants_of(
        "octmip/trees/near_sets/near_set.py",
        SETS,
        ("while number >= most:", "while number > most:"),
    ),
    *mutants_of(
        "octmip/trees/near_sets/near_set.py",
        (*ROLES, *SETS),
        ("for s, sensor in enumerate(self.problem.sensors):", "for s, sensor in enumerate(self.problem.sensors[:1]):"),
    ),
    *mutants_of(
        "octmip/trees/near_sets/whole_numbers.py",
        SETS,
        ("above, most < NARROW, by_sets", "above, True, by_sets"),
    ),
    *mutants_of(
        "octmip/trees/near_sets/whole_numbers.py",
        (*SETS, *ROLES),
        ("sum(weights) * max(costs) + penalty * min(2**problem.depth, problem.n_samples)", "sum(weights) * max(costs)"),
    ),
    *mutants_of(
        "octmip/trees/near_sets/without.py",
        ROLES,
        ("if set(known.sensors) <= set(sensors) and not set(known.read)", "if not set(known.read)"),
        ("[known for known in self.known if set(known.sensors) <= set(sensors)]", "list(self.known)"),
    ),
    *mutants_of(
        "octmip/trees/near_sets/roles.py",
        ROLES,
        ("(forced > limit and not forced_is_proven)", "False"),
        ("(k >= problem.leaf_size) & (len(rows) - k >= problem.leaf_size)", "(k >= problem.leaf_size)"),
        ("or margin > most:", "or margin > 0:"),
    ),
    *mutants_of(
        "octmip/trees/tradeoff/frontier.py",
        FRONTIER,
        ("bound=min(best, solution.objective)", "bound=best"),
        ('return points if over == "penalty" else', "return"),
        ("return [(value, None) for value in sorted(chosen)]", "return [(value, None) for value in chosen]"),
    ),
    *mutants_of(
        "octmip/trees/tradeoff/path.py",
        PATH,
        (
            "known = [bound for _, bound in below if math.isfinite(bound)]",
            "known = [bound for _, bound in bounds if math.isfinite(bound)]",
        ),
        ("for penalty in (low, high) if", "for penalty in (low,) if"),
        ("rounded_down(min(at))", "rounded_down(max(at))"),
    ),
    *mutants_of(
        "octmip/trees/solves_file.py",
        ("test_octmip/cli/test_cli_signals.py",),
        (
            "if solution.stop is not Stop.INTERRUPTED:\n        kept.keep",
            "if solution.stop is not None:\n        kept.keep",
        ),
    ),
    *mutants_of(
        "octmip/trees/solver.py",
        ("test_octmip/test_solver.py",),
        ("if better.is_optimal and better.stop is not Stop.INTERRUPTED:", "if better.stop is not Stop.INTERRUPTED:"),
    ),
)
