"""Reports of trees whose every feature and class has a hostile name, read by the machines that show them.

Outcomes are those of export_runs.py; a report is exact when nothing ran and every name can be read in it.
"""

import io
import json
import re
import unicodedata
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from octmip.formats.tree_file import TreeFile
from octmip.formats.tree_schema import SETTINGS
from octmip.input.names import END_ISOLATE, ISOLATE, shown
from octmip.interfaces.plot.drawing import counted_tree_figure
from octmip.interfaces.report.html import tree_page
from octmip.interfaces.report.markdown import code_block, markdown_table
from octmip.interfaces.report.text import tree_text
from octmip.interfaces.report.tree.words import Wording
from octmip.trees.answer.solution import Solution, Stop
from octmip.trees.nodes.tree import Leaf, Node, Split
from octmip.trees.nodes.tree_nodes import decode_tree, encode_tree
from tests.oracles.export_runs import EXACT

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Dialog

ALLOWED = {ISOLATE, END_ISOLATE, "\n"}


def tree_over(count: int) -> Node:
    """Return a tree that reads features 0 to `count` - 1 and answers classes 0 to `count`, each once."""
    nodes: list[Node] = [Leaf(k) for k in range(count + 1)]
    feature = 0
    while len(nodes) > 1:
        pairs = list(zip(nodes[::2], nodes[1::2], strict=False))
        rest = nodes[2 * len(pairs) :]
        nodes = [Split(feature + k, 0.5, left, right) for k, (left, right) in enumerate(pairs)] + rest
        feature += len(pairs)
    return nodes[0]


def tree_file(names: Sequence[str]) -> TreeFile:
    """Return a tree file whose features and classes bear these names, and its label column the first."""
    tree, classes = tree_over(len(names)), (*names, "plain")
    solution = Solution(tree, 0.0, 0.0, Stop.OPTIMAL, 0.0, 1, "by hand", "1", 0, details={"scope": names[0]})
    counts = np.eye(len(classes), dtype=np.int64)
    asked = {"depth": 6, "split": "axis", "leaf_size": 1, "leaf_penalty": 0.0, "sensor_budget": 1.0}
    costs = (1.0 - np.eye(len(classes))).tolist()
    loss = {"name": "classes", "costs": costs}
    settings = dict.fromkeys(SETTINGS) | asked | {"loss": loss, "sensor_of_feature": list(names)}
    return TreeFile(solution, tuple(names), classes, settings, "0" * 64, len(classes), names[0], names[-1], counts)


def run_text(names: Sequence[str]) -> list[str]:
    """Read the words as a terminal would: one line per node, and no character that acts."""
    text = tree_text(tree_over(len(names)), names, (*names, "plain"))
    is_still = all(c in ALLOWED or (c.isprintable() and unicodedata.category(c) != "Cf") for c in text)
    if not is_still or len(text.split("\n")) != len(text.splitlines()) or len(text.splitlines()) != 3 * len(names) + 1:
        return ["a character acts"] * len(names)
    lines = [line.strip(" ") for line in text.split("\n")]
    return [
        EXACT if f"if {shown(name)} <= 0.5" in lines and shown(name) in lines else "not to be read" for name in names
    ]


def run_json(names: Sequence[str]) -> list[str]:
    """Read the nested objects of a tree back."""
    tree, classes = tree_over(len(names)), (*names, "plain")
    text = json.dumps(encode_tree(tree, tuple(names), classes), allow_nan=False)
    is_same = text.isascii() and decode_tree(json.loads(text), tuple(names), classes) == tree
    return [EXACT if is_same else "another tree"] * len(names)


def run_markdown(names: Sequence[str]) -> list[str]:
    """Read the table and the block of code by the rules of GitHub's Markdown that concern them."""
    lines = markdown_table([{"name": name, "other": 1} for name in names]).split("\n")
    tree = tree_text(tree_over(len(names)), names, (*names, "plain"))
    fence, *inside, end = code_block(tree).split("\n")
    is_closed = end == fence and not any(line.strip().startswith(fence) for line in inside)
    is_closed = is_closed and len(lines) == 2 + len(names)
    return [
        EXACT if is_closed and _cells(line) == 2 and not _is_active(line) else "acts in Markdown" for line in lines[2:]
    ]


def _cells(line: str) -> int:
    return len(re.sub(r"\\.", "", line).split("|")) - 2


def _is_active(line: str) -> bool:
    bare = re.sub(r"\\[!-/:-@\[-`{-~]", "", line.strip("| "))
    return bool(re.search(r"[`*\[\]~$]|<[A-Za-z/!?]|&(?!lt;|amp;)[#A-Za-z]|[a-z]://|\bwww\.", bare))


def run_picture(names: Sequence[str]) -> list[str]:
    """Draw the tree as PNG, every warning an error."""
    file = tree_file(names)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            figure = counted_tree_figure(file.tree, Wording(file.feature_names, file.class_names), file.leaf_counts)
            buffer = io.BytesIO()
            figure.savefig(buffer, format="png", dpi=40)
    except (Warning, ValueError, RuntimeError) as error:
        return [f"{type(error).__name__}: {error}"] * len(names)
    return [EXACT if Image.open(buffer).width > 100 else "empty"] * len(names)


def run_page(names: Sequence[str], browser: "Browser", folder: Path) -> list[str]:
    """Open the page of a tree in a browser, without the policy that would stop a script anyway."""
    path = folder / "tree.html"
    text = tree_page(tree_file(names), names[0])
    without_policy = re.sub('<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    assert without_policy != text
    path.write_text(without_policy)
    page = browser.new_page()
    said: list[str] = []

    def dismiss(dialog: "Dialog") -> None:
        said.append(f"dialog {dialog.message}")
        dialog.dismiss()

    page.on("dialog", dismiss)
    page.on("console", lambda message: said.append(f"console {message.text}"))
    page.on("pageerror", lambda error: said.append(f"error {error}"))
    page.on("request", lambda request: said.append(f"request {request.url}"))
    page.goto(path.as_uri())
    state, words = page.evaluate("[typeof window.__pwned, document.querySelector('pre').textContent]")
    page.close()
    said = [line for line in said if line != f"request {path.as_uri()}"]
    if said or state != "undefined":
        return [f"ran: {said[:1]} {state}"] * len(names)
    lines = {line.strip(" ") for line in words.split("\n")}
    return [
        EXACT if f"if {shown(name)} <= 0.5" in lines and f"{shown(name)}    (1 sample)" in lines else "not to be read"
        for name in names
    ]


REPORTS: dict[str, Callable[[Sequence[str]], list[str]]] = {
    "text": run_text,
    "JSON": run_json,
    "Markdown": run_markdown,
    "PNG": run_picture,
}
