"""pyMOR's reduced basis of a damaged wing: one global basis, the same affine stiffness, load and gauges.

K(mu) = K_rest + sum_i (1 - mu_i) K_i, energy product K(0). With few regions: weak greedy with the residual estimator
and the min-theta bound of the coercivity. With many: proper orthogonal decomposition of random states, without an
estimator, since its residual needs a solve for each region and mode.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from femlib.wing import Wing

if TYPE_CHECKING:
    from pymor.models.basic import StationaryModel
    from pymor.parameters.functionals import ExpressionParameterFunctional

MICRO = 1e6
N_TRAIN = 60
N_GREEDY = 14
N_POD = 100
FEW_REGIONS = 3

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class PymorBasis:
    """pyMOR's model: outputs [microstrain] and, where it has one, the error estimate of a state, at unit load."""

    n_modes: int
    query: Callable[[Floats], Floats]
    estimate: Callable[[Floats], float] | None


def pymor_basis(wing: Wing, most_damage: float, n_train: int = N_TRAIN, n_greedy: int = N_GREEDY) -> PymorBasis:
    """Return the reduced basis trained on damages up to `most_damage`."""
    from pymor.algorithms.greedy import rb_greedy
    from pymor.algorithms.pod import pod
    from pymor.core.logger import set_log_levels
    from pymor.parameters.base import Mu
    from pymor.parameters.functionals import ConstantParameterFunctional, MinThetaParameterFunctional
    from pymor.reductors.basic import StationaryRBReductor
    from pymor.reductors.coercive import CoerciveRBReductor

    set_log_levels({"pymor": "ERROR"})
    full, thetas = _full_model(wing)
    n = len(wing.parameters)
    states = np.random.default_rng(0).uniform(0.0, most_damage, (n_train if n <= FEW_REGIONS else 2 * N_POD, n))
    train = [full.parameters.parse(state) for state in states]
    if n <= FEW_REGIONS:
        undamaged: Mu = full.parameters.parse(np.zeros(n))
        coercivity = MinThetaParameterFunctional([ConstantParameterFunctional(1.0), *thetas], undamaged, 1.0)
        reductor = CoerciveRBReductor(full, product=full.products["energy"], coercivity_estimator=coercivity)
        model = rb_greedy(full, reductor, train, max_extensions=n_greedy)["rom"]
    else:
        snapshots = full.solution_space.empty()
        for state in train:
            snapshots.append(full.solve(state))
        modes, _ = pod(snapshots, product=full.products["energy"], modes=N_POD)
        model = StationaryRBReductor(full, modes, product=full.products["energy"]).reduce()

    def query(state: Floats) -> Floats:
        return np.asarray(model.output(full.parameters.parse(state)), dtype=np.float64).ravel()

    def estimate(state: Floats) -> float:
        return float(np.ravel(model.estimate_error(full.parameters.parse(state)))[0])

    return PymorBasis(model.solution_space.dim, query, estimate if n <= FEW_REGIONS else None)


def _full_model(wing: Wing) -> tuple["StationaryModel", list["ExpressionParameterFunctional"]]:
    """Return pyMOR's full model and the regions' factors 1 - mu_i."""
    from pymor.models.basic import StationaryModel
    from pymor.operators.constructions import LincombOperator
    from pymor.operators.numpy import NumpyMatrixOperator
    from pymor.parameters.functionals import ExpressionParameterFunctional

    supports, shells = wing.structure.supports, wing.structure.shells
    regions = [supports.reduce(shells.stiffness(component.elements)) for component in wing.structure.components]
    whole = supports.reduce(shells.stiffness())
    blocks = [whole - sum(regions[1:], regions[0]), *regions]
    n = len(regions)
    thetas = [ExpressionParameterFunctional(f"1 - mu[{i}]", {"mu": n}) for i in range(n)]
    stiffness = LincombOperator([NumpyMatrixOperator(sparse.csc_matrix(block)) for block in blocks], [1.0, *thetas])
    gauges = NumpyMatrixOperator(sparse.csr_matrix(MICRO * wing.strain_rows)[:, supports.free])
    model = StationaryModel(
        stiffness,
        NumpyMatrixOperator(wing.lift[supports.free][:, None]),
        output_functional=gauges,
        products={"energy": NumpyMatrixOperator(sparse.csc_matrix(whole))},
    )
    return model, thetas
