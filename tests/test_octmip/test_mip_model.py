"""A model in other hands: Pyomo's solvers and solvers that read files, and what comes back from them."""

import math

import highspy
import numpy as np
import pytest
import scipy.sparse as sp

import octmip
from benchmarks.cases.mio_random import by_pyomo, judged
from benchmarks.data import SHARED, first_rows, published, uci
from benchmarks.outside import BY_PYOMO, DUAL_TOLERANCE, PACKAGES, PROGRAMS, is_installed, solve_file
from octmip import ClassCosts, Leaf, Problem, Split, certify
from octmip.errors import ProblemError, SolverError
from octmip.trees.mip import rows_file
from octmip.trees.mip.blocks.heap import place
from octmip.trees.mip.model_rows import Answer, model_of
from octmip.trees.mip.pyomo_results import report_of
from tests.oracles.enumeration import optimum
from tests.oracles.strategies import hyperplane_problem, random_problem

pyo = pytest.importorskip("pyomo.environ")

METHODS = ("oct", "flow")


def small(seed: int = 0, **options: object) -> Problem:
    """Return a problem of 12 samples, two features of few values and two classes."""
    rng = np.random.default_rng(seed)
    features = rng.integers(0, 5, (12, 2)).astype(float)
    return Problem(features, (features.sum(axis=1) + rng.integers(0, 3, 12) > 5).astype(int), **{"depth": 1} | options)


def solved(model, solver: str = "appsi_highs"):
    return pyo.SolverFactory(solver).solve(model)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(4))
def test_two_interfaces_of_pyomo_give_the_certified_optimum(seed, method):
    problem = random_problem(np.random.default_rng(seed), max_samples=9, max_depth=2)
    for solver in ("appsi_highs", "highs"):
        model = octmip.model(problem, method)
        solution = octmip.solution_of(model, solved(model, solver))
        certify(problem, solution)
        best = optimum(problem).objective
        assert solution.bound <= best
        assert solution.objective <= best * (1 + 1e-4)  # the relative gap at which HiGHS ends by default
        assert solution.gap <= 5e-4
        assert solution.is_optimal or not problem.has_integer_costs


def test_a_model_starts_from_the_tree_that_is_given():
    tree = Split(1, 2.5, Leaf(0), Leaf(1))
    model = octmip.model(small(), "oct", start=tree)
    assert model.a[1, 1].value == 1
    assert model.a[0, 1].value == 0
    assert pyo.value(model.cost) == small().objective(tree)


def test_a_bound_is_lowered_by_what_tolerances_may_have_added():
    made = model_of(small(), "oct")
    values = made.start()
    objective = made.formulation.rows.objective(values)
    assert made.solution(Answer(values, objective + 1e-5)).bound == objective
    assert made.solution(Answer(values, objective - 0.5)).bound == objective
    assert made.solution(Answer(values, objective - 1.0)).bound == objective - 1
    assert made.solution(Answer(values, objective - 1 + 1e-4)).bound == objective - 1
    assert made.solution(Answer(values)).bound == 0


def test_values_that_break_a_row_are_refused_by_its_name():
    made = model_of(small(), "oct")
    values = made.start()
    values[made.formulation.d[0]] = 0
    with pytest.raises(SolverError, match="one_feature"):
        made.solution(Answer(values))


@pytest.mark.parametrize(
    ("problem", "method", "said"),
    [
        (small(), "benders", "expected one of oct, oct_h, flow"),
        (small(), "oct_h", "choose 'oct'"),
        (small(split="hyperplane"), "oct", "oct_h"),
        (Problem([[0.0], [1.0]], [0.0, 1.0], depth=1, loss=octmip.SquaredError()), "oct", "expected classes"),
        (Problem([[math.nan], [1.0]], [0, 1], depth=1, takes_missing=True), "oct", "1 reading is .*fill them in"),
    ],
)
def test_a_problem_without_a_model_is_refused(problem, method, said):
    with pytest.raises(ProblemError, match=said):
        octmip.model(problem, method)


def test_a_finer_dual_tolerance_lets_a_bound_on_decimal_weights_meet_the_tree():
    problem = random_problem(np.random.default_rng(90_020), max_samples=9, max_features=2)  # prices up to 744,997
    model = octmip.model(problem, "oct")
    results = BY_PYOMO["HiGHS"](model, 20.0)
    coarse = octmip.solution_of(model, results)
    assert coarse.bound < coarse.objective - coarse.tolerance
    assert octmip.solution_of(model, results, dual_tolerance=DUAL_TOLERANCE).is_optimal
    with pytest.raises(ProblemError, match="dual_tolerance is -1; expected"):
        octmip.solution_of(model, results, dual_tolerance=-1)


def test_a_model_of_another_hand_is_refused():
    with pytest.raises(ProblemError, match=r"octmip\.model"):
        octmip.solution_of(pyo.ConcreteModel())


def test_costs_that_are_no_whole_numbers_come_back_in_the_units_of_the_problem():
    problem = small(loss=ClassCosts([[0.0, 0.7], [0.3, 0.0]]), leaf_penalty=0.05)
    model = octmip.model(problem)
    solution = octmip.solution_of(model, solved(model))
    assert solution.objective == pytest.approx(optimum(problem).objective)
    assert solution.is_optimal


def test_a_written_start_is_a_solution(tmp_path):
    made = model_of(small(), "oct")
    made.write_start(tmp_path / "m.mst")
    first = (tmp_path / "m.mst").read_text().splitlines()[0]
    assert first == f"# octmip model oct, problem {made.problem.digest()}"
    assert made.read(tmp_path / "m.mst").objective == made.known.objective


