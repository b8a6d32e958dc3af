"""One door to every solver: an incumbent from search, a proof from exact or mip, a certificate before it is returned.

method    solver                                    starts from          bound from
cart      scikit-learn's CART                       nothing              none
search    local search                              itself               none
exact     branch and bound over thresholds          search from depth    exact
                                                    5 on; a search within
                                                    the proof, see `solve`
          hyperplanes of at most two features to    the best axis-       exact
          depth 3: boxes of lines                   aligned tree
oct       Bertsimas & Dunn's OCT, HiGHS             CART or search       HiGHS
oct_h     Bertsimas & Dunn's OCT-H, HiGHS           CART or search       HiGHS
flow      the strengthened formulation, HiGHS       CART or search       HiGHS
benders   Benders on HiGHS: axis-aligned trees      CART or search       HiGHS
all       where a tree has fewer leaves than there are classes, or splits have a price: what that costs any tree
auto      exact for axis-aligned trees where it knows all that is asked, else search; search for hyperplanes (whose
          proofs end in time for few features only)
"""

import logging
import math
import time
from collections.abc import Callable
from dataclasses import replace
from operator import itemgetter

from octmip.errors import CertificateError, ProblemError, SolverError
from octmip.trees.answer import interruption
from octmip.trees.answer.certificate import certify, checked_incumbent, checked_leaf_index
from octmip.trees.answer.solution import Limits, Progress, ProgressCallback, Solution, Stop
from octmip.trees.methods.checkpoint.entry import Entry, entry_of
from octmip.trees.methods.memory import within_process
from octmip.trees.methods.options import NO_OPTIONS, BendersOptions, ExactOptions, MipOptions, Options, SearchOptions
from octmip.trees.nodes.tree import Node
from octmip.trees.question.problem import Problem
from octmip.trees.regression.ordered import freed, in_order
from octmip.trees.runs.drawn_rows import setup_seconds, tree_of_drawn_rows
from octmip.trees.runs.registry import EXACT, SHAPED, TWO_FEATURE, Method, Run, chosen_method, pauses, solvers_of
from octmip.trees.runs.solver_call import Call, Pause, options_for, quiet, search_before_proof

LOG = logging.getLogger("octmip")  # silent unless its user gives it a level and a handler
MANY_SAMPLES = 10_000  # from so many on a proof of depth 4 begins with one restart: ct-magic has a tree in 0.7 CPU s
PROVEN_IN_ORDER, SHALLOWER = 3, "exact, less deep"  # depth to which proofs in order end within seconds


def solve(
    problem: Problem,
    method: Method = "auto",
    limits: Limits = Limits(),  # noqa: B008 (frozen)
    incumbent: Node | Solution | None = None,
    seed: int = 0,
    n_jobs: int = 1,
    progress: ProgressCallback | None = None,
    options: Options = NO_OPTIONS,
) -> Solution:
    """Return the best tree that a method finds within the limits, and the bound that it proves.

    Where no incumbent is given, an exact proof from depth 5 on (10,000 samples: 4) begins with a local search for at
    most a fifth of the time limit, under "auto" from depth 5 on until the search is done. Under "auto" it pauses for
    one as soon as its bound is a smaller share of the tree than the time spent is of the limit; under "exact" it does
    so after four fifths of the time.
    HiGHS begins with CART's tree (`MipOptions(start="search")`: one of local search). The better of incumbent and
    proof's own tree is returned; `details["tree_by"]` says who found it. Ctrl-C returns the best tree so far
    (`Stop.INTERRUPTED`). Where the time does not suffice to set up a proof of a large table, the tree is one of search,
    of drawn rows perhaps (`details["n_rows"]`), without a bound.

    Parameters
    ----------
    problem
        the problem; which methods answer it, `REGISTRY` says by its loss and split.
    method
        see the table of the module.
    limits
        wall seconds, relative gap, nodes, memory; reaching one is no error.
    incumbent
        a tree of this problem to start from.
    seed
        of all random choices.
    n_jobs
        threads; the tree is the same for any number, unless time runs out or HiGHS finds another as good.
    progress
        called now and then with the state of the solver.
    options
        what the method's own solver takes beyond all this, `SearchOptions(restarts=20)` for instance
        (`octmip.trees.methods.options`). ``cluster`` is other processes that do the work of the search and of exact
        axis-aligned proofs (`octmip.trees.methods.cluster`). ``checkpoint`` is the name of a file of what was found:
        the same question again goes on from it, and is answered from it once it is ended. Proofs of classes keep the
        state of their search there as they run, so that a killed one goes on; other methods what they end with. A study
        of many solves gives `Study(path)`. A bound that rests on the file says so (`details["resumed_from"]`, or
        `details["kept"]` where nothing was left to do).

    Raises
    ------
    ProblemError
        the method or an option is unknown, or the incumbent is no tree of this problem.
    SolverError
        the solver failed, or its solution fails its certificate.

    Examples
    --------
    >>> solve(Problem([[0], [1], [2]], ["a", "b", "a"], depth=2)).tree
    Split(0, 0.5, Leaf(0), Split(0, 1.5, Leaf(1), Leaf(0)))
    """
    return solve_run(problem, Run(method, limits, seed, n_jobs, options, progress), incumbent)


