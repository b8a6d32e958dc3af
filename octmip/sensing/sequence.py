"""The best tree whose sensors are read in sequence: proven for shallow axis-aligned trees, searched for otherwise.

what is asked             how it is answered (docs/theory/sensing.md)
price > 0                 branch and bound on error + price * cost
price 0, no budget        the same with a price too small to buy one error: the cheapest of the optimal trees
budget                    for every multiplier, min of error + multiplier * (cost - budget) is a bound; the best of
                          these bounds and the best tree within the budget; then branch and bound over fronts between
search                    exact subtrees of two levels, one after the other, in trees of every kind; the bound is that
                          of the problem without acquisition and what the first reading costs
"""

import math
import time
from dataclasses import dataclass, field, replace
from typing import Literal

from octmip.errors import CertificateError, ProblemError
from octmip.problem import Problem
from octmip.sensing.descent import descend
from octmip.sensing.inspection import Inspection, InspectionCertificate, recount
from octmip.sensing.native_sequence import Answer, Core
from octmip.solution import Limits, Solution, Stop
from octmip.solver import solve
from octmip.tree import Leaf, Node

TOLERANCE = 1e-9


def solve_inspection(
    inspection: Inspection,
    method: Literal["auto", "exact", "search"] = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
) -> Solution:
    """Return the best tree of an inspection and the bound proven for it.

    Args:
        inspection: what is asked.
        method: "exact" proves (axis-aligned trees; to depth 2 in seconds, at depth 3 in minutes for thousands of
            samples; with a `leaf_size` much longer, as the strongest bound does not hold then: a `leaf_penalty` keeps
            it); "search" has the problem's own bound and the first reading's; "auto": exact to depth 3.
        limits: seconds of the whole, nodes and gap of each search; to reach one is no error.
        seed, n_jobs: of the solver of the problem without acquisition, where the search begins; the proof has one
            thread.

    Returns:
        The solution; its objective is the inspection's. `details["cheapest"]` says whether the tree is proven the
        cheapest in expectation among those of its objective.

    Raises:
        ProblemError: the method is unknown, or "exact" is asked for hyperplanes.
    """
    problem = inspection.problem
    if method not in ("auto", "exact", "search"):
        raise ProblemError(f"method is {method!r}; expected auto, exact or search")
    if method == "exact" and problem.split != "axis":
        raise ProblemError("the exact search over readings knows axis-aligned trees only; choose method 'search'")
    is_exact = method == "exact" or (method == "auto" and problem.split == "axis" and problem.depth <= 3)
    call = _Call(inspection, limits, seed, n_jobs)
    call.begin()
    try:
        call.prove() if is_exact else call.search()
    except KeyboardInterrupt:
        call.stop = Stop.INTERRUPTED
    return call.solution("inspection" if is_exact else "inspection search")


