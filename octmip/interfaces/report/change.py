"""The page of an enriched monitor: what was found, where to inspect, which trees and splits changed, and the proofs."""

from collections.abc import Mapping, Sequence
from typing import Any

from octmip.interfaces.report.page import page_facts, render
from octmip.interfaces.report.text import number, percent


def change_page(change: Mapping[str, Any]) -> str:
    """Return the HTML page of a change.

    Parameters
    ----------
    change
        the content of change.json, as `octmip monitor --deployed` writes it.
    """
    watch, trees = change["watch"], change["trees"]
    return render(
        "change.html",
        facts=page_facts(change["readings"]),
        added=change["added"],
        readings=change["readings"],
        deployed=change["deployed"],
        verdict=_verdict(change),
        figures=_figures(change),
        places=[[one["name"] or "unknown", one["kind"], percent(one["probability"])] for one in watch["inspect"]],
        trees=[_tree_row(one) for one in trees],
        n_fresh=change["n_fresh_readings"],
        splits=[[one["state"], *_parts(words)] for one in trees for words in one["splits"]],
        told=[[level, str(count)] for level, count in change["told_since"].items()],
        digests=[[one["state"], one["sha256_deployed"] or "-", one["sha256"]] for one in trees],
    )


def _verdict(change: Mapping[str, Any]) -> str:
    """Return what was found, and whether the new library explains it."""
    again, n_later = change["alarm_of_enriched_library"], change["readings_since"]
    explained = f"The enriched library explains the {n_later} readings since."
    if again is not None:
        explained = f"The enriched library does not explain the readings since: alarm at reading {again} of {n_later}."
    return " ".join(part for part in (change["watch"]["words"], explained) if part)


def _figures(change: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return the key figures: alarm, states, trees, the twin's error."""
    watch, bound = change["watch"], change["largest_error_bound_of_twin"]
    kinds = [one["change"] for one in change["trees"]]
    alarm = "none" if watch["alarm"] is None else f"reading {watch['alarm']}"
    figures = [
        ("Alarm", alarm, f"of {watch['n_readings']} readings"),
        ("States", str(change["states"]), f"instead of {change['states_before']}"),
        ("Trees", f"{kinds.count('new')} new", f"{kinds.count('changed')} changed, {kinds.count('kept')} kept"),
    ]
    return figures if bound is None else [*figures, ("Twin's error there", number(bound), "proven bound")]


def _tree_row(one: Mapping[str, Any]) -> Sequence[str]:
    proof = (
        "proven best" if one["is_optimal"] else f"objective {number(one['objective'])}, bound {number(one['bound'])}"
    )
    before = "-" if one["deployed_off_by"] is None else f"{one['deployed_off_by']:.3g}"
    error = "-" if one["deployed_off_by"] is None else f"{one['standard_error']:.2g}"
    return [one["state"], one["change"], before, f"{one['retrained_off_by']:.3g}", error, proof]


def _parts(words: str) -> Sequence[str]:
    """Return place, deployed and present split of one change."""
    place, _, rest = words.partition(": ")
    before, _, now = rest.partition(" -> ")
    return [place, before, now]
