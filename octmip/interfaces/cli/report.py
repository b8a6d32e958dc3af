"""Show a tree file or write it as a page: `octmip.interfaces.cli.options.report` says how the command is called."""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.tree_file import TreeFile, file_bytes, read_tree_file
from octmip.input.files import write_bytes
from octmip.input.names import visible
from octmip.interfaces.cli.answer import printable, verdict
from octmip.interfaces.cli.options.page import masthead_of, units_of_options
from octmip.interfaces.cli.options.report import EXPORTS, KINDS
from octmip.interfaces.cli.picture import PICTURES, picture_bytes
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.report.markdown import code_block, markdown_table
from octmip.interfaces.report.text import number, percent, tree_text

if TYPE_CHECKING:
    from octmip.interfaces.report.page import Masthead
    from octmip.interfaces.report.tree.evidence import Evidence

GREEDY = "greedy tree"


def run(arguments: argparse.Namespace) -> int:
    """Write the report."""
    file = read_tree_file(arguments.tree)
    kind = Path(arguments.out).suffix if arguments.out else ".txt"
    _check(arguments, kind)
    masthead = masthead_of(arguments, is_page=kind == ".html")
    units = _units(arguments.unit, file)
    evidence = None
    if arguments.data:
        with StageLine("recounting and comparing"):
            evidence = _evidence(arguments, file, has_depths=kind == ".html")
    if not arguments.out:
        print(printable(_words(file, evidence)))
        return 0
    write_bytes(arguments.out, _content(arguments, kind, file, evidence, units, masthead))
    return 0


def _check(arguments: argparse.Namespace, kind: str) -> None:
    if kind not in KINDS:
        raise DataError(f"--out {arguments.out} ends with {kind!r}; expected one of {', '.join(KINDS)}")
    if arguments.dark and kind not in PICTURES:
        raise DataError(f"--dark is for pictures; write one of {', '.join(PICTURES)} (a page follows its reader)")
    if arguments.histograms and (not arguments.data or kind not in (".html", *PICTURES)):
        kinds = ", ".join((".html", *PICTURES))
        raise DataError(f"--histograms needs the training table, and --out of {kinds}; give DATA behind TREE.json")
    if arguments.data and kind in EXPORTS:
        raise DataError(f"--out {arguments.out} holds the tree alone, without DATA; leave {arguments.data} out")
    if arguments.table and kind != ".sql":
        raise DataError("--table names the table of an expression; write one with --out TREE.sql, or leave it out")
    for option in ("test", "proof"):
        if getattr(arguments, option) is not None and not arguments.data:
            raise DataError(f"--{option} needs the table that the tree was trained on; give DATA behind TREE.json")
    if not arguments.seconds >= 0:
        raise DataError(f"--seconds is {arguments.seconds}; expected a number of 0 or more")


def _units(given: list[str], file: TreeFile) -> dict[str, str]:
    """Return the unit of each column of numbers."""
    numbers = _number_columns(file.columns, file)
    return units_of_options(given, numbers, "no column of numbers that the tree was trained on or predicts")


def _number_columns(columns: Columns | None, file: TreeFile) -> tuple[str, ...]:
    target = (file.target_column,) if file.loss.predicts == "number" and file.target_column else ()
    if columns is None:
        return (*map(str, file.feature_names), *target)
    return (*(column.name for column in columns.columns if column.kind == "number"), *target)


def _evidence(arguments: argparse.Namespace, file: TreeFile, has_depths: bool) -> "Evidence":
    from octmip.interfaces.cli.samples.training import read_test, read_training
    from octmip.interfaces.report.tree.evidence import gather, judged_by
    from octmip.trees.evidence.proof import check_proof

    training = read_training(file, arguments.data, source=arguments.tree)
    seconds = arguments.seconds if has_depths else 0.0
    found = gather(file, training.problem, seconds=seconds)
    found = replace(found, table=training.rows.frame)
    if arguments.proof:
        proof = check_proof(training.problem, arguments.proof, bound=file.solution.bound)
        found = replace(found, proof=proof)
    if arguments.test:
        samples = read_test(file, training.problem, arguments.test)
        return judged_by(found, file, samples, Path(arguments.test).name)
    if training.held_out is not None:
        return judged_by(found, file, training.held_out, f"{_name_of(arguments.data)}, held out before the training")
    return found


def _name_of(data: str) -> str:
    return "standard input" if data == "-" else Path(data).name