@dataclass(slots=True)
class _Call:
    """What one call knows: it only grows."""

    inspection: Inspection
    limits: Limits
    seed: int
    n_jobs: int
    start: float = field(default_factory=time.perf_counter)
    trees: list[tuple[float, float, Node]] = field(default_factory=list)  # error with haste, cost sum, tree
    bound: float = -math.inf
    stop: Stop = Stop.FINISHED
    n_nodes: int = 0
    is_cheapest: bool = False
    core: Core = field(init=False)

    def __post_init__(self) -> None:
        self.core = Core.of(self.inspection)

    @property
    def problem(self) -> Problem:
        return self.inspection.problem

    @property
    def n_counts(self) -> float:
        return float(self.inspection.counts.sum())

    def left(self, share: float = 1.0) -> Limits:
        seconds = share * max(0.0, self.limits.seconds - (time.perf_counter() - self.start))
        return replace(self.limits, seconds=seconds)

    def begin(self) -> None:
        """Take the single leaf and the tree that is best without acquisition; its bound holds with it too."""
        self.add(Leaf(int(self.problem.class_costs().argmin())))
        first = solve(self.problem, limits=self.left(0.3), seed=self.seed, n_jobs=self.n_jobs)
        # A tree without a split pays for nothing; every other one makes all samples read the root's sensor.
        first_reading = self.inspection.price * self.n_counts * self.core.least_reading + self.inspection.haste.sum()
        self.bound = min(self.trees[0][0], first.bound + float(first_reading))
        if first.tree is not None:
            self.add(first.tree)
        if first.stop is Stop.INTERRUPTED:
            self.limits, self.stop = replace(self.limits, seconds=0.0), Stop.INTERRUPTED

    def add(self, tree: Node) -> None:
        """Keep a tree that follows the rules, within the budget or not."""
        try:
            found = recount(replace(self.inspection, price=0.0, budget=None), tree)
        except CertificateError:
            return
        self.trees.append((found.objective, found.expected_cost * self.n_counts, tree))

    def best(self, price: float) -> tuple[float, float, Node]:
        return min(self.trees, key=lambda entry: (entry[0] + price * entry[1], entry[1]))

    def ask(self, price: float, cap: float | None = None, room: float | None = None) -> Answer:
        """Ask the core for a tree better than all known; what it finds is known from then on."""
        error, cost, _ = self.best(price)
        answer = self.core.search(price, error + price * cost if room is None else room, self.left(), cap=cap)
        self.n_nodes += answer.n_cuts
        if answer.tree is not None:
            self.add(answer.tree)
        if answer.stop != "optimal" and self.stop is Stop.FINISHED:
            self.stop = Stop(answer.stop)
        return answer

    def prove(self) -> None:
        self.bound = max(self.bound, 0.0)
        if self.inspection.budget is None:
            self.prove_price()
        else:
            self.prove_budget(self.inspection.budget)

    def prove_price(self) -> None:
        price = self.inspection.price
        if price > 0:
            answer = self.ask(price)
            self.bound, self.is_cheapest = max(self.bound, answer.bound), answer.stop == "optimal"
            return
        dearest = self.core.dearest_sum
        small = 2.0 ** math.floor(math.log2(self.unit / (2.0 * dearest))) if dearest > 0 else 0.0
        answer = self.ask(small)
        # No path costs more than the dearest, so small * cost is below one unit of error.
        self.bound = max(self.bound, self.rounded(answer.bound - small * dearest))
        self.is_cheapest = answer.stop == "optimal"

    def prove_budget(self, budget: float) -> None:
        cap = budget * self.n_counts * (1 + TOLERANCE) + TOLERANCE
        price = self.raise_bound(cap)
        best = self.best_within(cap)
        if self.bound < best[0] and self.stop is Stop.FINISHED:
            answer = self.ask(price, cap, best[0])
            self.bound = max(self.bound, answer.bound)

    def raise_bound(self, cap: float) -> float:
        """Return the multiplier of the best bound: the edge of the lower hull of (cost, error) that crosses the cap."""
        over, within = self.best(0.0), self.best_within(cap)
        best_price = 0.0
        while over[1] > cap and self.bound < self.best_within(cap)[0] and self.stop is Stop.FINISHED:
            price = (within[0] - over[0]) / (over[1] - within[1])
            answer = self.ask(price)
            # For a tree within the cap: error >= error + price * (cost - cap) >= bound - price * cap.
            bound = self.rounded(answer.bound - price * cap)
            if bound > self.bound or best_price == 0.0:
                self.bound, best_price = max(bound, self.bound), price
            found, line = self.best(price), within[0] + price * within[1]
            if found[0] + price * found[1] >= line - TOLERANCE * max(1.0, abs(line)):
                break  # nothing below the line between the two: they are neighbours on the hull
            within, over = (found, over) if found[1] <= cap else (within, found)
        return best_price

    def best_within(self, cap: float) -> tuple[float, float, Node]:
        return min((entry for entry in self.trees if entry[1] <= cap), key=lambda entry: entry[:2])

    def search(self) -> None:
        """Improve the known trees by exact subtrees; a budget is kept by trying multipliers."""
        budget = self.inspection.budget
        prices = [self.inspection.price] if budget is None else self._multipliers()
        for price in prices:
            for tree in [entry[2] for entry in self.trees]:
                self.add(descend(self.core, tree, price, self.left()))
            if self.left().seconds <= 0:
                self.stop = Stop.TIME if self.stop is Stop.FINISHED else self.stop
                return

    def _multipliers(self) -> list[float]:
        scale = max(self.problem.baseline, 1e-12) / max(self.core.dearest_sum, 1e-12)
        return [0.0, *(scale * 2.0**k for k in range(-6, 4))]

    @property
    def unit(self) -> float:
        """The least difference between two objectives without a price: 1 for whole numbers, else the tolerance."""
        is_whole = self.problem.has_integer_costs and (self.inspection.haste % 1 == 0).all()
        return 1.0 if is_whole else 1e-7 * max(1.0, self.problem.baseline)

    def rounded(self, bound: float) -> float:
        """Return a bound of the objective without a price, rounded up where objectives are whole."""
        return math.ceil(bound - 1e-6) if self.unit == 1.0 else bound

    def solution(self, solver: str) -> Solution:
        inspection = self.inspection
        if inspection.budget is None:
            tree = self.best(inspection.price)[2] if inspection.price > 0 else min(self.trees, key=lambda e: e[:2])[2]
        else:
            tree = self.best_within(inspection.budget * self.n_counts * (1 + TOLERANCE) + TOLERANCE)[2]
        found = recount(inspection, tree)
        tolerance = self.tolerance(found)
        bound = min(self.bound, found.objective)
        if bound >= found.objective - tolerance and self.stop is not Stop.INTERRUPTED:
            self.stop = Stop.OPTIMAL
        details = {
            "cheapest": "proven" if self.is_cheapest else "not proven",
            "expected_cost": found.expected_cost,
            "expected_readings": found.expected_readings,
        }
        seconds = time.perf_counter() - self.start
        return Solution(
            tree, found.objective, bound, self.stop, seconds, self.n_nodes, solver, "1", self.seed, tolerance, details
        )

    def tolerance(self, found: InspectionCertificate) -> float:
        if self.inspection.price == 0 and self.unit == 1.0:
            return 0.0
        if self.inspection.price == 0:
            return 1e-6 * max(1.0, self.problem.baseline)
        return TOLERANCE * max(1.0, found.objective)
