"""Whether a tree has the parts that a Problem asks for, by their definitions alone."""

from collections.abc import Iterator, Sequence

from octmip.trees.nodes.tree import HyperplaneSplit, Leaf, Node, Split, n_splits
from octmip.trees.question.parts import GivenSplit, PathRule, address, banned_below


def places(tree: Node, path: str = "") -> Iterator[tuple[str, Node]]:
    """Yield every node and its path from the root, the root first."""
    yield path, tree
    if not isinstance(tree, Leaf):
        yield from places(tree.left, path + "L")
        yield from places(tree.right, path + "R")


def missing_part(tree: Node, given: Sequence[GivenSplit], names: Sequence[str]) -> str | None:
    """Return a sentence about the first given split that a tree lacks, None where it has all."""
    by_path = dict(places(tree))
    for part in given:
        node = by_path.get(part.path)
        if not part.features:
            if isinstance(node, Leaf | None):
                continue
        elif isinstance(node, Split) and node.feature in part.features and part.threshold in (None, node.threshold):
            continue
        return f"the tree has not {part.split_words(names)} at {address(part.path)}, which fixed_splits asks for"
    return None


def broken_rule(tree: Node, rules: Sequence[PathRule], names: Sequence[str]) -> str | None:
    """Return a sentence about the first split that a rule for paths forbids, None where there is none."""
    banned = banned_below(rules, len(names))

    def first(node: Node, above: tuple[int, ...]) -> str | None:
        if isinstance(node, Leaf):
            return None
        assert not isinstance(node, HyperplaneSplit)
        for feature in above:
            if node.feature in banned[feature]:
                return f"the tree splits {names[node.feature]} below {names[feature]}, which path_rules forbids"
        below = (*above, node.feature)
        return first(node.left, below) or first(node.right, below)

    return first(tree, ())


def n_changes(tree: Node, old: Node | None) -> int:
    """Return at how many places two trees differ: one has a split that the other has not, or another one.

    Splits are the same where feature, threshold and the side of missing readings are; a side that one of both does not
    say is no difference.
    """
    if old is None or isinstance(old, Leaf):
        return n_splits(tree)
    if isinstance(tree, Leaf):
        return n_splits(old)
    below = n_changes(tree.left, old.left) + n_changes(tree.right, old.right)
    return below + (not is_same_split(tree, old))


def is_same_split(split: Node, old: Node) -> bool:
    """Whether two nodes are the same split, whatever lies below."""
    if not isinstance(split, Split) or not isinstance(old, Split):
        return False
    is_missing = None in (split.missing, old.missing) or split.missing == old.missing
    return (split.feature, split.threshold) == (old.feature, old.threshold) and is_missing
