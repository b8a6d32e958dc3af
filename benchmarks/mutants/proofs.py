"""Mutants of what finds and proves trees: grids of costs, regression, near-optimal sets, roles, frontiers, solver."""

from benchmarks.mutants.mutant import Mutant

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
    Mutant(
        "octmip/trees/encoding/grid.py",
        "self.loss += len(members) + float(past.sum(dtype=float))",
        "self.loss += 0",
        COSTS,
    ),
    Mutant("octmip/trees/encoding/grid.py", "self.loss += len(equal) * (1.0 + max(past))", "self.loss += 0", COSTS),
    Mutant("octmip/trees/encoding/grid.py", "self.loss += loss", "self.loss += 0", COSTS),
    Mutant(
        "octmip/trees/encoding/grid.py", "(float(price - penalty) * n_prices if price < self.cap else 0)", "0.0", COSTS
    ),
    Mutant(
        "octmip/trees/encoding/grid.py", "self.cap = -(-above // self.step)", "self.cap = (above // self.step)", COSTS
    ),
    Mutant(
        "octmip/trees/encoding/grid.py", "if is_exact and self.step == 1 and (price", "if is_exact and (price", COSTS
    ),
    Mutant(
        "octmip/trees/encoding/grid.py",
        "min(self.cap, int(scaled * price)) for price",
        "int(scaled * price) for price",
        COSTS,
    ),
    Mutant(
        "octmip/trees/encoding/numbers.py",
        "return nearest if Fraction(nearest) <= exact else math.nextafter(nearest, -math.inf)",
        "return nearest",
        COSTS,
    ),
    Mutant(
        "octmip/trees/solution.py",
        "return distance if is_tolerable(distance, least_saving) else -1.0",
        "return distance if is_tolerable(distance, 2 * least_saving) else -1.0",
        COSTS,
    ),
    Mutant("octmip/trees/regression/grid.py", "rounding = 2.0**-44 * size", "rounding = 0.0", NUMBERS),
    Mutant("octmip/trees/regression/grid.py", "        exact -= self.base\n", "", NUMBERS),
    Mutant("octmip/trees/regression/grid.py", "exact = exact - Fraction(moved) if", "exact = exact if", NUMBERS),
    Mutant(
        "octmip/trees/regression/grid.py",
        "exact -= Fraction(self.distance) * Fraction(self.total)",
        "exact -= 0",
        NUMBERS,
    ),
    Mutant(
        "octmip/trees/regression/grid.py",
        "        if self.is_whole:\n",
        "        if self.loss.slopes is not None:\n",
        NUMBERS,
    ),
    Mutant("octmip/trees/regression/grid.py", "+ self.rounding) * (1 + 1e-12)", ") * (1 - 1e-3)", NUMBERS),
    Mutant(
        "octmip/trees/regression/exact.py",
        "least = min([closed, *(part.bound for part in open_parts)])",
        "least = closed",
        NUMBERS,
    ),
    Mutant(
        "octmip/trees/regression/exact.py",
        "if extra is None or self.stop is not Stop.OPTIMAL:",
        "if extra is None:",
        NUMBERS,
    ),
    Mutant(
        "octmip/trees/regression/exact.py",
        "if problem.sensor_cost_of(tree) <= problem.sensor_limit:",
        "if len(problem.sensors_used(tree)) <= problem.sensor_limit:",
        NUMBERS,
    ),
    Mutant(
        "octmip/trees/regression/best_split.py",
        "self.problem.leaf_penalty * (len(plane.features) - 1)",
        "0.0",
        QUESTIONS,
    ),
    Mutant(
        "octmip/trees/regression/best_split.py",
        "(k >= size) & (len(values) - k >= size)",
        "(k >= size) & (len(values) - k >= 1)",
        QUESTIONS,
    ),
    Mutant(
        "octmip/trees/regression/best_split.py", "/ np.where(left > 0, left, 1.0)", "/ np.maximum(left, 1.0)", QUESTIONS
    ),
    Mutant(
        "octmip/trees/regression/leaf_models.py",
        "np.searchsorted(below, below[-1] * slopes.up / (slopes.up + slopes.down))",
        'np.searchsorted(below, below[-1] * slopes.up / (slopes.up + slopes.down), side="right")',
        QUESTIONS,
    ),
    Mutant("octmip/trees/near_sets/counting.py", "if entry[0] <= self.units]", "if entry[0] < self.units]", SETS),
    Mutant(
        "octmip/trees/near_sets/counting.py",
        "first.is_optimal and first.tolerance == 0 and Fraction(first.bound) >= known",
        "first.is_optimal",
        SETS,
    ),
    Mutant("octmip/trees/near_sets/counting.py", "else Fraction(max(0.0, first.bound))", "else known", SETS),
    Mutant(
        "octmip/trees/near_sets/counting.py",
        "not self.open_features and all(cut.trees is not None for cut in cuts)",
        "not self.open_features",
        SETS,
    ),
    Mutant("octmip/trees/near_sets/counting.py", "else Fraction(str(number))", "else Fraction(number)", SETS),
    Mutant(
        "octmip/trees/near_sets/counting.py",
        "any(masks) or (self.is_complete and not self.cuts)",
        "any(masks)",
        SETS,
    ),
    Mutant("octmip/trees/near_sets/counting.py", "if total >= UNCOUNTABLE:", "if total < 0:", SETS),
    Mutant("octmip/trees/near_sets/near_set.py", "while number >= most:", "while number > most:", SETS),
    Mutant(
        "octmip/trees/near_sets/near_set.py",
        "for s, sensor in enumerate(self.problem.sensors):",
        "for s, sensor in enumerate(self.problem.sensors[:1]):",
        (*ROLES, *SETS),
    ),
    Mutant("octmip/trees/near_sets/whole_numbers.py", "above, most < NARROW, by_sets", "above, True, by_sets", SETS),
    Mutant(
        "octmip/trees/near_sets/whole_numbers.py",
        "sum(weights) * max(costs) + penalty * min(2**problem.depth, problem.n_samples)",
        "sum(weights) * max(costs)",
        (*SETS, *ROLES),
    ),
    Mutant(
        "octmip/trees/near_sets/without.py",
        "if set(known.sensors) <= set(sensors) and not set(known.read)",
        "if not set(known.read)",
        ROLES,
    ),
    Mutant(
        "octmip/trees/near_sets/without.py",
        "[known for known in self.known if set(known.sensors) <= set(sensors)]",
        "list(self.known)",
        ROLES,
    ),
    Mutant("octmip/trees/near_sets/roles.py", "(forced > limit and not forced_is_proven)", "False", ROLES),
    Mutant(
        "octmip/trees/near_sets/roles.py",
        "(k >= problem.leaf_size) & (len(rows) - k >= problem.leaf_size)",
        "(k >= problem.leaf_size)",
        ROLES,
    ),
    Mutant("octmip/trees/near_sets/roles.py", "or margin > most:", "or margin > 0:", ROLES),
    Mutant("octmip/trees/tradeoff/frontier.py", "bound=min(best, solution.objective)", "bound=best", FRONTIER),
    Mutant("octmip/trees/tradeoff/frontier.py", 'return points if over == "penalty" else', "return", FRONTIER),
    Mutant(
        "octmip/trees/tradeoff/frontier.py",
        "return [(value, None) for value in sorted(chosen)]",
        "return [(value, None) for value in chosen]",
        FRONTIER,
    ),
    Mutant(
        "octmip/trees/tradeoff/path.py",
        "known = [bound for _, bound in below if math.isfinite(bound)]",
        "known = [bound for _, bound in bounds if math.isfinite(bound)]",
        PATH,
    ),
    Mutant("octmip/trees/tradeoff/path.py", "for penalty in (low, high) if", "for penalty in (low,) if", PATH),
    Mutant(
        "octmip/trees/tradeoff/path.py",
        "rounded_down(min(at))",
        "rounded_down(max(at))",
        PATH,
    ),
    Mutant(
        "octmip/formats/solves_file.py",
        "if solution.stop is not Stop.INTERRUPTED:\n        kept.keep",
        "if solution.stop is not None:\n        kept.keep",
        ("test_octmip/cli/test_cli_signals.py",),
    ),
    Mutant(
        "octmip/trees/solver.py",
        "if better.is_optimal and better.stop is not Stop.INTERRUPTED:",
        "if better.stop is not Stop.INTERRUPTED:",
        ("test_octmip/test_solver.py",),
    ),
)
