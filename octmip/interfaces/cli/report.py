"""Show a tree file or write it as a page: `octmip.interfaces.cli.options.report` says how the command is called."""

import argparse
import io
from pathlib import Path
from typing import TYPE_CHECKING

from octmip.errors import DataError
from octmip.formats.columns import Columns
from octmip.formats.files import write_bytes
from octmip.formats.messages import shown
from octmip.formats.names import visible
from octmip.formats.tree_file import TreeFile, read_tree_file
from octmip.interfaces.cli.answer import ElapsedLine, printable, verdict
from octmip.interfaces.cli.arguments import MOST_THREADS
from octmip.interfaces.cli.options.report import KINDS
from octmip.interfaces.report.dot import tree_dot
from octmip.interfaces.report.markdown import code_block, markdown_table
from octmip.interfaces.report.text import number, percent, solution_text, tree_text
from octmip.trees.certificate import certify
from octmip.trees.tradeoff import score

if TYPE_CHECKING:
    from octmip.interfaces.report.tree.evidence import Evidence

WITH_DATA = (".html", ".md", ".txt")
DRAWN = (".dot", ".svg", ".png", ".pdf")


def run(arguments: argparse.Namespace) -> int:
    """Write the report."""
    file = read_tree_file(arguments.tree)
    kind = Path(arguments.out).suffix if arguments.out else ".txt"
    _check(arguments, kind)
    if file.loss.predicts == "number":
        _check_of_numbers(arguments, kind)
        words = _words_of_numbers(arguments, file)
        if not arguments.out:
            print(printable(words))
            return 0
        content = (code_block(words) if kind == ".md" else words) + "\n"
        write_bytes(arguments.out, _drawing(file, kind) if kind in DRAWN else content.encode())
        return 0
    units = _units(arguments.unit, file)
    evidence = None
    if arguments.data:
        with ElapsedLine("recounting and comparing"):
            evidence = _evidence(arguments, file, has_depths=kind == ".html")
    if not arguments.out:
        print(printable(_words(file, evidence)))
        return 0
    write_bytes(arguments.out, _content(arguments, kind, file, evidence, units))
    return 0


def _check(arguments: argparse.Namespace, kind: str) -> None:
    if kind not in KINDS:
        raise DataError(f"--out {arguments.out} ends with {kind!r}; expected one of {', '.join(KINDS)}")
    if arguments.data and kind not in WITH_DATA:
        raise DataError(f"{kind} shows the tree alone; leave DATA out, or write one of {', '.join(WITH_DATA)}")
    for option in ("test", "holdout", "proof"):
        if getattr(arguments, option) is not None and not arguments.data:
            raise DataError(f"--{option} needs the table that the tree was trained on; give DATA behind TREE.json")
    if not arguments.seconds >= 0:
        raise DataError(f"--seconds is {arguments.seconds}; expected a number of 0 or more")
    if not 1 <= arguments.threads <= MOST_THREADS:
        raise DataError(f"--threads is {shown(arguments.threads)}; expected 1 or more, and at most {MOST_THREADS}")


def _check_of_numbers(arguments: argparse.Namespace, kind: str) -> None:
    """Refuse what is said of classes alone: trees of numbers are reported in words and drawings."""
    if kind == ".html":
        raise DataError(
            f"--out {arguments.out} asks for a page, which only trees of classes have; expected one of "
            f"{', '.join(other for other in KINDS if other != kind)}; name such a file, or leave --out out"
        )
    for option in ("proof", "holdout"):
        if getattr(arguments, option) is not None:
            raise DataError(
                f"--{option} is for reports on classes, but {arguments.tree} predicts numbers; expected a tree of "
                "classes; leave it out"
            )


def _words_of_numbers(arguments: argparse.Namespace, file: TreeFile) -> str:
    from octmip.interfaces.cli.samples.training import read_test, read_training

    parts = [f"{visible(file.target_column or 'the target')} is predicted as\n", _tree(file)]
    if arguments.data:
        with ElapsedLine("recounting"):
            training = read_training(file, arguments.data, form=arguments.format, source=arguments.tree)
            certificate = certify(training.problem, file.solution)
        samples = read_test(file, training.problem, arguments.test) if arguments.test else training.held_out
        parts.append(f"\n{solution_text(training.problem, file.solution, certificate)}")
        if samples is not None:
            found = score(training.problem, file.tree, samples)
            parts.append(f"held out: {file.loss.words_of(found.measures, found.n_samples)}")
        parts.append(verdict(training.problem, file.solution, certificate))
    return "\n".join(parts)


