"""The searches that a user types, with the page that answers each: `tests/test_site.py` asks the site. And the FAQ."""

import re
from pathlib import Path

DOCS = Path(__file__).parent.parent / "docs"
N_QUESTIONS = 30
FIRST_WORDS = 14
"""Words before the first stop of an answer, at most."""

ASKED = """
faq: gpu; licence of data; commercial use; cite; callback; monotonic constraint; overfitting; warm start
faq: why is gap not 0; not proven optimal; fix the root; custom loss; quantile; windows; R package; lightgbm
faq: random forest; streaming partial_fit; gurobi; random seed; class imbalance; feature scaling; dates
faq: how much memory; predict_proba calibration; save load tree; finite element digital twin; verbose; fairness
faq: streamlit; changelog; report a bug or contribute
howto/text-and-missing: missing values; categorical columns; text columns and empty cells
howto/export: export sql; pmml; tree as C code
howto/costs-and-weights: cost matrix; one mistake costs more than another
examples/choosing: depth cross-validation
howto/machines: cluster dask; slurm; spark
howto/diagnose-a-gap: diagnose gap asset twin
howto/near-optimal: rashomon set; which sensor can I lose
index: multiclass; notebook; my model does not predict what the structure reads; what is an optimal decision tree
results/scaling: slurm checkpoint
install: conda; uv pipx; docker; python 3.13; how do I install it; which python version
howto/solve-a-csv: half a standard error
how-long: how long will a proof take
reliability: is the best tree really proven
howto/check-a-proof: check a proof without the solver
howto/held-out: hold out data to see what holds on new rows
howto/regression-trees: predict a number instead of a class; linear model in the leaves
howto/monotone: prediction must rise with a sensor; at most four leaves
howto/sensor-budget: budget of sensors that cost money
examples/placement: where to put strain gauges on a wing
howto/large-tables: proof takes too long for a large table; resume an interrupted proof
howto/doors: diagnose with a python function of my own
howto/monitor-command: monitor my machine by one command
benchmarks: is it faster than pycontree
examples/model: equations of the mixed-integer program
examples/scikit-learn: feature importance
gap: what is a commissioning run; how often is the diagnosis right
theory/proofs/verified: how is the proof checked in Coq
examples/command: exit code of the command
results/modes: buckling load of the wing
examples/failed-gauge: which sensor has failed
"""
"""What a user types, or asks who sees the site for the first time, in his words, behind the page that answers."""
SEARCHES = {
    search: page
    for page, words in (line.split(": ", 1) for line in ASKED.strip().splitlines())
    for search in words.split("; ")
}


def test_every_answer_begins_with_the_word_that_decides_and_leads_on() -> None:
    """Yes, no or one word; at most four short sentences."""
    answers = re.split(r"^### .*\n", (DOCS / "faq.md").read_text(), flags=re.MULTILINE)[1:]
    assert len(answers) >= N_QUESTIONS
    for answer in answers:
        text = re.sub(r"\([^()]*\)|`[^`]*`", "", answer.partition("\n## ")[0])
        n_sentences = len(re.findall(r"[.?](?=\s|$)", text))
        assert 1 <= n_sentences <= 4, answer
        assert len(re.split(r"[.,:;]|, ", answer.strip())[0].split()) <= FIRST_WORDS, answer
