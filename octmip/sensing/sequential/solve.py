"""The best tree of a sequential problem: proven for shallow axis-aligned trees, searched for otherwise.

problem                   method (docs/theory/sensing.md)
price > 0                 branch and bound on error + price * cost
price 0, no budget        the same with a price too small to buy one error: the cheapest of the optimal trees
budget                    for every multiplier, min of error + multiplier * (cost - budget) is a bound; the best of
                          these bounds and the best tree within the budget; then branch and bound over fronts between
search                    exact subtrees of two levels, one after the other, in trees of every kind; the bound is that
                          of the problem without reading costs, and what the first reading costs
"""

import math
import time
from dataclasses import dataclass, field, replace
from typing import Literal

from octmip.errors import CertificateError, ProblemError
from octmip.sensing.sequential.descent import descend
from octmip.sensing.sequential.native import Core, CoreResult
from octmip.sensing.sequential.problem import SequentialCertificate, SequentialProblem, recount
from octmip.trees.problem import Problem
from octmip.trees.solution import Limits, Solution, Stop
from octmip.trees.solver import solve
from octmip.trees.tree import Leaf, Node

TOLERANCE = 1e-9
ROUNDING = 2.0**-46  # of the largest sum: what some hundred additions in float64 lose, and far more than they do


def solve_sequential(
    sequential: SequentialProblem,
    method: Literal["auto", "exact", "search"] = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    seed: int = 0,
    n_jobs: int = 1,
) -> Solution:
    """Return the best tree of a sequential problem and the bound proven for it.

    Parameters
    ----------
    sequential
        the problem, with what its readings cost.
    method
        "exact" proves (axis-aligned trees; to depth 2 in seconds, at depth 3 in minutes for thousands of samples; with
        a `leaf_size` much longer, as the strongest bound does not hold then: a `leaf_penalty` keeps it); "search" has
        the problem's own bound and the first reading's; "auto": exact to depth 3.
    limits
        seconds of the whole, nodes and gap of each search; to reach one is no error.
    seed, n_jobs
        of the solver of the problem without reading costs, where the search begins; the proof has one thread.

    Returns
    -------
    The solution; its objective is that of the sequential problem. `details["cheapest"]` says whether the tree is
    proven the cheapest in expectation among those of its objective.

    Raises
    ------
    ProblemError
        the method is unknown, or "exact" is asked for hyperplanes.
    """
    problem = sequential.problem
    if method not in ("auto", "exact", "search"):
        raise ProblemError(f"method is {method!r}; expected auto, exact or search; choose one")
    if method == "exact" and problem.split != "axis":
        raise ProblemError("the exact sequential search knows axis-aligned trees only; choose method 'search'")
    is_exact = method == "exact" or (method == "auto" and problem.split == "axis" and problem.depth <= 3)
    call = _Call(sequential, limits, seed, n_jobs)
    call.begin()
    try:
        call.prove() if is_exact else call.search()
    except KeyboardInterrupt:
        call.stop = Stop.INTERRUPTED
    return call.solution("sequential" if is_exact else "sequential search", is_proof=is_exact)


