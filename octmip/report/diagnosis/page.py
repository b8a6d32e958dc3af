"""The report: one self-contained HTML page, no script, no outside file; figures are inline SVG."""

import numpy as np
from numpy.typing import NDArray

from octmip.formats.names import PAGE_POLICY
from octmip.formats.names import html_text as escape
from octmip.gap.causes import UNKNOWN
from octmip.gap.diagnosis import Diagnosis
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel
from octmip.report.diagnosis.pictures import bars, gauge_map
from octmip.report.diagnosis.words import (
    cause_words,
    closed_words,
    flipping_nodes,
    likely,
    page_of_words,
    percent,
    verdict,
    where_lines,
)

Floats = NDArray[np.float64]

STYLE = """
body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#1b1f24;background:#fff}
h1{font-size:1.5rem}h2{font-size:1.15rem;margin-top:2rem;border-bottom:1px solid #d0d7de}
.verdict{font-size:1.15rem;background:#f3f6fa;border-left:4px solid #2f6db3;padding:.6rem 1rem}
table{border-collapse:collapse;width:100%;font-size:.92rem}td,th{padding:.3rem .5rem;border-bottom:1px solid #e5e9ee;
text-align:left;vertical-align:top}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
figure{margin:1rem 0}figcaption{font-size:.9rem;color:#57606a}svg{max-width:100%;height:auto}
pre{white-space:pre-wrap;background:#f6f8fa;padding:1rem;font-size:.74rem}
"""


def report_page(diagnosis: Diagnosis) -> str:
    """Return the page: verdict, maps before and after, causes, shrinkage, tree nodes, next test, all words."""
    parts = [
        f'<p class="verdict">{escape(verdict(diagnosis))}</p>',
        _maps(diagnosis),
        _causes(diagnosis),
        _shrinkage(diagnosis),
        _nodes(diagnosis),
        _next(diagnosis),
        f"<h2>All in words</h2><pre>{escape(page_of_words(diagnosis))}</pre>",
    ]
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'{PAGE_POLICY}<meta name="viewport" content="width=device-width,initial-scale=1">'
        "<title>Diagnosis of the sim-to-real gap</title>"
        f"<style>{STYLE}</style></head><body><h1>Diagnosis of the sim-to-real gap</h1>{''.join(parts)}</body></html>"
    )


def _maps(diagnosis: Diagnosis) -> str:
    """Return the gauges on the structure, coloured by residual at the greatest load, before and after."""
    model, after = _after_first_cause(diagnosis)
    inputs = model.inputs
    greatest = max(inputs.load_factors.tolist(), key=abs)
    top = model.load_factors == greatest
    limit = float(np.abs(model.residual[top]).max(initial=1.0))
    outline = getattr(inputs.twin.twin, "outline", None)
    maps = []
    for title, residual in (("before", model.residual), ("after", after)):
        drawn = gauge_map(_points(inputs), _by_gauge(model, residual, top), inputs.campaign.gauges, limit, outline)
        caption = (
            f"Residual {title} the first cause is added, at load factor {greatest:g} (microstrain, calibrated twin; "
            "red: more compression than the twin; span to the right, aft down, not to scale)"
        )
        maps.append(f"<figure>{drawn}<figcaption>{caption}</figcaption></figure>")
    lines = "".join(f"<p>{escape(line)}</p>" for line in where_lines(diagnosis) if not line.startswith("Tree node"))
    return f"<h2>Where</h2>{lines}{''.join(maps)}"


def _after_first_cause(diagnosis: Diagnosis) -> tuple[LinearModel, Floats]:
    """Return the model that is drawn, and the residuals (n,) [microstrain] once the first cause is added."""
    first = diagnosis.which[0]
    if not first.judged.members or UNKNOWN in first.effects:
        model = diagnosis.posterior.model
        return model, model.residual
    model, own = first.judged.model, first.judged.fit
    return model, model.residual - model.signatures[:, list(own.members)] @ own.size


