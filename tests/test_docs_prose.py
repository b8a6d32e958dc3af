"""Prose of the docs, as far as patterns can tell: leading zeros, short lines, short pages, no actor that is a thing."""

import ast
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGES = {str(page.relative_to(ROOT)): page for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]}

LONGEST_LINE = 120
MOST_WORDS, MOST_WORDS_IN_ALL = 2500, 70_000
"""Words of a page, and of all pages together; a mark without a letter is no word."""

NO_ZERO = re.compile(r"(?<![\w.\])`*/])\.\d")
BANNED = re.compile(
    r"\b(?:gets? told|is told|are told|was told|looked into|a lot of|in order to|it should be noted|accuses?|of old)\b"
)
"""Phrases that name no subject, or make a person of a thing."""


@cache
def prose_of(text: str) -> list[tuple[int, str]]:
    """Return number and text of the lines of a page outside code and formulas on lines of their own."""
    lines, fence = [], ""
    for number, line in enumerate(text.splitlines(), 1):
        mark = re.match(r"\s*(`{3,}|\$\$)", line)
        if fence:
            fence = "" if mark and mark[1] == fence else fence
        elif mark:
            closes = mark[1] == "$$" and line.strip().endswith("$$") and len(line.strip()) > len("$$")
            fence = "" if closes else mark[1]
        elif not line.startswith("    "):
            lines.append((number, line))
    return lines


def bare_decimals(text: str) -> list[str]:
    """Return the lines with a decimal without a leading zero, outside code."""
    plain = ((number, re.sub(r"`[^`]*`|\([^()\s]*\)", "", line)) for number, line in prose_of(text))
    return [f"{number}: {line}" for number, line in plain if NO_ZERO.search(line)]


def long_lines(text: str) -> list[str]:
    """Return the lines over 120 columns, outside code and tables; an address cannot be broken and counts nothing."""
    lines = ((number, line) for number, line in prose_of(text) if not line.startswith(("|", "!")))
    return [f"{number}: {line}" for number, line in lines if len(re.sub(r"\]\([^)]*\)", "]()", line)) > LONGEST_LINE]


def too_many_words(text: str) -> list[str]:
    """Return the number of words, as a sentence, where it is over the limit."""
    n_words = words_in(text)
    return [f"{n_words} words; expected {MOST_WORDS} at most"] if n_words > MOST_WORDS else []


def words_in(text: str) -> int:
    """Return the number of words of a text."""
    return sum(bool(re.search(r"\w", word)) for word in text.split())


def banned_phrases(text: str) -> list[str]:
    """Return the lines with a phrase that a native engineer would not write."""
    return [f"{number}: {line}" for number, line in prose_of(text) if BANNED.search(line)]


@cache
def sentences(text: str) -> list[str]:
    """Return the sentences of a page without headings and tables, code in them as one word."""
    parts = []
    for _, line in prose_of(text):
        line = re.sub(r"`[^`]*`", "CODE", line.strip())
        parts += [""] if line.startswith(("|", "#", ":")) else [""] * bool(re.match(r"(?:[*-]|\d+\.)\s", line)) + [line]
    paragraphs = "\n".join(parts).split("\n\n")
    return [one for text in paragraphs for one in re.split(r"(?<=[.?!:])\s+", " ".join(text.split()))]


WHAT = re.compile(r"\b(?:until|plus|less|beside|besides) what\b|; what\b|^(?:\* )?What\b[^?]*\.$")
PASSIVE = re.compile(
    r"\b(?:is|are|was|were|been) (?:asked|said|told|believed|thought|owed|looked (?:at|for|into))\b(?! for)"
)
CHAIN = re.compile(r"(?:[^;]*\d[^;]*;){2,}[^;]*\d")


def what_clauses(text: str) -> list[str]:
    """Return the sentences in which a clause with `what` stands for a noun, as "what remains is cut"."""
    return [one for one in sentences(text) if WHAT.search(one)]


def passives(text: str) -> list[str]:
    """Return the sentences in which nobody asks, says or looks."""
    return [one for one in sentences(text) if PASSIVE.search(one)]


def figure_chains(text: str) -> list[str]:
    """Return the sentences that hold three figures or more between semicolons."""
    return [one for one in sentences(text) if CHAIN.search(one)]


Rule = Callable[[str], list[str]]
RULES = (bare_decimals, long_lines, too_many_words, banned_phrases, what_clauses, passives, figure_chains)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
@pytest.mark.parametrize("page", PAGES)
def test_a_page_keeps_the_rules_of_prose(page: str, rule: Rule) -> None:
    found = rule(PAGES[page].read_text())
    assert not found, f"{page}: " + "\n".join(found)


def sentences_of_code(tree: ast.Module) -> Iterator[str]:
    """Yield the texts of a module that have four words or more, docstrings apart; a value in one is X."""
    nodes = list(ast.walk(tree))
    values = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    documents = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    for node in nodes:
        if isinstance(node, ast.JoinedStr):
            text = "".join(str(part.value) if isinstance(part, ast.Constant) else "X" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in values | documents:
            text = node.value
        else:
            continue
        if len(text.split()) >= 4:
            yield text


@pytest.mark.parametrize("package", ["octmip", "femlib"])
def test_the_sentences_of_the_program_keep_the_rules_too(package: str) -> None:
    found = [
        f"{file.relative_to(ROOT)}: {text}"
        for file in sorted((ROOT / package).rglob("*.py"))
        for text in sentences_of_code(ast.parse(file.read_text()))
        if BANNED.search(text) or PASSIVE.search(text) or re.search(r"; what\b", text)
    ]
    assert not found, "\n".join(found)


def test_a_sentence_of_the_program_is_found_with_its_values_and_a_docstring_is_not() -> None:
    code = 'def f(x):\n    """It was asked by nobody."""\n    raise ValueError(f"it was asked {x} times; no more")\n'
    assert list(sentences_of_code(ast.parse(code))) == ["it was asked X times; no more"]


def test_the_pages_together_are_read_in_a_few_hours() -> None:
    assert sum(words_in(page.read_text()) for page in PAGES.values()) <= MOST_WORDS_IN_ALL


@pytest.mark.parametrize(
    ("rule", "bad", "good"),
    [
        (bare_decimals, "the share is .979 of 95", "the share is 0.979 of 95, `x[.5]` and version 1.0.8"),
        (bare_decimals, "| .98 |", "| 0.98 |"),
        (long_lines, "word " * 30, "| " + "cell | " * 30),
        (long_lines, "word " * 30, "```sh\n" + "word " * 30 + "\n```"),
        (too_many_words, "word " * (MOST_WORDS + 1), "word | " * MOST_WORDS),
        (banned_phrases, "a wing accuses", "a wing is suspected"),
        (what_clauses, "What remains is\ncut.", "The rest is cut. What is a cut? It says what it costs."),
        (what_clauses, "It is open; what is clear goes.", "What helps, in this order:"),
        (passives, "The run was asked once.", "The problem that was asked for is solved."),
        (figure_chains, "It takes 3 s; then 4 s;\nand 5 s.", "It takes 3 s; then 4 s.\n| 1 | 3; 4; 5 |"),
    ],
)
def test_a_rule_finds_what_breaks_it(rule: Rule, bad: str, good: str) -> None:
    assert rule(bad)
    assert not rule(good)
