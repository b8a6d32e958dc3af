"""The parts of a tree that a command line asks for: given splits, rules for paths, an old tree to stay near."""

import argparse
from collections.abc import Sequence
from typing import Any

from octmip.errors import ProblemError
from octmip.formats.columns import Columns
from octmip.formats.tree_file import old_tree_for, read_tree_file
from octmip.trees.question.parts import RULES, rules_of_columns


def parts_of(arguments: argparse.Namespace, columns: Columns) -> dict[str, Any]:
    """Return what a problem over the features of these columns takes of parts; nothing without these arguments.

    Raises
    ------
    ProblemError
        a word is no part.
    DataError, TreeError
        the old tree cannot be read, or reads other columns.
    """
    if not hasattr(arguments, "fix"):
        return {}
    old = (
        None if arguments.old_tree is None else old_tree_for(columns.feature_names, read_tree_file(arguments.old_tree))
    )
    return {
        "fixed_splits": fixed_splits_of(arguments.fix, "--fix", columns),
        "path_rules": rules_of_columns([_rule(word) for word in arguments.path_rule], columns.column_of_feature),
        "old_tree": old,
        "max_changes": arguments.max_changes,
    }


def fixed_splits_of(words: Sequence[str], option: str, columns: Columns | None) -> dict[str, str] | None:
    """Return the splits that words give, by address; None without words.

    A question for texts may be written as trees print it: c in {p, s}.

    Raises
    ------
    ProblemError
        a word is no NODE=SPLIT, or a node stands there twice.
    """
    feature_of: dict[str, str] = {}
    for column in () if columns is None else columns.columns:
        feature_of |= column.questions()
    found: dict[str, str] = {}
    for word in words:
        node, sign, split = word.partition("=")
        if not sign or not split or node in found:
            raise ProblemError(
                f"{option} is {word!r}; expected NODE=SPLIT, each node once, such as ROOT=g05 or L=g05<=3"
            )
        is_name = columns is not None and split in columns.feature_names
        found[node] = split if is_name else feature_of.get(split, split)
    return found or None


def _rule(word: str) -> tuple[str, ...]:
    kind, sign, names = word.partition("=")
    if not sign or kind not in RULES:
        raise ProblemError(f"--path-rule is {word!r}; expected {', '.join(RULES)}, then = and columns joined by commas")
    return kind, *names.split(",")
