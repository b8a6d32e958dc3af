"""Families of assets by name: who models the wing that the cases are measured on."""

from collections.abc import Iterable
from pathlib import Path

from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.calculix import CalculixAsset
from benchmarks.blind.assets.shells import REFINEMENT, FemlibAsset
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.ccx import has_ccx

FAMILIES = ("femlib", "calculix", "springs", "beam")
OWN = "femlib"
"""The family that shares its code with the twin; the others are foreign."""
NEED_CALCULIX = ("calculix", "springs")


def available() -> tuple[str, ...]:
    """Return the families that this machine can compute: without `ccx` there are none of CalculiX."""
    return tuple(name for name in FAMILIES if has_ccx() or name not in NEED_CALCULIX)


def made(name: str, seed: int, keys: Path, refinement: float = REFINEMENT, jobs: int = 1) -> Asset:
    """Return the asset of a family; what expensive runs found is kept beside the keys.

    Raises
    ------
    SystemExit
        If there is no such family, or CalculiX is not installed and the family needs it.
    """
    if name not in FAMILIES:
        raise SystemExit(f"there is no family {name!r}; expected one of {', '.join(FAMILIES)}; correct --family")
    if name not in available():
        raise SystemExit(f"family {name!r} needs ccx, which is not on the path; install CalculiX or leave it out")
    if name == "calculix":
        return CalculixAsset(seed, store=keys.with_suffix(".calculix.json"), jobs=jobs)
    if name == "springs":
        return SpringsAsset(seed, store=keys.with_suffix(".springs.json"), jobs=jobs)
    return BeamAsset(seed) if name == "beam" else FemlibAsset(seed, refinement)


def slug(family: str) -> str:
    """Return the name on the command line, and the folder, of an asset's `family`."""
    return family.split(",")[0].lower()


def in_order(families: Iterable[str]) -> list[str]:
    """Return the families of a set, the own one first."""
    return sorted(families, key=lambda family: FAMILIES.index(slug(family)))
