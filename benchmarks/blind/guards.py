"""What a score must be compared with: shuffled keys, a classifier, a ranking without priors, a lasso."""

import warnings

import numpy as np
from sklearn.linear_model import LogisticRegression
from sklearn.model_selection import StratifiedKFold, cross_val_predict

from benchmarks.blind.score import share, top


def guards(found, answers, lasso):
    """Return the guards' figures; `lasso` maps some case names to the effect that the group lasso names."""
    single = [(f, answers[f["name"]]) for f in found if answers[f["name"]]["case"]["stratum"].startswith("single")]
    clear = [(f, a) for f, a in single if a["d_prime"] >= 5.0]
    rng = np.random.default_rng(0)
    order = rng.permutation(len(clear))
    shuffled = [top(clear[k][0], clear[j][1]) for k, j in enumerate(order)]
    rows = [
        share("shuffled keys, top-1 by group, d' >= 5", shuffled),
        share("chi-squared ranking, top-1 by name, d' >= 5", [f["ranking"] == _name(a) for f, a in clear]),
        share("this diagnosis, top-1 by name, d' >= 5", [f["which"][0]["effects"] == [_name(a)] for f, a in clear]),
        share("residual classifier, top-1 by name, d' >= 5, cross-validated", _classifier(clear)),
        share(
            "group lasso, top-1 by name",
            [lasso[a["case"]["name"]] == _name(a) for _, a in clear if a["case"]["name"] in lasso],
        ),
    ]
    return rows


def _name(answer):
    return answer["case"]["truths"][0]["name"]


def _classifier(cases):
    """Return hits of a logistic regression on whitened residuals, for names with five cases or more."""
    names = [_name(a) for _, a in cases]
    kept = [k for k, name in enumerate(names) if names.count(name) >= 5]
    if len(kept) < 20:
        return []
    features = np.arcsinh(np.array([cases[k][0]["residual"] for k in kept]))
    labels = np.array([names[k] for k in kept])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        told = cross_val_predict(
            LogisticRegression(max_iter=500), features, labels, cv=StratifiedKFold(5, shuffle=True, random_state=0)
        )
    return (told == labels).tolist()
