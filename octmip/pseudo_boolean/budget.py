"""The budget in a proof: which columns the three nodes cannot read together, and cases joined to one."""

from octmip.pseudo_boolean.formula import Formula, left
from octmip.pseudo_boolean.lines import Lines, total
from octmip.pseudo_boolean.roots import Group


class Budget:
    """Consequences of the budget of a formula."""

    def __init__(self, formula: Formula, lines: Lines) -> None:
        self.formula, self.lines, self.question = formula, lines, formula.question
        self._known: dict[tuple[tuple[int, int], ...], int] = {}

    def joined(self, j: int, closed: dict[Group, int]) -> int:
        """Return the number of "the root is not split on column j".

        Parameters
        ----------
        closed
            for each group the number of the same, or one of the sides reads a column that is not the group's.
        """
        affordable = max((group.right for group in closed), key=len)  # of all groups; one has them
        columns = range(self.question.n_columns)
        beyond = [k for k in columns if k not in affordable]
        if len(closed) == 1 and not beyond:
            return next(iter(closed.values()))
        not_left = {k: self._not_with(j, k, closed) for k in sorted(affordable)}
        not_left |= {k: self._excluded((0, j), (1, k)) for k in beyond}
        group = next(group for group in closed if group.right == affordable)
        parts = [closed[group], *(self._excluded((0, j), (2, k)) for k in beyond)]
        parts += [number for k, number in not_left.items() if k not in group.left]
        return self.lines.derive(f"{total(parts)} s")

    def _not_with(self, j: int, k: int, closed: dict[Group, int]) -> int:
        """Return the number of "the root is not split on j, or its left side not on k"."""
        group = next(group for group in closed if k in group.left)
        columns = range(self.question.n_columns)
        parts = [closed[group]]
        parts += [self._single(1, k, other) for other in columns if other not in group.left]
        parts += [self._excluded((0, j), (1, k), (2, other)) for other in columns if other not in group.right]
        return self.lines.derive(f"{total(parts)} s")

    def _single(self, m: int, j: int, k: int) -> int:
        """Return the number of "node m is not split on column j, or not on k"."""
        key = ((m, min(j, k)), (m, max(j, k)))
        if key not in self._known:
            others = "".join(f" {left(m, c, 0)} w" for c in range(self.question.n_columns) if c not in (j, k))
            self._known[key] = self.lines.derive(f"{self.formula.single[m]} s{m} w{others}")
        return self._known[key]

    def _excluded(self, *uses: tuple[int, int]) -> int:
        """Return the number of "not all of these (node, column) are split on": they are above the budget together."""
        if len(uses) == 3 and not self.question.is_affordable((uses[0][1], uses[2][1])):
            uses = (uses[0], uses[2])
        if uses not in self._known:
            question = self.question
            sensors = {int(question.sensors[j]): (m, j) for m, j in uses}
            every = sorted(set(question.sensors.tolist()))
            free = "".join(f" u{t} w" for t in every if t not in sensors and question.sensor_prices[t])
            sums = "".join(f" {self.formula.reads[use]} +" for t, use in sensors.items() if question.sensor_prices[t])
            big = sum(question.sensor_prices) + 1
            self._known[uses] = self.lines.derive(f"{self.formula.budget}{free} {big} d{sums}")
        return self._known[uses]
