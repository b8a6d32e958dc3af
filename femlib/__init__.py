"""Finite-element shells, damage components and the wing whose simulated strains the decision trees are trained on."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from femlib.structure import read
else:  # a checker of types sees no name that is not there

    def __getattr__(name: str) -> Any:
        """Import what reads meshes when it is first asked for."""
        if name == "read":
            from femlib.structure import read

            return read
        raise AttributeError(f"module 'femlib' has no attribute {name!r}")


__all__ = ["read"]
