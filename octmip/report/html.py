"""A page about one tree, whole in itself: no script, no style sheet, no picture from elsewhere."""

import io
import shlex
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

from octmip.errors import needed_by
from octmip.formats.names import PAGE_POLICY, html_text, shown, visible
from octmip.formats.tree_file import TreeFile
from octmip.plot import counted_tree_figure
from octmip.report.text import narrow_scope, number, percent, tree_text
from octmip.tree import leaves

with needed_by("a page"):
    import matplotlib
    from matplotlib.figure import Figure

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1f2933; max-width: 60rem; margin: 2rem auto; padding: 0 1rem;
  overflow-wrap: anywhere; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
table { border-collapse: collapse; } th, td { padding: .2rem .8rem .2rem 0; text-align: left; vertical-align: top; }
td.n, th.n { text-align: right; } tr { border-bottom: 1px solid #e4e7eb; }
pre { background: #f5f7fa; padding: .8rem; overflow-x: auto; } svg { max-width: 100%; height: auto; }
.verdict { font-size: 1.1rem; } footer { color: #7b8794; margin-top: 2rem; font-size: .85rem; }
"""


def tree_page(file: TreeFile, source: str) -> str:
    """Return the HTML page of a tree file; `source` is its name, for the heading."""
    figure = counted_tree_figure(file.tree, file.leaf_counts, file.feature_names, file.class_names)
    sections = [
        f"<h1>Classification tree {html_text(source)}</h1>",
        f'<p class="verdict">{escape(_verdict(file))}</p>',
        inline_svg(figure),
        "<h2>In words</h2>",
        f"<pre>{escape(tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts))}</pre>",
        "<h2>Claims</h2>",
        _pairs(_claims(file)),
        "<h2>Settings</h2>",
        _pairs(_settings(file)),
        "<h2>Training samples: true class by predicted class</h2>",
        _confusion(file),
        f"<footer>Training data: {file.n_samples} samples, sha256 {html_text(file.sha256)}. The claims can be "
        f"recomputed with <code>octmip certify {html_text(shlex.quote(visible(source)))} DATA</code>.</footer>",
    ]
    head = f'<meta charset="utf-8">{PAGE_POLICY}<title>{html_text(source)}</title><style>{STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n' + "\n".join(sections) + "\n</body></html>\n"


def inline_svg(figure: Figure) -> str:
    """Return a figure as an SVG element that can stand in a page, text as text."""
    buffer = io.StringIO()
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "octmip"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def _verdict(file: TreeFile) -> str:
    solution, errors = file.solution, _errors(file)
    scope = narrow_scope(solution) or "trees of this kind"
    wrong = f"{errors} of {file.n_samples} training samples wrong ({percent(errors / file.n_samples)})."
    if solution.is_optimal:
        return f"Proven optimal among {scope}: none has an objective below {number(solution.objective)}. {wrong}"
    if np.isfinite(solution.bound):
        return (
            f"Objective {number(solution.objective)}; among {scope} none is below {number(solution.bound)} "
            f"(gap {percent(solution.gap)}). {wrong}"
        )
    return f"Objective {number(solution.objective)}, without a proof of how much better a tree can be. {wrong}"


def _errors(file: TreeFile) -> int:
    return int(file.leaf_counts.sum() - np.trace(_confusion_counts(file)))


def _confusion_counts(file: TreeFile) -> NDArray[np.int64]:
    """Return samples by true and predicted class, shape (n_classes, n_classes)."""
    labels = [leaf.label for leaf in leaves(file.tree)]
    confusion = np.zeros((len(file.class_names), len(file.class_names)), dtype=np.int64)
    for label, counts in zip(labels, file.leaf_counts, strict=True):
        confusion[:, label] += counts
    return confusion


def _claims(file: TreeFile) -> Iterable[tuple[str, Any]]:
    solution = file.solution
    yield "objective", number(solution.objective)
    yield "bound", number(solution.bound)
    yield "gap", percent(solution.gap)
    yield "stop", solution.stop
    yield "solver", f"{solution.solver} {solution.version}, seed {solution.seed}"
    yield "seconds", number(solution.seconds)
    yield "search nodes", solution.n_nodes
    yield from solution.details.items()


def _settings(file: TreeFile) -> Iterable[tuple[str, Any]]:
    for name, value in file.settings.items():
        if name in ("sensor_of_feature", "sensor_cost") and file.settings["sensor_budget"] is None:
            continue  # without a budget nothing depends on them
        if value is not None:
            yield name, value
    yield "label", file.label_column
    if file.weights_column:
        yield "weights", file.weights_column


def _pairs(pairs: Iterable[tuple[str, Any]]) -> str:
    rows = (f"<tr><th>{html_text(name)}</th><td>{html_text(value)}</td></tr>" for name, value in pairs)
    return f"<table>{''.join(rows)}</table>"


def _confusion(file: TreeFile) -> str:
    names = [escape(shown(name)) for name in file.class_names]
    head = "<tr><th></th>" + "".join(f'<th class="n">{name}</th>' for name in names) + "</tr>"
    rows = zip(names, _confusion_counts(file).tolist(), strict=True)
    body = "".join(f"<tr><th>{name}</th>{_numbers(counts)}</tr>" for name, counts in rows)
    return f"<table>{head}{body}</table>"


def _numbers(counts: Sequence[int]) -> str:
    return "".join(f'<td class="n">{count}</td>' for count in counts)
