"""The formulas of docs/examples/model.md, typed into highspy by nothing but the page: OCT and OCT-H as it prints them.

Imports nothing of octmip but the nouns. Letters and the order of the rows are the page's, so that both can be laid side
by side; a letter's index is a key of its dictionary.
"""

from itertools import pairwise
from typing import Any

import highspy
import numpy as np
from numpy.typing import NDArray

from octmip.trees.question.problem import Problem

BINARY: dict[str, Any] = {"lb": 0, "ub": 1, "type": highspy.HighsVarType.kInteger}


class PageModel:
    """A model under the letters of the page."""

    def __init__(self, problem: Problem) -> None:
        self.h = highspy.Highs()
        self.h.silent()
        for option in ("mip_rel_gap", "mip_abs_gap"):
            self.h.setOptionValue(option, 0.0)
        self.C = problem.costs
        self.w, self.y, self.N_min = problem.samples.weights, problem.samples.codes, problem.shape.leaf_size
        samples = problem.samples
        self.I, self.J, self.K = map(range, (samples.n_samples, samples.n_features, samples.n_classes))
        self.T_B = range(1, 2**problem.shape.depth)
        self.T_L = range(2**problem.shape.depth, 2 ** (problem.shape.depth + 1))
        self.L_hat = min(sum(self.w[i] * self.C[self.y[i], k] for i in self.I) for k in self.K)
        self.alpha = problem.shape.leaf_penalty / self.L_hat
        self.W = sum(self.w[i] * self.C[self.y[i]].max() for i in self.I)
        self.d = {m: self.h.addVariable(**BINARY) for m in self.T_B}
        self.z = {(i, t): self.h.addVariable(**BINARY) for i in self.I for t in self.T_L}
        self.l = {t: self.h.addVariable(**BINARY) for t in self.T_L}
        self.c = {(k, t): self.h.addVariable(**BINARY) for k in self.K for t in self.T_L}
        self.L = {t: self.h.addVariable(lb=0) for t in self.T_L}
        for m in self.T_B[1:]:
            self.h.addConstr(self.d[m] <= self.d[m // 2])

    def ancestors(self, t: int, side: int) -> list[int]:
        """Return A_L(t) for side 0, A_R(t) for side 1."""
        above = [t >> k for k in range(t.bit_length())]
        return [parent for child, parent in pairwise(above) if child % 2 == side]

    def add_leaves(self) -> None:
        """Add equations 6 to 8 and 15 to 22."""
        h = self.h
        for i in self.I:
            h.addConstr(h.qsum(self.z[i, t] for t in self.T_L) == 1)
        for t in self.T_L:
            for i in self.I:
                h.addConstr(self.z[i, t] <= self.l[t])
            h.addConstr(h.qsum(self.z[i, t] for i in self.I) >= self.N_min * self.l[t])
            h.addConstr(h.qsum(self.c[k, t] for k in self.K) == self.l[t])
            for k in self.K:
                cost = h.qsum(float(self.w[i] * self.C[self.y[i], k]) * self.z[i, t] for i in self.I)
                h.addConstr(self.L[t] >= cost - self.W * (1 - self.c[k, t]))
                h.addConstr(self.L[t] <= cost + self.W * self.c[k, t])

    def optimum(self, n_read: Any) -> float:
        """Return L_hat times the least value of the objective, whose splits are counted by `n_read`."""
        objective = (1 / self.L_hat) * self.h.qsum(self.L.values()) + self.alpha * n_read
        self.h.minimize(objective)
        assert self.h.getModelStatus() == highspy.HighsModelStatus.kOptimal
        return float(self.h.getObjectiveValue() * self.L_hat)


def oct_optimum(problem: Problem) -> float:
    """Return the optimum of OCT as the page states it, in the problem's units."""
    M = PageModel(problem)
    h, rank = M.h, [np.unique(column, return_inverse=True)[1] for column in problem.samples.features.T]
    x = np.column_stack([r / max(r.max(), 1) for r in rank])
    eps = np.array([1 / r.max() if r.max() else 1.0 for r in rank])
    a = {(j, m): h.addVariable(lb=0, ub=int(rank[j].max() > 0), type=BINARY["type"]) for j in M.J for m in M.T_B}
    b = {m: h.addVariable(lb=0) for m in M.T_B}
    for m in M.T_B:
        h.addConstr(h.qsum(a[j, m] for j in M.J) == M.d[m])
        h.addConstr(b[m] <= M.d[m])
    M.add_leaves()
    for t in M.T_L:
        for i in M.I:
            for m in M.ancestors(t, 0):
                left = h.qsum(float(x[i, j] + eps[j] - eps.min()) * a[j, m] for j in M.J) + float(eps.min())
                h.addConstr(left <= b[m] + float(1 + eps.max()) * (1 - M.z[i, t]))
            for m in M.ancestors(t, 1):
                h.addConstr(h.qsum(float(x[i, j]) * a[j, m] for j in M.J) >= b[m] - (1 - M.z[i, t]))
    return M.optimum(h.qsum(M.d.values()))


def oct_h_optimum(problem: Problem, mu: float) -> float:
    """Return the optimum of OCT-H as the page states it, in the problem's units."""
    M = PageModel(problem)
    h, x = M.h, _to_one(problem.samples.features)
    pairs = [(j, m) for j in M.J for m in M.T_B]
    a = {key: h.addVariable(lb=-1, ub=1) for key in pairs}
    a_hat = {key: h.addVariable(lb=0) for key in pairs}
    s = {key: h.addVariable(**BINARY) for key in pairs}
    b = {m: h.addVariable(lb=-1, ub=1) for m in M.T_B}
    for j, m in pairs:
        h.addConstr(a_hat[j, m] >= a[j, m])
        h.addConstr(a_hat[j, m] >= -a[j, m])
        h.addConstr(a[j, m] <= s[j, m])
        h.addConstr(a[j, m] >= -s[j, m])
        h.addConstr(s[j, m] <= M.d[m])
    for m in M.T_B:
        h.addConstr(h.qsum(a_hat[j, m] for j in M.J) <= M.d[m])
        h.addConstr(h.qsum(s[j, m] for j in M.J) >= M.d[m])
        h.addConstr(b[m] <= M.d[m])
        h.addConstr(b[m] >= -M.d[m])
    M.add_leaves()
    for t in M.T_L:
        for i in M.I:
            for m in M.ancestors(t, 0):
                left = h.qsum(float(x[i, j]) * a[j, m] for j in M.J) + mu
                h.addConstr(left <= b[m] + (2 + mu) * (1 - M.z[i, t]))
            for m in M.ancestors(t, 1):
                h.addConstr(h.qsum(float(x[i, j]) * a[j, m] for j in M.J) >= b[m] - 2 * (1 - M.z[i, t]))
    return M.optimum(h.qsum(s.values()))


def _to_one(features: NDArray[np.float64]) -> NDArray[np.float64]:
    least, width = features.min(axis=0), np.ptp(features, axis=0)
    scaled: NDArray[np.float64] = (features - least) / np.where(width > 0, width, 1)
    return scaled