@pytest.mark.long("HiGHS-mu1", "SCIP-mu1")
@pytest.mark.parametrize("table", ["iris", "mu1"])
@pytest.mark.parametrize("solver", PROGRAMS)
def test_solvers_outside_prove_published_tables_from_a_file_and_are_certified(solver, table, tmp_path):
    if not is_installed(solver):
        pytest.skip(f"{PACKAGES[solver]} is not installed")
    if not (SHARED / {"iris": "uci", "mu1": "uav"}[table]).is_dir():
        pytest.skip(f"{SHARED} does not hold the table beside the project")
    samples, least = (uci("iris"), 50) if table == "iris" else (first_rows(published("mu1", 0), 175), 103)
    # Of mu1 three gauges: with all twenty SCIP takes more than a minute.
    problem = Problem(samples.features[:, ::7] if table == "mu1" else samples.features, samples.labels, depth=1)
    made = model_of(problem, "flow")
    made.write(tmp_path / "m.lp")
    bound = solve_file(solver, tmp_path / "m.lp", tmp_path / "m.sol", seconds=300)
    solution = made.read(tmp_path / "m.sol", bound, solver)
    assert certify(problem, solution).objective == least
    assert solution.is_optimal


@pytest.mark.parametrize("seed", [90_500, 90_501])
def test_six_programs_have_one_optimum(seed):
    problem = random_problem(np.random.default_rng(seed), max_samples=9, max_features=2)
    by_others, refused = by_pyomo(problem, 60.0)
    line = judged(problem, {name: octmip.solve(problem, name) for name in ("exact", "benders", "oct")} | by_others)
    assert (line["other"], line["too_high"], refused) == ([], [], {})


def test_a_false_bound_of_a_solver_is_refused_by_a_tree_that_it_denies():
    # SCIP 10.0 presolves OCT's model of this problem to an optimum of 2, a split; a leaf costs 1.
    problem = Problem([[2.0, 1.0], [-1.0, 2.0]], [1, 0], depth=2, leaf_penalty=2)
    made = model_of(problem, "oct")
    tree = Split(0, 0.5, Leaf(0), Leaf(1))
    split = made.formulation.start(place(tree, made.formulation.heap, problem.samples.features))
    assert made.known.objective == 1
    with pytest.raises(SolverError, match="no tree is below 2 but one of the model costs 1"):
        made.solution(Answer(split, 2.0, "SCIP"))


@pytest.mark.parametrize("suffix", [".lp", ".mps"])
@pytest.mark.parametrize("method", [*METHODS, "oct_h"])
def test_a_model_is_read_by_others_as_it_is_and_has_no_empty_row(method, suffix, tmp_path):
    draw = hyperplane_problem if method == "oct_h" else random_problem
    for seed in range(6):  # the last hyperplanes have coefficients beyond 0 and 1
        rows = model_of(draw(np.random.default_rng(seed), max_samples=6, max_features=2), method).formulation.rows
        rows_file.write_rows(rows, tmp_path / f"m{suffix}", "a model")
        highs = highspy.Highs()
        highs.silent()
        assert highs.readModel(str(tmp_path / f"m{suffix}")) == highspy.HighsStatus.kOk
        found = highs.getLp()
        place = [found.col_names_.index(name) for name in rows_file.names(rows)]
        constant = set(range(found.num_col_)) - set(place)
        assert [found.col_cost_[j] * found.col_lower_[j] for j in constant] == [rows.offset] * bool(rows.offset)
        columns = np.array([found.col_cost_, found.col_lower_, found.col_upper_])[:, place]
        assert columns == pytest.approx(np.array([rows.cost, rows.lower, rows.upper]), rel=1e-15)
        assert [found.integrality_[j] == highspy.HighsVarType.kInteger for j in place] == rows.is_integer.tolist()
        assert (found.row_lower_, found.row_upper_) == tuple(ends.tolist() for ends in rows.row_bounds)
        matrix = sp.csc_array((found.a_matrix_.value_, found.a_matrix_.index_, found.a_matrix_.start_))[:, place]
        assert abs(matrix - rows.matrix()).max() < 1e-12 * abs(matrix).max()
        assert np.diff(rows.matrix().indptr).all()


def test_highs_begins_with_carts_tree_unless_a_search_is_asked_for():
    problem = small(1, depth=2)
    cart = octmip.solve(problem, "cart").objective
    for method in ("oct", "flow", "benders"):
        kind = octmip.MipOptions if method != "benders" else octmip.BendersOptions
        first = octmip.solve(problem, method, octmip.Limits(seconds=0.0))
        assert (first.objective, first.details["tree_by"]) == (cart, "cart")
        searched = octmip.solve(problem, method, options=kind(start="search"))
        assert searched.objective <= cart
        assert searched.details["tree_by"] == "search"


def test_highs_takes_its_own_options_and_writes_its_own_log(tmp_path):
    log = tmp_path / "highs.log"
    options = octmip.MipOptions(log=log, highs={"presolve": "off"})
    assert octmip.solve(small(), "oct", options=options).is_optimal
    assert "MIP start" in log.read_text()
    assert "Presolve is switched off" in log.read_text()


@pytest.mark.parametrize(("highs", "error"), [({"threads": 3}, ProblemError), ({"nonsense": 1}, SolverError)])
def test_options_that_highs_does_not_have_or_octmip_sets_are_refused(highs, error):
    with pytest.raises(error, match=next(iter(highs))):
        octmip.solve(small(), "oct", options=octmip.MipOptions(highs=highs))


def test_a_variable_that_is_freed_and_results_without_a_name_are_taken():
    model = octmip.model(small(), "oct")
    results = solved(model)
    for variable in model.component_data_objects(pyo.Var):
        variable.setlb(None)
        variable.setub(None)
    assert octmip.solution_of(model, results).is_optimal
    assert report_of(None).solver == "another solver"
