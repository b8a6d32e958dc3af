"""All solvers give the same answer, and say what they cannot do."""

import sys

import numpy as np
import pytest
import scipy.sparse as sparse

from femlib.assembly import factored_by, factorise
from femlib.assembly.factors import default_solver
from femlib.errors import InputError, SolveError

N = 60
CHAIN = sparse.csc_array(sparse.diags_array([4.0, -1.0, -1.0], offsets=[0, 1, -1], shape=(N, N)))
GROUPS = np.arange(N) // 6


def test_cholmod_solves_as_superlu_does() -> None:
    pytest.importorskip("sksparse", reason="the extra 'cholmod' is not installed")
    right, ports = np.random.default_rng(0).normal(size=(N, 3)), np.array([3, 7])
    with factored_by("superlu"):
        slow, slow_ports = factorise(CHAIN, GROUPS), factorise(CHAIN, GROUPS, ports)
    with factored_by("cholmod"):
        quick, with_ports = factorise(CHAIN, GROUPS), factorise(CHAIN, GROUPS, ports)
    assert quick.solve(right) == pytest.approx(slow.solve(right), rel=1e-12)
    assert quick.solve(right[:, 0]) == pytest.approx(quick.solve(right)[:, 0], rel=1e-12)
    assert with_ports.solve(right) == pytest.approx(slow.solve(right), rel=1e-12)
    assert with_ports.schur() == pytest.approx(slow_ports.schur(), rel=1e-12)
    with factored_by("cholmod"), pytest.raises(SolveError, match="not positive definite"):
        factorise(sparse.csc_array(-CHAIN), GROUPS)


def test_cholmod_is_the_default_where_it_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    for found, solver in ((None, "superlu"), (object(), "cholmod")):
        monkeypatch.setattr("femlib.assembly.factors.find_spec", lambda _name, found=found: found)
        default_solver.cache_clear()
        assert default_solver() == solver
    monkeypatch.undo()
    default_solver.cache_clear()


def test_an_unknown_or_absent_solver_gets_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="solver is 'umfpack'; expected one of"), factored_by("umfpack"):
        pass
    monkeypatch.setitem(sys.modules, "sksparse", None)
    with factored_by("cholmod"), pytest.raises(InputError, match=r"install octmip\[cholmod\]"):
        factorise(CHAIN, GROUPS)