def solve_run(problem: Problem, run: Run, incumbent: Node | Solution | None = None) -> Solution:
    """Return what `solve` returns for the method, limits, seed, threads, options and progress of a run.

    Raises
    ------
    ProblemError, SolverError
        as `solve`.
    DataError
        the checkpoint cannot be read or written, or belongs to another question.
    """
    name = chosen_method(problem, run.method)
    run = replace(run, options=options_for(problem, name, run.options))
    if not isinstance(run.options.checkpoint, Entry | None):
        return _gone_on(problem, run, name, _known(problem, incumbent))
    run = replace(run, limits=within_process(run.limits))
    solvers_of(problem)[name].load()  # before the clock starts: its import is not the solver's time
    first = _known(problem, incumbent)
    _write_model(problem, name, run, first)
    if problem.has_sample_costs:
        return _by_weighted_rows(problem, run, first)
    if problem.shape.leaf_weight is not None and name != "cart":
        return _by_sized_rows(problem, run, first)
    start = time.perf_counter()

    def result() -> Solution:
        with run.options.opened(run.n_jobs) as options:
            return _result(Call(problem, replace(run, options=options), start), name, first)

    solution = until_interrupted(problem, result, name, None if first is None else first.tree)
    return checked_solution(problem, replace(solution, seconds=time.perf_counter() - start))


def _gone_on(problem: Problem, run: Run, name: str, first: Solution | None) -> Solution:
    """Return the solution of a checkpoint's entry, or make it from what is there and keep it."""
    method = run.method if name == "search" else name  # "auto" may search from a start of its own
    tree = None if first is None else first.tree
    entry = entry_of(problem, method, run.limits, run.seed, run.options, tree)
    known = entry.solution()
    if known is not None and not run.options.outputs and entry.is_ended(known, run.limits.gap, first):
        return known
    starts = [first, None if known is None or known.tree is None else _known(problem, known)]
    start = min(filter(None, starts), key=lambda start: start.objective, default=None)
    found = solve_run(problem, replace(run, options=replace(run.options, checkpoint=entry)), start)
    return entry.keep(found if known is None else found.with_bound(known.bound))


def until_interrupted(problem: Problem, solve: Callable[[], Solution], name: str, known: Node | None) -> Solution:
    """Return the solution of `solve`; once the call is interrupted, the tree that is known, or the best single leaf.

    Parameters
    ----------
    problem
        that is solved.
    solve
        does so; where the call was interrupted before, it is not called.
    name
        of the solver.
    known
        a tree of the problem.
    """
    with interruption.whole_call():
        if not interruption.is_heard():
            try:
                solution = solve()
            except KeyboardInterrupt:
                interruption.note()
            else:
                if solution.stop is Stop.INTERRUPTED:
                    interruption.note()
                return solution
        tree = problem.best_leaf() if known is None and problem.shape.is_leaf_allowed else known
        objective = math.inf if tree is None else problem.objective(tree)
        return Solution(tree, objective, -math.inf, Stop.INTERRUPTED, 0.0, 0, name, "1", 0)


def checked_solution(problem: Problem, solution: Solution) -> Solution:
    """Return a solver's solution once it is certified, or found no tree; a signal waits until then.

    Raises
    ------
    SolverError
        its certificate refutes it.
    """
    if solution.tree is None:
        return solution
    try:
        with interruption.held_back():  # what hours have found is not lost to a signal in these moments
            certify(problem, solution)
    except CertificateError as error:
        raise SolverError(f"{solution.solver} returned a solution that its certificate refutes: {error}") from error
    LOG.info("%r", solution)
    return solution