def _units(given: list[str], file: TreeFile) -> dict[str, str]:
    """Return the unit of each column of numbers.

    Raises
    ------
    DataError
        a unit is given for a column that is none.
    """
    numbers = _number_columns(file.columns, file)
    units: dict[str, str] = {}
    for words in given:
        column, sign, unit = words.rpartition("=")
        if sign and column not in numbers:
            raise DataError(f"--unit names {shown(column)}, which is no column of numbers that the tree was trained on")
        units |= {column: unit} if sign else dict.fromkeys(numbers, unit)
    return units


def _number_columns(columns: Columns | None, file: TreeFile) -> tuple[str, ...]:
    if columns is None:
        return file.feature_names
    return tuple(column.name for column in columns.columns if column.kind == "number")


def _evidence(arguments: argparse.Namespace, file: TreeFile, has_depths: bool) -> "Evidence":
    from dataclasses import replace

    from octmip.interfaces.cli.samples.training import read_test, read_training
    from octmip.interfaces.report.tree.evidence import gather, judged_by, with_share_held_out
    from octmip.trees.proof import check_proof
    from octmip.trees.run import Run
    from octmip.trees.solution import Limits

    training = read_training(file, arguments.data, form=arguments.format, source=arguments.tree)
    seconds = arguments.seconds if has_depths else 0.0
    found = gather(file, training.problem, seconds=seconds, n_jobs=arguments.threads)
    found = replace(found, table=training.rows.frame)
    if arguments.proof:
        proof = check_proof(training.problem, arguments.proof, bound=file.solution.bound, n_jobs=arguments.threads)
        found = replace(found, proof=proof)
    if arguments.test:
        samples = read_test(file, training.problem, arguments.test)
        return judged_by(found, file, samples, Path(arguments.test).name)
    if training.held_out is not None and arguments.holdout is not None:
        raise DataError(f"{arguments.tree} was trained with samples held out already; leave --holdout out")
    if training.held_out is not None:
        return judged_by(found, file, training.held_out, f"{_name_of(arguments.data)}, held out before the training")
    if arguments.holdout is not None:
        run = Run(limits=Limits(seconds=arguments.seconds or 10.0), seed=file.solution.seed, n_jobs=arguments.threads)
        return with_share_held_out(found, arguments.holdout, run)
    return found


def _name_of(data: str) -> str:
    return "standard input" if data == "-" else Path(data).name


def _content(
    arguments: argparse.Namespace, kind: str, file: TreeFile, evidence: "Evidence | None", units: dict[str, str]
) -> bytes:
    if kind in DRAWN:
        return _drawing(file, kind)
    if kind == ".html":
        from octmip.interfaces.report.html import tree_page  # slow to import, and words do without

        data = _name_of(arguments.data) if arguments.data else None
        return tree_page(file, Path(arguments.tree).name, evidence, data=data, units=units).encode()
    return ((_markdown(file, evidence) if kind == ".md" else _words(file, evidence)) + "\n").encode()


def _drawing(file: TreeFile, kind: str) -> bytes:
    if kind == ".dot":
        return (tree_dot(file.tree, file.feature_names, file.class_names, file.columns) + "\n").encode()
    from octmip.interfaces.plot import counted_tree_figure  # needs the extra "plot", which words do not

    buffer = io.BytesIO()
    names = file.feature_names, file.class_names
    figure = counted_tree_figure(file.tree, file.leaf_counts, *names, columns=file.columns)
    figure.savefig(buffer, format=kind[1:], dpi=150)
    return buffer.getvalue()


def _words(file: TreeFile, evidence: "Evidence | None") -> str:
    solution = file.solution
    claim = f"objective {number(solution.objective)}, bound {number(solution.bound)}, gap {percent(solution.gap)}"
    parts = [f"{claim} ({visible(solution.solver)}, stop: {solution.stop})", _tree(file)]
    if evidence is not None:
        parts.append("\n".join(_beside(evidence)))
    return "\n\n".join(parts)


def _tree(file: TreeFile) -> str:
    return tree_text(file.tree, file.feature_names, file.class_names, file.leaf_counts, file.columns)


def _beside(evidence: "Evidence") -> list[str]:
    """Return what the data say about this tree and the greedy one, a line each."""
    n = evidence.problem.n_samples
    lines = [f"recounted on {n} samples: every claim holds"]
    for name, certificate in (("this tree", evidence.certificate), ("greedy tree", evidence.greedy_certificate)):
        share = percent(certificate.errors / n)
        lines.append(f"{name}: {certificate.errors} wrong ({share}), objective {number(certificate.objective)}")
    held = evidence.held_out
    if held is not None:
        for name, tree in (("this tree", held.tree), ("greedy tree", held.greedy)):
            wrong = held.n_samples - int(held.confusion(tree, evidence.problem.n_classes).trace())
            share = percent(wrong / held.n_samples)
            lines.append(f"{name}, held out: {wrong} of {held.n_samples} wrong ({share}; {visible(held.source)})")
    return lines


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
        parts.append(code_block("\n".join(_beside(evidence))))
    return "\n\n".join(parts)