def _content(
    arguments: argparse.Namespace,
    kind: str,
    file: TreeFile,
    evidence: "Evidence | None",
    units: dict[str, str],
    masthead: "Masthead | None",
) -> bytes:
    if kind in EXPORTS:
        return _export(arguments, kind, file, units)
    if kind in PICTURES:
        return _drawing(arguments, kind, file, evidence, units)
    if kind == ".html":
        from octmip.interfaces.report.html import tree_page  # slow to import, and words do without

        data = _name_of(arguments.data) if arguments.data else None
        page = tree_page(
            file,
            Path(arguments.tree).name,
            evidence,
            data=data,
            units=units,
            masthead=masthead,
            histograms=arguments.histograms,
        )
        return page.encode()
    return ((_markdown(file, evidence) if kind == ".md" else _words(file, evidence)) + "\n").encode()


def _export(arguments: argparse.Namespace, kind: str, file: TreeFile, units: dict[str, str]) -> bytes:
    """Return the tree in the language of another machine; what that cannot hold is refused."""
    from octmip.monitor.export import Legend, c_source, onnx_model, sql_expression  # slow to import

    readings = replace(file.readings, units={**file.readings.units, **units})
    if kind == ".json":
        return file_bytes(replace(file, readings=readings))
    legend = Legend(file.target_column or "", readings)
    columns = file.feature_names if file.preparation is None else file.preparation.columns
    asked = (file.tree, columns, file.class_names)
    written: dict[str, Callable[[], bytes]] = {
        ".sql": lambda: f"{sql_expression(*asked, table=arguments.table, legend=legend)}\n".encode(),
        ".c": lambda: c_source(*asked, legend=legend).encode(),
        ".onnx": lambda: cast(bytes, onnx_model(*asked, legend=legend).SerializeToString()),
    }
    return written[kind]()


def _drawing(
    arguments: argparse.Namespace, kind: str, file: TreeFile, evidence: "Evidence | None", units: dict[str, str]
) -> bytes:
    from octmip.interfaces.plot.drawing import counted_tree_figure  # needs the extra "plot", which words do not
    from octmip.interfaces.report.tree.measure import measure_of
    from octmip.interfaces.report.tree.seen import Seen
    from octmip.interfaces.report.tree.words import Wording

    wording = Wording(file.feature_names, file.class_names, file.columns, units)
    seen = Seen.of(evidence.problem, file.tree, arguments.histograms) if evidence else None
    answer = measure_of(file).answer
    figure = counted_tree_figure(file.tree, wording, file.leaf_counts, answer=answer, seen=seen, dark=arguments.dark)
    return picture_bytes(figure, kind)


def _words(file: TreeFile, evidence: "Evidence | None") -> str:
    solution = file.solution
    claim = f"objective {number(solution.objective)}, bound {number(solution.bound)}, gap {percent(solution.gap)}"
    parts = [f"{claim} ({visible(solution.solver)}, stop: {solution.stop})", _tree(file)]
    if evidence is not None:
        parts.append("\n".join(_beside(file, evidence)))
    return "\n\n".join(parts)


def _tree(file: TreeFile) -> str:
    return tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts, file.columns)


def _beside(file: TreeFile, evidence: "Evidence") -> list[str]:
    """Return what the data say about this tree and the greedy one, a line each, and the verdict."""
    from octmip.interfaces.report.tree.measure import measure_of

    measure, held, greedy = measure_of(file), evidence.held_out, evidence.greedy.tree
    lines = [f"recounted on {evidence.problem.samples.n_samples} samples: every claim holds"]
    lines += [f"{name}: {measure.line(evidence, tree)}" for name, tree in (("this tree", file.tree), (GREEDY, greedy))]
    if held is not None:
        trees = (("this tree", held.tree), (GREEDY, held.greedy))
        lines += [f"{name}, held out ({visible(held.source)}): {measure.line(evidence, t, held)}" for name, t in trees]
    return [*lines, verdict(evidence.problem, file.solution, evidence.certificate)]


def _markdown(file: TreeFile, evidence: "Evidence | None") -> str:
    solution = file.solution
    row = {
        "objective": solution.objective,
        "bound": number(solution.bound),
        "gap": percent(solution.gap),
        "stop": str(solution.stop),
        "solver": solution.solver,
        "seconds": solution.seconds,
    }
    parts = [markdown_table([row]), code_block(_tree(file))]
    if evidence is not None:
        parts.append(code_block("\n".join(_beside(file, evidence))))
    return "\n\n".join(parts)
