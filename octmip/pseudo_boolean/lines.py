"""Lines of a cutting-planes proof, each known by the number of the constraint that it derives."""

from collections.abc import Iterable

HEADER = "pseudo-Boolean proof version 3.0"


class Lines:
    """The lines of a proof so far.

    Parameters
    ----------
    n_constraints
        of the formula: the first derived constraint has the next number.
    """

    def __init__(self, n_constraints: int) -> None:
        self.text: list[str] = [HEADER]
        self.last = n_constraints

    def derive(self, operations: str) -> int:
        """Add a constraint by operations in postfix notation, and return its number."""
        self.text.append(f"pol {operations};")
        self.last += 1
        return self.last

    def begin(self, terms: str, least: int) -> int:
        """Begin a proof by contradiction of a constraint, and return the number of its negation."""
        self.text.append(f"pbc {terms} >= {least} : subproof")
        self.last += 1
        return self.last

    def end(self, contradiction: int) -> int:
        """End a proof by contradiction, and return the number of the constraint that is now proven."""
        self.text.append(f"qed pbc : {contradiction};")
        self.last += 1
        return self.last

    def delete(self, numbers: Iterable[int]) -> None:
        """Delete constraints that are no longer needed: a checker's time and memory depend on what is kept."""
        listed = " ".join(map(str, numbers))
        if listed:
            self.text.append(f"del id {listed};")


def times(operand: str | int, factor: int) -> str:
    """Return the operations that add a multiple of a constraint to the one before."""
    return f" {operand} +" if factor == 1 else f" {operand} {factor} * +"


def total(numbers: Iterable[int | str]) -> str:
    """Return the operations that add up constraints."""
    first, *others = numbers
    return f"{first}" + "".join(f" {number} +" for number in others)
