"""What answers the cases of a set: one entry each, a column in every table."""

from collections.abc import Callable, Mapping

from benchmarks.blind.answers import Found, Task, diagnosed, twin
from benchmarks.blind.plain import plain
from octmip.gap import Campaign, read_campaign
from octmip.gap.twins import CachedTwin

Selector = Callable[[Task, CachedTwin, Campaign, Campaign | None], Found]

SELECTORS: Mapping[str, Selector] = {"diagnosis": diagnosed, "plain": plain}


def answer(task: Task) -> list[Found]:
    """Return what the scorer may see of one case: an answer with the commissioning run, and one without."""
    model, select = twin(task.refinement), SELECTORS[task.selector]
    campaign = read_campaign(task.place / "campaigns" / f"{task.name}.csv", model)
    own = task.place / "runs" / f"{task.name}.csv"
    run = read_campaign(own if own.exists() else task.place / "commissioning.csv", model)
    return [select(task, model, campaign, used) for used in (run, None)[: 1 + task.without]]
