"""Which trees the bound of a formulation speaks about."""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Scope:
    """The trees of a formulation; by default those of thresholds between ranks.

    Attributes
    ----------
    trees
        in words; they begin with "all" where no tree of the problem is left out.
    tolerance
        the feasibility tolerance that keeps HiGHS to them.
    notes
        further details of the splits for the Solution.
    """

    trees: str = "all axis-aligned trees"
    tolerance: float = 1e-6
    notes: Mapping[str, object] = field(default_factory=dict)

    @property
    def is_whole(self) -> bool:
        """Whether no tree of the problem is left out."""
        return self.trees.startswith("all")