def _points(inputs: Inputs) -> Floats:
    """Return the places (n_gauges, 2) [m] of the campaign's gauges; a row of them where the twin does not say."""
    places = inputs.twin.gauge_positions
    if places is not None:
        return places[list(inputs.order), :2]
    n = len(inputs.order)
    return np.stack([np.zeros(n), np.arange(n, dtype=np.float64)], axis=1)


def _by_gauge(model: LinearModel, residual: Floats, chosen: NDArray[np.bool_]) -> Floats:
    """Return the mean of the chosen residuals (n,) at each gauge (n_gauges,), NaN where there is none."""
    rows = [chosen & (model.gauge == g) for g in range(len(model.inputs.order))]
    return np.array([float(residual[here].mean()) if here.any() else np.nan for here in rows])


def _causes(diagnosis: Diagnosis) -> str:
    shown = [cause for cause in diagnosis.which if cause.probability >= 0.005]
    labels = [" + ".join(cause.effects) or "no effect" for cause in shown]
    rows = "".join(
        f'<tr><td class="n">{escape(likely(c.probability))}</td><td>{escape(cause_words(c))}</td>'
        f"<td>{escape('; '.join(' / '.join(t.effects) for t in c.confounded)) or 'nothing'}</td></tr>"
        for c in shown
    )
    reasons = "".join(f"<p>{escape(' / '.join(t.effects))}: {escape(t.reason)}</p>" for t in diagnosis.ambiguity)
    return (
        f"<h2>Which</h2><figure>{bars(labels, [c.probability for c in shown], 1.0, likely)}</figure>"
        '<table><tr><th class="n">probability</th><th>cause</th><th>cannot be told apart</th></tr>'
        f"{rows}</table>{reasons}<p>Something outside the library: {escape(likely(diagnosis.unknown_probability))}</p>"
    )


def _shrinkage(diagnosis: Diagnosis) -> str:
    s = diagnosis.shrinkage
    if s is None:
        return "<h2>How far</h2><p>No effect was added, so the gap does not close.</p>"
    if not s.held_out:
        return f"<h2>How far</h2><p>{escape(closed_words(s))}</p>"
    labels, values = [], []
    for held in s.held_out:
        labels += [f"{held.name}, before", f"{held.name}, after"]
        values += [held.before, held.after]
    figure = bars(labels, values, max([*values, 1e-9]), lambda v: f"{v:.1f} microstrain", ("#c5ccd3", "#2f6db3"))
    return (
        f"<h2>How far</h2><p>{escape(closed_words(s))}</p><figure>{figure}<figcaption>Each load or test predicted from "
        "the others, root mean square gap, noise taken off (grey: before, blue: after)</figcaption></figure>"
    )


def _nodes(diagnosis: Diagnosis) -> str:
    nodes = flipping_nodes(diagnosis)
    if not diagnosis.where.nodes:
        return ""
    if not nodes:
        return "<h2>Tree nodes that flip</h2><p>None: readings of the asset go the same way as the twin's.</p>"
    rows = "".join(
        f'<tr><td>{escape(n.path or "root")}</td><td>{escape(n.words)}</td><td class="n">{percent(n.simulated)}</td>'
        f'<td class="n">{percent(n.real)}</td><td class="n">{percent(n.share)}</td></tr>'
        for n in nodes
    )
    return (
        '<h2>Tree nodes that flip</h2><table><tr><th>node</th><th>split</th><th class="n">left, twin</th>'
        f'<th class="n">left, asset</th><th class="n">of all readings</th></tr>{rows}</table>'
    )


def _next(diagnosis: Diagnosis) -> str:
    if not diagnosis.next_test:
        return "<h2>Next test</h2><p>Little uncertainty remains among the effects of the library.</p>"
    rows = "".join(
        f'<tr><td>{escape(p.words)}</td><td class="n">{p.information / np.log(2):.2f} bits</td><td class="n">{p.cost:g}'
        f"</td></tr>"
        for p in diagnosis.next_test
    )
    return (
        '<h2>Next test</h2><table><tr><th>test</th><th class="n">expected information</th><th class="n">cost</th></tr>'
        f"{rows}</table>"
    )
