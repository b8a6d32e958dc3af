"""Both solvers give the same answer, and say what they cannot do."""

import numpy as np
import pytest
import scipy.sparse as sparse

from femlib.assembly import factored_by, factorise
from femlib.errors import InputError, SolveError

N = 60
CHAIN = sparse.csc_array(sparse.diags_array([4.0, -1.0, -1.0], offsets=[0, 1, -1], shape=(N, N)))
GROUPS = np.arange(N) // 6


def test_pardiso_solves_as_superlu_does() -> None:
    pytest.importorskip("pypardiso", reason="the extra 'pardiso' is not installed")
    right = np.random.default_rng(0).normal(size=(N, 3))
    with factored_by("pardiso"):
        quick = factorise(CHAIN, GROUPS)
        with_ports = factorise(CHAIN, GROUPS, np.array([3, 7]))
    assert quick.solve(right) == pytest.approx(factorise(CHAIN, GROUPS).solve(right), rel=1e-12)
    assert quick.solve(right[:, 0]) == pytest.approx(quick.solve(right)[:, 0], rel=1e-12)
    assert with_ports.schur() == pytest.approx(factorise(CHAIN, GROUPS, np.array([3, 7])).schur(), rel=1e-12)
    with pytest.raises(SolveError, match="hold no ports"):
        quick.schur()
    with factored_by("pardiso"), pytest.raises(SolveError, match="not positive definite"):
        factorise(sparse.csc_array(-CHAIN), GROUPS)


def test_an_unknown_or_absent_solver_gets_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="solver is 'umfpack'; expected one of"), factored_by("umfpack"):
        pass
    monkeypatch.setitem(__import__("sys").modules, "pypardiso", None)
    with factored_by("pardiso"), pytest.raises(InputError, match=r"install octmip\[pardiso\]"):
        factorise(CHAIN, GROUPS)
