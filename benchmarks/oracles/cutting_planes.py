"""Cutting-planes proofs replayed: the rules that octmip's pseudo-Boolean proofs use, and no other.

A constraint `sum_l a_l l >= b` over literals is held with positive coefficients, a variable in one literal only. Knows
nothing of trees; slow, for small formulas.

pol   postfix: a number is a constraint; literal l: l >= 0; `+`; `k *`; `k d`: divided, rounded up; `x w`: x taken out,
      at its largest; `s`: no coefficient above the right side
pbc   C : subproof ... qed pbc : ID   with the negation of C, ID is a contradiction; then C holds
del   id ..., deld ...: forgotten
f     number of constraints of the formula
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

Terms = dict[str, int]


@dataclass(frozen=True)
class Constraint:
    """Sum of positive multiples of literals of different variables, at least `least`."""

    terms: tuple[tuple[str, int], ...]
    least: int

    @classmethod
    def of(cls, terms: Terms, least: int) -> "Constraint":
        """Return a constraint whose literals may meet their negations."""
        kept: Terms = {}
        for literal, factor in terms.items():
            other = negated(literal)
            common = min(factor, kept.get(other, 0))
            least -= common
            if other in kept:
                kept[other] -= common
            if factor > common:
                kept[literal] = kept.get(literal, 0) + factor - common
        return cls(tuple(sorted((literal, factor) for literal, factor in kept.items() if factor)), least)

    @property
    def is_contradiction(self) -> bool:
        """Whether no assignment satisfies it."""
        return sum(factor for _, factor in self.terms) < self.least

    def holds(self, true: set[str]) -> bool:
        """Whether it holds where these variables are true and no others."""
        paid = (factor for name, factor in self.terms if (name[1:] not in true if name[0] == "~" else name in true))
        return sum(paid) >= self.least

    def plus(self, other: "Constraint") -> "Constraint":
        """Return the sum."""
        terms = dict(self.terms)
        for literal, factor in other.terms:
            terms[literal] = terms.get(literal, 0) + factor
        return Constraint.of(terms, self.least + other.least)

    def times(self, factor: int) -> "Constraint":
        """Return a multiple."""
        return Constraint(tuple((literal, a * factor) for literal, a in self.terms), self.least * factor)

    def divided(self, divisor: int) -> "Constraint":
        """Return it divided and rounded up."""
        return Constraint(tuple((literal, -(-a // divisor)) for literal, a in self.terms), -(-self.least // divisor))

    def saturated(self) -> "Constraint":
        """Return it with no coefficient above the right side."""
        most = max(self.least, 0)
        return Constraint(tuple((literal, min(a, most)) for literal, a in self.terms if most), self.least)

    def without(self, name: str) -> "Constraint":
        """Return it with a variable taken out."""
        taken = sum(a for literal, a in self.terms if literal.lstrip("~") == name)
        return Constraint(tuple(term for term in self.terms if term[0].lstrip("~") != name), self.least - taken)

    @property
    def negation(self) -> "Constraint":
        """Return what holds where it does not."""
        terms = {negated(literal): factor for literal, factor in self.terms}
        return Constraint.of(terms, sum(terms.values()) - self.least + 1)


def negated(literal: str) -> str:
    """Return the other literal of a variable."""
    return literal[1:] if literal[0] == "~" else f"~{literal}"


def read_constraint(text: str) -> Constraint:
    """Return `a l a l ... >= b`."""
    left, right = text.split(">=")
    words = left.split()
    terms: Terms = {}
    for factor, literal in zip(words[::2], words[1::2], strict=True):
        terms[literal] = terms.get(literal, 0) + int(factor)
    return Constraint.of(terms, int(right))


def read_formula(text: str) -> tuple[Constraint, list[Constraint]]:
    """Return "the objective is 0 or more" and the constraints."""
    lines = [line.rstrip(";") for line in text.splitlines() if not line.startswith("*")]
    return read_constraint(lines[0].removeprefix("min:") + " >= 0"), [read_constraint(line) for line in lines[1:]]


def verified_bounds(formula: str, proof: str) -> tuple[int, int]:
    """Return the bounds of the objective that a proof concludes.

    Raises
    ------
    ValueError
        a line does not follow.
    """
    objective, constraints = read_formula(formula)
    known = dict(enumerate(constraints, start=1))
    steps = iter(statement.strip() for statement in re.split(r";|(?<= subproof)\n", proof.partition("\n")[2]))
    numbers = iter(range(len(constraints) + 1, 10**9))
    conclusion = _replayed(steps, known, numbers, len(constraints))
    low, number, high, true = _concluded(conclusion)
    if known[number].terms != objective.terms or known[number].least < low:
        raise ValueError(f"constraint {number} is not the bound {low}")
    broken = [constraint for constraint in constraints if not constraint.holds(true)]
    if broken or sum(factor for name, factor in objective.terms if name in true) != high:
        raise ValueError(f"the assignment does not satisfy {broken[:1]} at {high}")
    return low, high


def _concluded(conclusion: str) -> tuple[int, int, int, set[str]]:
    found = re.fullmatch(r"conclusion BOUNDS (\d+) : (\d+) (\d+) : (.*)", conclusion)
    if found is None:
        raise ValueError(f"{conclusion[:60]!r} is no conclusion")
    literals = found[4].split()
    return int(found[1]), int(found[2]), int(found[3]), {name for name in literals if name[0] != "~"}


def _replayed(steps: Iterator[str], known: dict[int, Constraint], numbers: Iterator[int], n_constraints: int) -> str:
    """Replay steps up to the conclusion, or the end of a proof by contradiction, and return that step."""
    for step in steps:
        rule, _, rest = step.partition(" ")
        if rule == "pol":
            known[next(numbers)] = _derived(rest.split(), known)
        elif rule == "pbc":
            claim, inside = read_constraint(rest.removesuffix(" : subproof")), dict(known)
            inside[next(numbers)] = claim.negation
            end = _replayed(steps, inside, numbers, n_constraints)
            if not inside[int(end.rpartition(" ")[2])].is_contradiction:
                raise ValueError(f"{end} is no contradiction")
            known[next(numbers)] = claim
        elif step.startswith(("del id ", "deld ")):
            for number in rest.removeprefix("id ").split():
                del known[int(number)]
        elif rule in ("qed", "conclusion"):
            return step
        elif step not in ("", "output NONE", f"f {n_constraints}"):
            raise ValueError(f"{step[:60]!r} is no step")
    raise ValueError("the proof ends early")


def _derived(words: list[str], known: dict[int, Constraint]) -> Constraint:
    stack: list[Constraint | str] = []

    def popped() -> Constraint:
        top = stack.pop()
        if isinstance(top, Constraint):
            return top
        return known[int(top)] if top.isdigit() else Constraint(((top, 1),), 0)

    for word in words:
        if word in ("*", "d", "w"):
            operand = stack.pop()
            assert isinstance(operand, str)
            stack.append(_with_operand(popped(), word, operand))
        elif word == "s":
            stack.append(popped().saturated())
        elif word == "+":
            stack.append(popped().plus(popped()))
        else:
            stack.append(word)
    if len(stack) != 1:
        raise ValueError(f"{' '.join(words)[:60]!r} leaves {len(stack)} constraints")
    return popped()


def _with_operand(below: Constraint, word: str, operand: str) -> Constraint:
    if word == "w":
        return below.without(operand)
    return below.times(int(operand)) if word == "*" else below.divided(int(operand))