@dataclass(slots=True)
class _Call:
    """The state of one call of `solve_sequential`: known trees and bounds, which only grow."""

    sequential: SequentialProblem
    limits: Limits
    seed: int
    n_jobs: int
    start: float = field(default_factory=time.perf_counter)
    trees: list[tuple[float, float, Node]] = field(default_factory=list)  # error with delay cost, cost sum, tree
    bound: float = -math.inf
    stop: Stop = Stop.FINISHED
    n_nodes: int = 0
    is_cheapest: bool = False
    highest_price: float = 0.0
    core: Core = field(init=False)

    def __post_init__(self) -> None:
        self.core = Core.of(self.sequential)

    @property
    def problem(self) -> Problem:
        return self.sequential.problem

    @property
    def n_counts(self) -> float:
        return float(self.sequential.counts.sum())

    def left(self, share: float = 1.0) -> Limits:
        seconds = share * max(0.0, self.limits.seconds - (time.perf_counter() - self.start))
        return replace(self.limits, seconds=seconds)

    def begin(self) -> None:
        """Take the single leaf and the tree that is best when readings are free; that tree's bound holds here too."""
        self.add(Leaf(int(self.problem.class_costs().argmin())))
        first = solve(self.problem, limits=self.left(0.3), seed=self.seed, n_jobs=self.n_jobs)
        # A tree without a split pays for nothing; every other one makes all samples read the root's sensor.
        price = self.sequential.price
        first_reading = price * self.n_counts * self.core.least_reading + self.sequential.delay_costs.sum()
        self.bound = min(self.trees[0][0], first.bound + float(first_reading))
        if first_reading > 0:
            self.bound -= self.rounding(price)
        if first.tree is not None:
            self.add(first.tree)
        if first.stop is Stop.INTERRUPTED:
            self.limits, self.stop = replace(self.limits, seconds=0.0), Stop.INTERRUPTED

    def add(self, tree: Node) -> None:
        """Keep a tree that follows the rules, within the budget or not."""
        try:
            found = recount(replace(self.sequential, price=0.0, budget=None), tree)
        except CertificateError:
            return
        self.trees.append((found.objective, found.expected_cost * self.n_counts, tree))

    def best(self, price: float) -> tuple[float, float, Node]:
        return min(self.trees, key=lambda entry: (entry[0] + price * entry[1], entry[1]))

    def ask(self, price: float, cap: float | None = None, room: float | None = None) -> CoreResult:
        """Search for a tree better than all known; what is found is known from then on."""
        self.highest_price = max(self.highest_price, price)
        error, cost, _ = self.best(price)
        searched = self.core.search(price, error + price * cost if room is None else room, self.left(), cap=cap)
        self.n_nodes += searched.n_cuts
        if searched.tree is not None:
            self.add(searched.tree)
        if searched.stop != "optimal" and self.stop is Stop.FINISHED:
            self.stop = Stop(searched.stop)
        return searched

    def prove(self) -> None:
        self.bound = max(self.bound, 0.0)
        if self.sequential.budget is None:
            self.prove_price()
        else:
            self.prove_budget(self.sequential.budget)

    def prove_price(self) -> None:
        price = self.sequential.price
        if price > 0:
            searched = self.ask(price)
            self.bound = max(self.bound, searched.bound - self.rounding(price))
            self.is_cheapest = searched.stop == "optimal"
            return
        highest = self.core.highest_cost_sum
        tells_costs = self.unit > 4 * self.rounding(0.0)
        small = 2.0 ** math.floor(math.log2(self.unit / (2.0 * highest))) if highest > 0 and tells_costs else 0.0
        searched = self.ask(small)
        # No path costs more than the most expensive one, so small * cost is below one unit of error.
        self.bound = max(self.bound, self.rounded(searched.bound - small * highest, small))
        self.is_cheapest = searched.stop == "optimal" and (tells_costs or highest == 0)

    def prove_budget(self, budget: float) -> None:
        cap = budget * self.n_counts * (1 + TOLERANCE) + TOLERANCE
        price = self.raise_bound(cap)
        best = self.best_within(cap)
        if self.bound < best[0] and self.stop is Stop.FINISHED:
            searched = self.ask(price, cap, best[0])
            self.bound = max(self.bound, self.rounded(searched.bound, price))

    def raise_bound(self, cap: float) -> float:
        """Return the multiplier of the best bound: the edge of the lower hull of (cost, error) that crosses the cap."""
        over, within = self.best(0.0), self.best_within(cap)
        best_price = 0.0
        while over[1] > cap and self.bound < self.best_within(cap)[0] and self.stop is Stop.FINISHED:
            price = (within[0] - over[0]) / (over[1] - within[1])
            searched = self.ask(price)
            # For a tree within the cap: error >= error + price * (cost - cap) >= bound - price * cap.
            bound = self.rounded(searched.bound - price * cap, price)
            if bound > self.bound or best_price == 0.0:
                self.bound, best_price = max(bound, self.bound), price
            found, line = self.best(price), within[0] + price * within[1]
            if found[0] + price * found[1] >= line - max(TOLERANCE * abs(line), self.rounding(price)):
                break  # nothing below the line between the two: they are neighbours on the hull
            within, over = (found, over) if found[1] <= cap else (within, found)
        return best_price

    def best_within(self, cap: float) -> tuple[float, float, Node]:
        return min((entry for entry in self.trees if entry[1] <= cap), key=lambda entry: entry[:2])

    def search(self) -> None:
        """Improve the known trees by exact subtrees; a budget is kept by trying multipliers."""
        budget = self.sequential.budget
        prices = [self.sequential.price] if budget is None else self._multipliers()
        for price in prices:
            for tree in [entry[2] for entry in self.trees]:
                self.add(descend(self.core, tree, price, self.left()))
            if self.left().seconds <= 0:
                self.stop = Stop.TIME if self.stop is Stop.FINISHED else self.stop
                return

    def _multipliers(self) -> list[float]:
        scale = (self.problem.baseline or 1.0) / (self.core.highest_cost_sum or 1.0)
        return [0.0, *(scale * 2.0**k for k in range(-6, 4))]

    @property
    def unit(self) -> float:
        """The least difference between two objectives without a price.

        1 for whole numbers, else a quarter of what one sample can save, or a tenth of a millionth of the baseline.
        """
        return 1.0 if self.is_whole else min(1e-7 * self.problem.baseline, 0.25 * self.problem.least_saving) or 1.0

    @property
    def is_whole(self) -> bool:
        """Whether objectives without a price are whole, also after the rounding of sums."""
        is_whole = self.problem.has_integer_costs and (self.sequential.delay_costs % 1 == 0).all()
        return bool(is_whole) and self.rounding(0.0) < 1e-3

    def rounding(self, price: float) -> float:
        """Return the most that sums in float64 lose: the core adds and takes away costs of samples and readings."""
        budget = self.sequential.budget or 0.0
        cost = price * max(self.core.highest_cost_sum, budget * self.n_counts)
        delay = self.problem.depth * float(self.sequential.delay_costs.sum())
        return ROUNDING * (float(self.core.paid.max(axis=1).sum()) + delay + cost)

    def rounded(self, bound: float, price: float) -> float:
        """Return a bound of the objective without a price, rounded up where objectives are whole, else down."""
        down = bound - max(self.rounding(price), 1e-6 if self.is_whole else 0.0)
        return math.ceil(down) if self.is_whole else down

    def solution(self, solver: str, *, is_proof: bool) -> Solution:
        sequential = self.sequential
        if sequential.budget is None:
            tree = self.best(sequential.price)[2] if sequential.price > 0 else min(self.trees, key=lambda e: e[:2])[2]
        else:
            tree = self.best_within(sequential.budget * self.n_counts * (1 + TOLERANCE) + TOLERANCE)[2]
        found = recount(sequential, tree)
        tolerance = self.tolerance(found)
        bound = min(self.bound, found.objective)
        if bound >= found.objective - tolerance and self.stop is not Stop.INTERRUPTED:
            self.stop = Stop.OPTIMAL
        elif self.stop is Stop.FINISHED and is_proof:
            self.stop = Stop.NUMERICS
        details = {
            "cheapest": "proven" if self.is_cheapest else "not proven",
            "expected_cost": found.expected_cost,
            "expected_readings": found.expected_readings,
        }
        seconds = time.perf_counter() - self.start
        return Solution(
            tree, found.objective, bound, self.stop, seconds, self.n_nodes, solver, "1", self.seed, tolerance, details
        )

    def tolerance(self, found: SequentialCertificate) -> float:
        """Return the tolerance for rounding and the price that breaks ties; 0 where a sample is worth no more."""
        price = self.sequential.price
        if price == 0 and self.is_whole:
            return 0.0
        wide = 4 * self.rounding(self.highest_price) + (self.unit if price == 0 else 0.0)
        tolerance = max(wide, TOLERANCE * found.objective)
        least = self.problem.least_saving
        return next((width for width in (tolerance, wide) if width < least), 0.0)
