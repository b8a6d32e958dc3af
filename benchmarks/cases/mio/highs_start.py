"""HiGHS 1.16.0, alone: as soon as a start is given it says optimal, objective 0, where its own solution costs 1."""

import highspy

START = [0.0, 1, 1, 1, 1, 0, 1, 0, 0, 2, 0]  # keeps every row and costs 1


def main() -> None:
    """Print what HiGHS says with and without the start, and what its solution costs."""
    for start in (None, START):
        h = highspy.Highs()
        h.setOptionValue("output_flag", False)
        a, b, s, split, d, e, f, g = (h.addBinary() if k != 2 else h.addVariable(0, 1) for k in range(8))
        p, q, r = (h.addVariable() for _ in range(3))
        h.changeColCost(split.index, 1.0)
        h.changeColCost(r.index, 1.0)
        h.addConstrs(a + b == split, d + e == 1, f + g == 1, q - 2 * e == 2, p - 2 * e == 0)
        h.addConstrs(r - q - 4 * f >= -6, r + p - q - 4 * g >= -4, 2 * d - s <= 1, a + b - s >= 0)
        if start is not None:
            given = highspy.HighsSolution()
            given.col_value = start
            h.setSolution(given)
        h.run()
        claimed, paid = h.getInfo().objective_function_value, h.val(split) + h.val(r)
        print(f"HiGHS {h.version()}, {'with' if start else 'without'} a start: says {claimed:g}, costs {paid:g}")


if __name__ == "__main__":
    main()
