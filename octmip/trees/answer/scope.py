"""Over which trees a bound speaks, said whole: the trees of the problem with all their limits, or fewer of them."""

from octmip.trees.answer.solution import Solution
from octmip.trees.question.problem import Problem
from octmip.trees.question.shape import AnyDepth


def limits_in_words(problem: Problem, depth: int | None = None) -> str:
    """Return what the trees of a problem are limited by, in words that follow "trees "; `depth` if less than asked.

    Example: "of depth 2 or less, with 5 samples or more in each leaf".
    """
    shape = problem.shape
    depth = shape.depth if depth is None else depth
    most = shape.max_splits if isinstance(shape.depth, AnyDepth) else shape.limited_splits
    number = f"up to {shape.max_split_size} features in a split"
    counted = f"{'split' if shape.split == 'axis' else 'feature'}{'' if most == 1 else 's'}"
    counted += "" if shape.split == "axis" else " in all splits"
    leaf = {"constant": "one number in each leaf", "linear": "a linear model in each leaf"}[shape.leaf_model]
    words = {
        f"with {number}": shape.split == "hyperplane",
        f"with whole coefficients up to {shape.integer_normals}": shape.integer_normals is not None,
        "with splits of the allowed groups of features": shape.allowed_splits is not None,
        f"with {leaf}": problem.loss.predicts == "number",
        f"with {shape.leaf_size:,} samples or more in each leaf": shape.leaf_size > 1,
        f"with a weight of {shape.leaf_weight or 0:g} or more in each leaf": shape.leaf_weight is not None,
        f"with at most {most} {counted}": most is not None,
        f"with sensors that cost {shape.sensor_budget or 0:g} or less": shape.sensor_budget is not None,
        "in the order asked for": shape.monotone is not None,
        "with the given splits": shape.fixed_splits is not None,
        "within the rules of paths": shape.path_rules is not None,
        f"with at most {shape.max_changes} change{'' if shape.max_changes == 1 else 's'} of the old tree": (
            shape.max_changes is not None
        ),
    }
    return ", ".join([depth_in_words(depth), *(said for said, holds in words.items() if holds)])


def depth_in_words(depth: int | None) -> str:
    """Return a limit of depth (None: any) in words that follow "trees "."""
    return "of any depth" if depth is None or isinstance(depth, AnyDepth) else f"of depth {depth} or less"


def within(problem: Problem, trees: str) -> str:
    """Return some trees (plural, in words) with the limits that the problem puts on all of them.

    What a solver puts into `details["scope"]`; words that begin with "all" leave out no tree of the problem.
    """
    return f"{trees}, {limits_in_words(problem)}"


def scope_of(problem: Problem, solution: Solution) -> str:
    """Return the trees that no bound of a solution says more about than these."""
    return solution.scope or f"trees {limits_in_words(problem)}"
