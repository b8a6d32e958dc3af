"""One wing for all tests, and the published table where it lies beside the project."""

from pathlib import Path

import pytest

from femlib.dataset import MeanStrains, published_strains, simulated_strains
from femlib.wing import ReducedWing, Wing, reduce_wing, uav_wing
from femlib.wing.damage import damage_library

SHARED = Path(__file__).resolve().parents[3] / "shared"
PUBLISHED = SHARED / "uav" / "strains.csv"


@pytest.fixture(scope="session")
def wing() -> Wing:
    return uav_wing()


@pytest.fixture(scope="session")
def coarser() -> Wing:
    """The wing with all 82 gauges on a mesh so coarse that factorising it again and again takes little."""
    return uav_wing(candidates=True, refinement=0.3)


@pytest.fixture(scope="session")
def all_regions() -> Wing:
    """The wing with all 28 regions on a mesh so coarse that their couplings take seconds."""
    return uav_wing(refinement=0.25, regions=damage_library())


@pytest.fixture(scope="session")
def tiny() -> Wing:
    """The wing on the coarsest mesh that it is used with, for what no mesh changes."""
    return uav_wing(refinement=0.25)


@pytest.fixture(scope="session")
def tiny_reduced(tiny: Wing) -> ReducedWing:
    return reduce_wing(tiny)


@pytest.fixture(scope="session")
def simulated(wing: Wing) -> MeanStrains:
    return simulated_strains(wing)


@pytest.fixture(scope="session")
def published() -> MeanStrains:
    """Mean strains of the 25 states from the published table."""
    if not PUBLISHED.exists():
        pytest.skip("the published strain table is not beside the project (../shared/uav/strains.csv)")
    return published_strains(PUBLISHED)
