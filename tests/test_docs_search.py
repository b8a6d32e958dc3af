"""The searches that a user types, with the page that answers each: `tests/test_site.py` asks the site. And the FAQ."""

import re
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"
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
    "rashomon set": "howto/near-optimal",
    "multiclass": "index",
    "verbose": "faq",
    "slurm": "howto/machines",
    "spark": "howto/machines",
    "slurm checkpoint": "results/scaling",
    "conda": "install",
    "uv pipx": "install",
    "docker": "install",
    "python 3.13": "install",
    "pmml": "howto/export",
    "fairness": "faq",
    "streamlit": "faq",
    "changelog": "faq",
    "half a standard error": "howto/solve-a-csv",
    "notebook": "index",
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


def test_every_answer_begins_with_the_word_that_decides_and_leads_on() -> None:
    """Yes, no or one word; at most four short sentences."""
    answers = re.split(r"^### .*\n", (DOCS / "faq.md").read_text(), flags=re.MULTILINE)[1:]
    assert len(answers) >= N_QUESTIONS
    for answer in answers:
        text = re.sub(r"\([^()]*\)|`[^`]*`", "", answer.partition("\n## ")[0])
        n_sentences = len(re.findall(r"[.?](?=\s|$)", text))
        assert 1 <= n_sentences <= 4, answer
        assert len(re.split(r"[.,:;]|, ", answer.strip())[0].split()) <= FIRST_WORDS, answer