def _by_weighted_rows(problem: Problem, run: Run, first: Solution | None) -> Solution:
    """Return the solution of a problem with costs of single samples, found over weighted rows.

    Raises
    ------
    ProblemError
        a proof log is asked for, or `weighted_rows` refuses the problem.
    """
    from octmip.trees.encoding.costs import rounded_down
    from octmip.trees.encoding.sample_costs import weighted_rows

    options = run.options
    if isinstance(options, ExactOptions) and options.proof is not None:
        raise ProblemError("proof is given with costs of single samples, which no log knows; leave proof out")
    made = weighted_rows(problem)
    if made is None and not problem.shape.is_leaf_allowed:
        raise ProblemError(
            "every decision costs the same for all samples, so no part of a tree has a price; leave it out"
        )
    if made is None:
        leaf = problem.best_leaf()
        objective = problem.objective(leaf)
        bound = min(rounded_down(problem.exact_objective(leaf)), objective)
        return Solution(
            leaf, objective, bound, Stop.OPTIMAL, 0.0, 0, run.method, "no decision matters", 0, objective - bound
        )
    if isinstance(options, MipOptions):
        options = replace(options, write=None)  # it is written already, with the costs as they are
    # A relative gap of the rows is another one of the problem.
    run = replace(run, options=options, limits=replace(run.limits, gap=0.0), progress=made.progress(run.progress))
    return checked_solution(problem, made.back(solve_run(made.rows, run, None if first is None else first.tree)))


def _by_sized_rows(problem: Problem, run: Run, first: Solution | None) -> Solution:
    """Return the solution of a problem with a least weight of leaves, found over rows that are counted.

    Raises
    ------
    ProblemError
        a proof log is asked for.
    """
    from octmip.trees.encoding.repeated_rows import sized_rows, units_of

    options, start, bound = run.options, time.perf_counter(), -math.inf
    if isinstance(options, ExactOptions) and options.proof is not None:
        raise ProblemError("proof is given with leaf_weight, which no log knows; leave it out")
    run = replace(run, options=replace(options, checkpoint=None))  # the rows of each unit are another problem
    for unit in units_of(problem):
        seconds = max(0.0, run.limits.seconds - (time.perf_counter() - start))
        here = replace(run, limits=replace(run.limits, seconds=seconds))
        found = solve_run(sized_rows(problem, unit), here, None if first is None else first.tree)
        bound = max(bound, found.bound)  # each is one of the problem
        tree = None if found.tree is None else problem.with_sides(found.tree)
        if tree is None or _is_tree_of(problem, tree):
            break
    else:
        known = [] if first is None else [first.tree]
        found = _with_tree_of(problem, replace(found, bound=bound), known)
        tree = found.tree
    return checked_solution(problem, replace(found, tree=tree, seconds=time.perf_counter() - start))


def _is_tree_of(problem: Problem, tree: Node) -> bool:
    try:
        checked_leaf_index(problem, tree)
    except CertificateError:
        return False
    return True


def _with_tree_of(problem: Problem, found: Solution, known: list[Node | None]) -> Solution:
    """Return a solution with the best tree of the problem that is at hand, in place of one with too light a leaf."""
    if solvers_of(problem)["cart"].refusal(problem) is None:
        known = [*known, solve_run(problem, Run("cart", seed=found.seed)).tree]
    known = [*known, problem.best_leaf() if problem.shape.is_leaf_allowed else None]
    objective, tree = min(
        ((problem.objective(tree), tree) for tree in known if tree), default=(math.inf, None), key=itemgetter(0)
    )
    bound = min(found.bound, objective)
    stop = Stop.NUMERICS if found.stop is Stop.OPTIMAL and bound < objective - found.tolerance else found.stop
    return replace(found, tree=tree, objective=objective, bound=bound, stop=stop)


def _write_model(problem: Problem, name: str, run: Run, first: Solution | None) -> None:
    """Write the model of a problem where the options name a file for it: whole, whatever tree is known."""
    options = run.options
    if not isinstance(options, MipOptions) or options.write is None:
        return
    from octmip.trees.mip.model_rows import model_of

    model_of(problem, name, start=first, mu=options.mu, seed=run.seed, limits=run.limits).write(options.write)


def _wants_incumbent(problem: Problem, name: str, options: Options) -> bool:
    """Whether a local search comes first: it shortens a proof; HiGHS begins with CART's tree unless it is asked for."""
    solver = solvers_of(problem)[name]
    if isinstance(options, BendersOptions):
        return options.start == "search"
    is_long = solver is EXACT and problem.samples.n_samples >= MANY_SAMPLES
    is_deep = problem.shape.depth + is_long > solver.alone_to_depth
    return solver.proves and (is_deep or _starts_less_deep(problem, name))


