"""The formula of a problem: which trees there are, what they cost, as pseudo-Boolean constraints (OPB).

minimise   sum_i price_i * wrong[0, i]  +  penalty * sum_m split[m]

node m = 0 (root), 1 (its left side), 2 (its right side); column j; rank r of a column; sample i; label k

left[m, j, r]   a, b, c   node m splits on column j, and samples of rank r go left   (r up to the last rank but one)
split[m]        s         node m splits; a node that does not split sends every sample to the right
wrong[m, i]     w         the subtree at node m answers sample i wrongly
label[m, k]     A, B ...  label of the left leaf (A, C) and of the right leaf (B, D) of a node whose sides are leaves

order     left[m, j, r - 1]  or  not left[m, j, r]
one       split[m] = sum_j left[m, j, 0];  split[1], split[2] <= split[0];  each leaf has one label
goes left   wrong[m, i]  or  not left[m, j, rank_ij]  or  (left side answers i rightly)
goes right  wrong[m, i]  or  left[m, j, rank_ij]  or  not left[m, j, 0]  or  (right side answers i rightly)
no split    wrong[m, i]  or  split[m]  or  (right side answers i rightly)

Where leaves have a least size above 1, for all samples i (those that cost nothing have no `wrong`):

at[m, i]        g     sample i goes to node m = 1, 2, no claim where it is false
in[m, side, i]  x, z  and there to the leaf on the left, on the right
each leaf       sum_i in[m, side, i] >= leaf_size; on the left if node m splits, on the right (m = 1) if the root does

Where there is a budget: reads[t] (u) for each sensor t;  reads[t] or not left[m, j, 0];  sum_t cost_t reads[t] <= it.
Columns whose sensor alone is above it have no variables.

A side that is a leaf answers i rightly by `label[m, label_i]`; one that is a node by `not wrong[side, i]`. Constraints
are numbered from 1 in the order in which they are written; a proof names them by these numbers.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from octmip.pseudo_boolean.question import Question

NODE_LETTERS = "abc"
LEAF_LETTERS = {(0, "left"): "A", (0, "right"): "B"} | {
    (1, "left"): "A",
    (1, "right"): "B",
    (2, "left"): "C",
    (2, "right"): "D",
}
SIDE_NODES = {"left": 1, "right": 2}


def left(m: int, j: int, r: int) -> str:
    """Return the variable of node m splitting on column j with rank r on the left."""
    return f"{NODE_LETTERS[m]}{j}_{r}"


def label(m: int, side: str, k: int) -> str:
    """Return the variable of label k at a leaf of node m."""
    return f"{LEAF_LETTERS[m, side]}{k}"


@dataclass(slots=True)
class Formula:
    """Constraints of a question, and the numbers by which a proof names them.

    Attributes
    ----------
    question
        what is asked.
    lines
        constraints, in order.
    order
        (m, j, r) -> number of left[m, j, r - 1] or not left[m, j, r].
    some, single
        m -> number of "a split has a column", "a column has a split, and there is one at most".
    below
        m -> number of split[m] <= split[0].
    one_label
        (m, side) -> number of "one label at most".
    goes
        (m, side) -> {(j, i): number}.
    unsplit
        (m, i) -> number.
    reaches
        m -> {(j, i): number of "in at[m, i], or the root's cut of column j says so"}.
    arrives
        (m, side) -> {i: number of at[m, i] or not in[m, side, i]}.
    enters
        (m, side) -> {(j, i): number of "not in[m, side, i], or the cut of column j says so"}.
    sizes
        (m, side) -> number of "at least so many samples".
    reads
        (m, j) -> number of reads[sensor of j] or not left[m, j, 0].
    budget
        number of the budget.
    """

    question: Question
    lines: list[str] = field(default_factory=list)
    order: dict[tuple[int, int, int], int] = field(default_factory=dict)
    some: dict[int, int] = field(default_factory=dict)
    single: dict[int, int] = field(default_factory=dict)
    below: dict[int, int] = field(default_factory=dict)
    one_label: dict[tuple[int, str], int] = field(default_factory=dict)
    goes: dict[tuple[int, str], dict[tuple[int, int], int]] = field(default_factory=dict)
    unsplit: dict[tuple[int, int], int] = field(default_factory=dict)

    reaches: dict[int, dict[tuple[int, int], int]] = field(default_factory=dict)
    arrives: dict[tuple[int, str], dict[int, int]] = field(default_factory=dict)
    enters: dict[tuple[int, str], dict[tuple[int, int], int]] = field(default_factory=dict)
    sizes: dict[tuple[int, str], int] = field(default_factory=dict)
    reads: dict[tuple[int, int], int] = field(default_factory=dict)
    budget: int = 0

    def __post_init__(self) -> None:
        for m in self.question.nodes:
            self._add_cuts(m)
            self._add_labels(m)
            self._add_samples(m)
        if self.question.leaf_size > 1:
            for m in self.question.stumps:
                self._add_routes(m)
                self._add_sizes(m)
        if self.question.sensor_limit is not None:
            self._add_budget(self.question.sensor_limit)

    def _add(self, terms: str, least: int = 1) -> int:
        self.lines.append(f"{terms} >= {least};")
        return len(self.lines)

    def _add_cuts(self, m: int) -> None:
        question = self.question
        for j, n_ranks in enumerate(question.n_ranks.tolist()):
            for r in range(1, n_ranks - 1):
                self.order[m, j, r] = self._add(f"1 {left(m, j, r - 1)} 1 ~{left(m, j, r)}")
        uses = [left(m, j, 0) for j in range(question.n_columns)]
        self.some[m] = self._add(" ".join([f"1 ~s{m}", *(f"1 {use}" for use in uses)]))
        self.single[m] = self._add(" ".join([f"1 s{m}", *(f"1 ~{use}" for use in uses)]), len(uses))
        if m:
            self.below[m] = self._add(f"1 s0 1 ~s{m}")

    def _add_labels(self, m: int) -> None:
        if m not in self.question.stumps:
            return
        n_classes = self.question.n_classes
        for side in ("left", "right"):
            names = [label(m, side, k) for k in range(n_classes)]
            self._add(" ".join(f"1 {name}" for name in names))
            self.one_label[m, side] = self._add(" ".join(f"1 ~{name}" for name in names), n_classes - 1)

    def _right_answer(self, m: int, side: str, i: int) -> str:
        if m in self.question.stumps:
            return label(m, side, int(self.question.labels[i]))
        return f"~w{SIDE_NODES[side]}_{i}"

    def _add_samples(self, m: int) -> None:
        question = self.question
        lefts, rights = self.goes[m, "left"], self.goes[m, "right"] = {}, {}
        last = (question.n_ranks - 1).tolist()
        ranks = question.ranks.T.tolist()
        for i in range(question.n_samples):
            on_left, on_right = (f"1 w{m}_{i} 1 {self._right_answer(m, side, i)}" for side in ("left", "right"))
            self.unsplit[m, i] = self._add(f"{on_right} 1 s{m}")
            for j, r in enumerate(ranks[i]):
                if r < last[j]:
                    lefts[j, i] = self._add(f"{on_left} 1 ~{left(m, j, r)}")
                if r > 0:
                    cut = "" if r == last[j] else f" 1 {left(m, j, r)}"
                    rights[j, i] = self._add(f"{on_right}{cut} 1 ~{left(m, j, 0)}")

    def _says_left(self, m: int, j: int, i: int) -> str | None:
        """Return "not split on column j, or sample i goes left"; None where it always does."""
        r = int(self.question.all_ranks[j, i])
        if r == 0:
            return None
        return f"1 ~{left(m, j, 0)}" + (f" 1 {left(m, j, r)}" if r < self.question.n_ranks[j] - 1 else "")

    def _says_right(self, m: int, j: int, i: int) -> str | None:
        """Return "column j does not send sample i left"; None where it never does."""
        r = int(self.question.all_ranks[j, i])
        return f"1 ~{left(m, j, r)}" if r < self.question.n_ranks[j] - 1 else None

    def _clauses(self, name: str, says: Callable[[int, int, int], str | None], m: int, i: int) -> dict[int, int]:
        """Add "not `name`, or the cut says so" for each column; return column -> number."""
        said = [(j, says(m, j, i)) for j in range(self.question.n_columns)]
        return {j: self._add(f"1 ~{name} {clause}") for j, clause in said if clause is not None}

    def _add_routes(self, m: int) -> None:
        if m:
            says = self._says_left if m == 1 else self._says_right
            rows = [(i, self._clauses(f"g{m}_{i}", says, 0, i)) for i in range(self.question.all_ranks.shape[1])]
            self.reaches[m] = {(j, i): number for i, row in rows for j, number in row.items()}

    def _add_sizes(self, m: int) -> None:
        least = self.question.leaf_size
        samples = range(self.question.all_ranks.shape[1])
        for side, letter, says in (("left", "x", self._says_left), ("right", "z", self._says_right)):
            rows = [(i, self._clauses(f"{letter}{m}_{i}", says, m, i)) for i in samples]
            self.enters[m, side] = {(j, i): number for i, row in rows for j, number in row.items()}
            if m:
                self.arrives[m, side] = {i: self._add(f"1 ~{letter}{m}_{i} 1 g{m}_{i}") for i in samples}
            split = {"left": f" {least} ~s{m}", "right": f" {least} ~s0" if m == 1 else ""}[side]
            members = " ".join(f"1 {letter}{m}_{i}" for i in samples)
            self.sizes[m, side] = self._add(f"{members}{split}", least)

    def _add_budget(self, limit: int) -> None:
        question = self.question
        for m in question.nodes:
            for j, t in enumerate(question.sensors.tolist()):
                self.reads[m, j] = self._add(f"1 u{t} 1 ~{left(m, j, 0)}")
        prices = {t: question.sensor_prices[t] for t in sorted(set(question.sensors.tolist()))}
        terms = " ".join(f"{price} ~u{t}" for t, price in prices.items() if price)
        self.budget = self._add(terms, max(0, sum(prices.values()) - limit))

    @property
    def objective(self) -> list[tuple[int, str]]:
        """Prices and variables of the objective."""
        question = self.question
        terms = [(price, f"w0_{i}") for i, price in enumerate(question.prices.tolist())]
        return terms + [(question.penalty, f"s{m}") for m in question.nodes if question.penalty]

    def variables(self) -> Iterator[str]:
        """Yield every variable once."""
        question = self.question
        for m in question.nodes:
            for j, n_ranks in enumerate(question.n_ranks.tolist()):
                yield from (left(m, j, r) for r in range(n_ranks - 1))
            yield f"s{m}"
            yield from (f"w{m}_{i}" for i in range(question.n_samples))
            if m in question.stumps:
                yield from (label(m, side, k) for side in ("left", "right") for k in range(question.n_classes))
            if m in question.stumps and question.leaf_size > 1:
                letters = "xzg" if m else "xz"
                yield from (f"{letter}{m}_{i}" for letter in letters for i in range(question.all_ranks.shape[1]))
        if question.sensor_limit is not None:
            yield from (f"u{t}" for t in sorted(set(question.sensors.tolist())))

    def opb(self) -> str:
        """Return the file."""
        n_variables = sum(1 for _ in self.variables())
        head = f"* #variable= {n_variables} #constraint= {len(self.lines)}\n"
        objective = " ".join(f"{price} {name}" for price, name in self.objective)
        return "\n".join([f"{head}min: {objective};", *self.lines, ""])
