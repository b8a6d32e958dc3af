"""The table of policies as a picture."""

from collections.abc import Sequence

from matplotlib.figure import Figure

LEAST = 0.001
"""Loss that is drawn for any smaller one [%]."""


def picture(rows: Sequence[dict[str, object]]) -> Figure:
    """Return steps to the goal and losses of every policy, a panel a kind of mission."""
    kinds = list(dict.fromkeys(str(row["mission"]) for row in rows))
    figure = Figure(figsize=(3.6 * len(kinds) + 1.5, 3.8), layout="constrained")
    axes = figure.subplots(1, len(kinds), sharey=True, squeeze=False)[0]
    for axis, kind in zip(axes, kinds, strict=True):
        own = [row for row in rows if row["mission"] == kind]
        for k, row in enumerate(own):
            steps, lost = row["steps to the goal"], max(LEAST, float(str(row["lost %"])))
            if steps is not None:
                axis.plot(float(str(steps)), lost, "o", color=f"C{k}", markersize=13 - k)  # rings where some agree
            axis.plot([], [], "o", color=f"C{k}", label=str(row["policy"]))
        axis.set_yscale("log")
        axis.set(xlabel="steps to the goal of those that arrive", title=kind, ylim=(LEAST / 1.5, 150.0))
        axis.grid(alpha=0.3)
    axes[0].set_ylabel(f"aircraft lost [%], at least {LEAST:g} drawn")
    axes[-1].legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure
