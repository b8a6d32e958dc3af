"""Families of assets by name: who models the wing that the cases are measured on."""

from collections.abc import Iterable
from pathlib import Path

from benchmarks.blind.assets.asset import Asset
from benchmarks.blind.assets.beam.asset import BeamAsset
from benchmarks.blind.assets.springs.asset import SpringsAsset
from benchmarks.ccx import has_ccx

FAMILIES = ("springs", "beam")
"""None shares its code with the twin."""
NEED_CALCULIX = ("springs",)


def available() -> tuple[str, ...]:
    """Return the families that this machine can compute: without `ccx` there are none of CalculiX."""
    return tuple(name for name in FAMILIES if has_ccx() or name not in NEED_CALCULIX)


def made(name: str, seed: int, keys: Path) -> Asset:
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
    return BeamAsset(seed) if name == "beam" else SpringsAsset(seed, store=keys.with_suffix(".springs.json"))


def slug(family: str) -> str:
    """Return the name on the command line, and the folder, of an asset's `family`."""
    return family.split(",")[0].lower()


def in_order(families: Iterable[str]) -> list[str]:
    """Return the families of a set in the order of FAMILIES."""
    return sorted(families, key=lambda family: FAMILIES.index(slug(family)))
