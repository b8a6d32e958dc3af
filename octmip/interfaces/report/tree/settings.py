"""What the tree reads, what errors cost, and how it was made, as rows of tables."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from octmip.formats.tree_file import TreeFile
from octmip.input.names import shown
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.measure import Measure
from octmip.interfaces.report.tree.words import Wording, counted, figure, listed, percent, short_name
from octmip.trees.answer.solution import Stop
from octmip.trees.nodes.tree import ValueLeaf, leaves, splits

STOPS = {
    Stop.OPTIMAL: "the proof was complete",
    Stop.FINISHED: "the method had finished",
    Stop.GAP: "the gap asked for was reached",
    Stop.TIME: "the time was over",
    Stop.NODES: "the number of search nodes was reached",
    Stop.MEMORY: "the memory was full",
    Stop.NUMERICS: "arithmetic allowed no further proof",
    Stop.INTERRUPTED: "it was interrupted",
}


def reads(file: TreeFile, wording: Wording) -> dict[str, Any]:
    """Return the columns that the tree reads, with the sensors they come from where that matters."""
    read = [*splits(file.tree), *(leaf for leaf in leaves(file.tree) if isinstance(leaf, ValueLeaf))]
    asked = Counter(wording.feature(j).column for node in read for j in node.features)
    readers = "splits and leaves that read it" if file.settings.get("leaf_model") == "linear" else "splits that read it"
    if not asked:
        return {"sentence": "The tree asks nothing: one answer for every sample.", "rows": []}
    sensor_of = dict(
        zip(
            (wording.feature(j).column for j in range(len(file.feature_names))),
            file.settings["sensor_of_feature"],
            strict=True,
        )
    )
    cost = file.settings["sensor_cost"] or {}
    has_sensors = any(sensor_of[column] != column for column in asked) or any(value != 1 for value in cost.values())
    total = sum(cost.get(sensor, 1.0) for sensor in {sensor_of[column] for column in asked})
    budget = file.settings["sensor_budget"]
    of = len({wording.feature(j).column for j in range(len(file.feature_names))})
    sentence = f"The tree reads {len(asked):,} of {counted(of, 'column')}{_at(file)}."
    if has_sensors or budget is not None:
        limit = f", of a budget of {figure(budget)}" if budget is not None else ""
        sentence += f" Their sensors cost {figure(total)}{limit}; each is paid once, however often the tree reads it."
    if not has_sensors:
        rows = [[short_name(column), times] for column, times in asked.most_common()]
        return {"sentence": sentence, "head": ["column", readers], "rows": rows, "right": (1,)}
    rows = [
        [shown(c), times, shown(sensor_of[c]), figure(cost.get(sensor_of[c], 1.0))] for c, times in asked.most_common()
    ]
    head = ["column", readers, "sensor", "its cost"]
    return {"sentence": sentence, "head": head, "rows": rows, "right": (1, 3)}


def _at(file: TreeFile) -> str:
    """Return the loads at which the readings are taken, in words; "" where none is known."""
    loads = listed([f"{short_name(name)} {figure(value)}" for name, value in file.readings.loads.items()], 5)
    return f", measured at {loads} and given as they are" if loads else ""


def risk(file: TreeFile, measure: Measure, evidence: Evidence | None) -> dict[str, Any]:
    """Return how errors are weighed, where that is not all alike."""
    sentences = []
    if file.weights_column:
        sentences.append(
            f"Every sample counts by its risk weight, column {short_name(file.weights_column)}{_range(evidence)}."
        )
    if file.class_weight is not None:
        pairs = zip(file.class_names, file.class_weight, strict=True)
        sentences.append(
            f"Samples of a class count by its weight: {', '.join(f'{shown(c)} {figure(w)}' for c, w in pairs)}."
        )
    if file.settings["leaf_penalty"]:
        sentences.append(f"Each feature in a split is charged {figure(file.settings['leaf_penalty'])}.")
    found = measure.risk()
    return {**found, "sentences": [*sentences, *found["sentences"]]}


def _range(evidence: Evidence | None) -> str:
    if evidence is None:
        return ""
    weights = evidence.problem.samples.weights
    return f", from {figure(float(weights.min()))} to {figure(float(weights.max()))}"


def settings_rows(file: TreeFile, measure: Measure) -> list[list[str]]:
    """Return the settings that were asked for, and how the solver fared."""
    asked, solution = file.settings, file.solution
    kinds = {"axis": "one feature in each split", "hyperplane": "weighted sums of features"}
    rows: list[tuple[str, str | None]] = [
        ("depth", "any" if asked["depth"] is None else f"at most {asked['depth']}"),
        ("kind of split", kinds[asked["split"]]),
        ("features in one split", _at_most(asked["split_size"]) if asked["split"] == "hyperplane" else None),
        ("samples in a leaf", f"at least {asked['leaf_size']:,}"),
        ("weight in a leaf", f"at least {figure(asked['leaf_weight'])}" if asked["leaf_weight"] else None),
        ("price of a feature in a split", figure(asked["leaf_penalty"]) if asked["leaf_penalty"] else "none"),
        ("splits in the tree", _at_most(asked["max_splits"]) if asked["max_splits"] is not None else None),
        ("monotone", _order(asked["monotone"], file.feature_names) if asked["monotone"] else None),
        (
            "order of classes",
            " < ".join(map(shown, file.class_names)) if asked["monotone"] and file.class_names else None,
        ),
        ("given splits", _given(asked["fixed_splits"])),
        ("rules for paths", _rules(asked["path_rules"])),
        (
            "splits that differ from the old tree's",
            None if asked["old_tree"] is None else _at_most(asked["max_changes"]),
        ),
        ("sensor budget", None if asked["sensor_budget"] is None else figure(asked["sensor_budget"])),
        ("features that may meet", _groups(asked["allowed_splits"])),
        ("coefficients", _integers(asked["integer_normals"])),
        *measure.settings(),
        ("column of the weights", short_name(file.weights_column) if file.weights_column else None),
        ("objective", figure(solution.objective)),
        ("bound", figure(solution.bound)),
        ("gap", percent(solution.gap)),
        ("bound holds for", short_name(scope) if (scope := solution.scope) else None),
        ("solver", f"{shown(solution.solver)}, version {shown(solution.version)}, seed {solution.seed}"),
        ("ended because", STOPS[solution.stop]),
        ("time", f"{figure(solution.seconds, 3)} s"),
        ("search nodes", f"{solution.n_nodes:,}"),
    ]
    return [[name, value] for name, value in rows if value is not None]


def _at_most(value: int | None) -> str:
    return "no limit" if value is None else f"at most {value:,}"


def _groups(groups: Any) -> str | None:
    return None if groups is None else counted(len(groups), "group")


def _integers(most: int | None) -> str | None:
    return None if most is None else f"whole numbers up to {most:,}"


def _given(splits: Mapping[str, str] | None) -> str | None:
    return None if splits is None else "; ".join(f"{place}: {shown(split)}" for place, split in splits.items())


def _rules(rules: Sequence[Sequence[str]] | None) -> str | None:
    """Return which features may not follow each other on a path."""
    if rules is None:
        return None
    names = [[shown(name) for name in names] for _, *names in rules]
    words: dict[str, Callable[[list[str]], str]] = {
        "not-below": lambda names: f"{names[0]} never below {', '.join(names[1:])}",
        "apart": lambda names: f"{', '.join(names)} not on one path",
        "root-only": lambda names: f"{', '.join(names)} at the root only",
    }
    return "; ".join(words[kind](of_rule) for (kind, *_), of_rule in zip(rules, names, strict=True))


def _order(signs: Sequence[str], names: Sequence[str]) -> str:
    """Return along which features the prediction never falls or never rises."""
    ways = {"+": "never falls as it rises", "-": "never rises as it rises"}
    pairs = zip(names, signs, strict=True)
    return "; ".join(f"{shown(name)}: {ways[sign]}" for name, sign in pairs if sign in ways)