def _result(call: Call, name: str, first: Solution | None) -> Solution:
    """Return the solution of a method that starts from `first`, or from a search where that helps."""
    free = freed(call.problem) if name == "search" and call.run.method == "auto" else None
    if free is not None:
        return in_order(call, free, first)
    setup, seconds = setup_seconds(call.problem, name, call.run.options), call.run.limits.seconds
    if first is None and seconds < 2 * setup:
        return tree_of_drawn_rows(call)
    is_given = first is not None
    if first is None and _wants_incumbent(call.problem, name, call.run.options):
        first = _first_tree(call, name, max(search_before_proof(call)[0], setup / seconds if setup else 0.0))
        if first.stop is Stop.INTERRUPTED:
            return first
    if first is not None and call.run.limits.remaining(call.start).seconds < setup:
        return replace(first, stop=Stop.TIME if first.stop is Stop.FINISHED else first.stop)
    pause = Pause(call, first) if not is_given and pauses(call.problem, name) else None
    proof = call if pause is None else replace(call, run=replace(call.run, progress=pause))
    solution = _solved(proof, name, first)
    if pause is not None:
        if not pause.n_searches and solution.stop in {Stop.TIME, Stop.MEMORY}:
            if first is None and call.run.limits.remaining(call.start).seconds < 2 * setup:
                pause.found = tree_of_drawn_rows(quiet(call))
            else:
                pause.search()
        first = pause.found
    if not solvers_of(call.problem)[name].proves:
        return solution
    solution = _with_better_tree(call.problem, solution, first)
    return replace(solution, details=dict(solution.details) | {"tree_by": _finder(solution, name, first)})


def _finder(solution: Solution, name: str, first: Solution | None) -> str:
    """Return who found a solution's tree: the method, unless it began with one as good."""
    if first is not None and first.objective <= solution.objective:
        return first.solver
    began = solution.details.get("start")
    return "cart" if isinstance(began, dict) and began["objective"] <= solution.objective else name


def _starts_less_deep(problem: Problem, name: str) -> bool:
    """Whether a proof starts from the best tree that is less deep: in order, local search often finds none as good."""
    is_in_order = solvers_of(problem)[name] is SHAPED and problem.shape.monotone is not None
    return is_in_order and problem.shape.depth > PROVEN_IN_ORDER


def _first_tree(call: Call, name: str, share: float) -> Solution:
    """Return the tree that a proof starts from: the best axis-aligned one for boxes of lines, else one of search."""
    if solvers_of(call.problem)[name] is TWO_FEATURE:
        # A few milliseconds; without it a proof that is stopped while it lays out its tables has next to nothing.
        axis = call.problem.replace(split="axis", split_size=None, integer_normals=None)
        return replace(call, problem=axis).solve("exact", None, share=share)
    if share < 1.0 and _starts_less_deep(call.problem, name):
        spent, progress = time.perf_counter() - call.start, call.run.progress

        def shown(state: Progress) -> None:  # the tree is one of the deeper problem's too, the bound is not
            if progress is not None:
                progress(replace(state, seconds=state.seconds + spent, bound=-math.inf))

        limits = replace(call.run.limits, seconds=max(0.0, (call.run.limits.seconds - spent) / 2))
        run = replace(call.run, limits=limits, progress=shown)
        less = Call(call.problem.replace(depth=call.problem.shape.depth - 1), run, time.perf_counter())
        return replace(_result(less, name, None), solver=SHALLOWER, bound=-math.inf)
    options = SearchOptions(cluster=call.run.options.cluster)
    if share < 1.0:  # a proof follows; where it has ended, all the time that is left is the search's
        options = replace(options, restarts=search_before_proof(call)[1])
    return call.solve("search", None, share=share, options=options)


def _solved(call: Call, name: str, first: Solution | None) -> Solution:
    """Return one solver's solution; a Ctrl-C that it did not see itself ends with the incumbent."""
    try:
        return call.solve(name, first.tree if first else None, options=call.run.options)
    except KeyboardInterrupt:
        if first is None:
            raise
        return replace(first, stop=Stop.INTERRUPTED)


def _known(problem: Problem, incumbent: Node | Solution | None) -> Solution | None:
    """Return the incumbent as a solution without a bound, once it is a tree of the problem."""
    tree = checked_incumbent(problem, incumbent)
    if tree is None:
        return None
    objective = problem.objective(tree)
    if math.isinf(objective):  # no float64: worse than any tree that a solver begins with
        return None
    return Solution(tree, objective, -math.inf, Stop.FINISHED, 0.0, 0, "incumbent", "1", 0)


def _with_better_tree(problem: Problem, solution: Solution, first: Solution | None) -> Solution:
    if first is None or first.objective >= solution.objective:
        return solution
    checked_solution(problem, solution)  # what an incumbent covers up would be a wrong claim all the same
    better = replace(solution, tree=first.tree, objective=first.objective)
    is_proven = better.meets_bound and better.stop is not Stop.INTERRUPTED
    return replace(better, stop=Stop.OPTIMAL) if is_proven else better
