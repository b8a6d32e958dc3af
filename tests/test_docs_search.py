"""The searches that a user types find their page, by the words of the pages themselves.

The search is a small one over the sections of all pages: rare words count more, words of a heading more than words of
the text. It stands for the search of the built site, which has more to go by.
"""

import math
import re
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest

DOCS = Path(__file__).parent.parent / "docs"
TITLE, HEADING = 2.0, 6.0
"""What a word of a page's title, of a section's heading counts; one of its text counts 1 + log of its number."""
N_READ = 3
"""Hits that a user looks at."""
N_QUESTIONS = 30
FIRST_WORDS = 14
"""Words before the first stop of an answer, at most."""

SEARCHES = {
    "gpu": "faq",
    "licence of data": "faq",
    "commercial use": "faq",
    "cite": "faq",
    "callback": "faq",
    "monotonic constraint": "faq",
    "overfitting": "faq",
    "warm start": "faq",
    "why is gap not 0": "faq",
    "not proven optimal": "faq",
    "fix the root": "faq",
    "custom loss": "faq",
    "quantile": "faq",
    "windows": "faq",
    "R package": "faq",
    "lightgbm": "faq",
    "random forest": "faq",
    "streaming partial_fit": "faq",
    "gurobi": "faq",
    "random seed": "faq",
    "class imbalance": "faq",
    "feature scaling": "faq",
    "dates": "faq",
    "how much memory": "faq",
    "predict_proba calibration": "faq",
    "save load tree": "faq",
    "missing values": "howto/text-and-missing",
    "categorical columns": "howto/text-and-missing",
    "export sql": "howto/export",
    "cost matrix": "howto/costs-and-weights",
    "depth cross-validation": "examples/choosing",
    "cluster dask": "howto/machines",
    "finite element digital twin": "faq",
    "diagnose gap asset twin": "howto/diagnose-a-gap",
}


QUESTIONS = {
    "how do I install it": "install",
    "how long will a proof take": "how-long",
    "is the best tree really proven": "reliability",
    "check a proof without the solver": "howto/check-a-proof",
    "hold out data to see what holds on new rows": "howto/held-out",
    "one mistake costs more than another": "howto/costs-and-weights",
    "text columns and empty cells": "howto/text-and-missing",
    "predict a number instead of a class": "howto/regression-trees",
    "prediction must rise with a sensor": "howto/monotone",
    "at most four leaves": "howto/monotone",
    "budget of sensors that cost money": "howto/sensor-budget",
    "which sensor can I lose": "howto/near-optimal",
    "where to put strain gauges on a wing": "examples/placement",
    "proof takes too long for a large table": "howto/large-tables",
    "tree as C code": "howto/export",
    "my model does not predict what the structure reads": "index",
    "diagnose with a python function of my own": "howto/doors",
    "monitor my machine by one command": "howto/monitor-command",
    "is it faster than pycontree": "benchmarks",
    "equations of the mixed-integer program": "examples/model",
    "what is an optimal decision tree": "index",
    "which python version": "install",
    "resume an interrupted proof": "howto/large-tables",
    "feature importance": "examples/scikit-learn",
    "linear model in the leaves": "howto/regression-trees",
    "what is a commissioning run": "gap",
    "how often is the diagnosis right": "gap",
    "how is the proof checked in Coq": "theory/proofs/verified",
    "report a bug or contribute": "faq",
    "exit code of the command": "examples/command",
    "buckling load of the wing": "results/modes",
    "which sensor has failed": "examples/failed-gauge",
}
"""What somebody asks who sees the site for the first time, in his words, and the page that answers."""


def words(text: str) -> list[str]:
    """Return the stems of a text's words, in lower case: without the endings of plural, past and participle."""
    found = re.findall(r"[a-z_]+|\d+", text.lower())
    return [re.sub(r"(ing|ies|es|ed|s|y|e)$", "", word) or word for word in found]


@dataclass(frozen=True, slots=True)
class Section:
    """A section of a page: where it stands, and what each stem counts in it."""

    page: str
    weights: dict[str, float]


def sections_of(page: str, text: str) -> list[Section]:
    """Return the sections of a page, from heading to heading, code left out."""
    prose = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    parts = re.split(r"^#+ ", prose, flags=re.MULTILINE)[1:]
    title = set(words(parts[0].partition("\n")[0])) if parts else set()
    found = []
    for part in parts:
        heading, _, body = part.partition("\n")
        weights = {stem: 1.0 + math.log(n) for stem, n in Counter(words(body)).items()}
        for stem in title:
            weights[stem] = weights.get(stem, 0.0) + TITLE
        for stem in set(words(heading)):
            weights[stem] = weights.get(stem, 0.0) + HEADING
        found.append(Section(page, weights))
    return found


@cache
def all_sections() -> tuple[Section, ...]:
    pages = {str(file.relative_to(DOCS).with_suffix("")): file.read_text() for file in sorted(DOCS.rglob("*.md"))}
    return tuple(section for page, text in pages.items() for section in sections_of(page, text))


def hits(search: str, sections: tuple[Section, ...]) -> list[str]:
    """Return the pages of the sections that answer a search best, the best first; each section is one hit."""
    rarity = {
        stem: math.log((1 + len(sections)) / (1 + sum(stem in section.weights for section in sections)))
        for stem in set(words(search))
    }
    scores = [(sum(rarity[stem] * section.weights.get(stem, 0.0) for stem in rarity), section) for section in sections]
    ranked = sorted((score, section.page) for score, section in scores if score > 0)[::-1]
    return [page for _, page in ranked]


@pytest.mark.parametrize(("search", "page"), [*SEARCHES.items(), *QUESTIONS.items()])
def test_a_search_finds_its_page(search: str, page: str) -> None:
    found = hits(search, all_sections())[:N_READ]
    assert page in found, found


def test_a_search_for_a_word_that_no_page_has_finds_nothing() -> None:
    assert hits("zyzzyva", all_sections()) == []


def test_headings_count_more_than_text() -> None:
    sections = (*sections_of("a", "# A\n\nwarm warm warm\n"), *sections_of("b", "# Warm start\n\ntext\n"))
    assert hits("warm", (*sections, *sections_of("c", "# C\n\ntext\n")))[0] == "b"


def test_every_answer_begins_with_the_word_that_decides_and_leads_on() -> None:
    """Yes, no or one word; at most four short sentences."""
    answers = re.split(r"^### .*\n", (DOCS / "faq.md").read_text(), flags=re.MULTILINE)[1:]
    assert len(answers) >= N_QUESTIONS
    for answer in answers:
        text = re.sub(r"\([^()]*\)|`[^`]*`", "", answer.partition("\n## ")[0])
        n_sentences = len(re.findall(r"[.?](?=\s|$)", text))
        assert 1 <= n_sentences <= 4, answer
        assert len(re.split(r"[.,:;]|, ", answer.strip())[0].split()) <= FIRST_WORDS, answer
