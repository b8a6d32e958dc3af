"""Files of regression trees: certify, predict and report."""

import argparse
import csv
import dataclasses
import io
import math
import sys
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from octmip.certificate import Certificate, certify
from octmip.cli.answer import ElapsedLine, print_json, printable, then_written
from octmip.cli.regression.question import Errors, features_of, read_numbers, tested
from octmip.cli.regression.words import errors_json, errors_text, numbers_text, numbers_tree_text, numbers_verdict
from octmip.cli.samples.names import one_name
from octmip.errors import CertificateError, DataError
from octmip.formats.files import write_bytes
from octmip.formats.names import visible, visible_lines
from octmip.formats.table import Table, read_table
from octmip.formats.tree_file import TreeFile
from octmip.problem import Problem
from octmip.proof import ProofReport, check_proof
from octmip.report.text import number
from octmip.tree import predict_values


def certify_numbers(arguments: argparse.Namespace, file: TreeFile) -> int:
    """Certify a regression tree and show what was recounted."""
    _refuse(arguments, {"label": "a class", "weights": "another column of weights"})
    with ElapsedLine("certifying"):
        problem = read_numbers(file, arguments.data, arguments.format, arguments.tree)
        certificate = _certified(problem, file)
    test, proof = _tested(arguments, file, problem), _checked_proof(arguments, file, problem)
    if arguments.json:
        held = {} if test is None else {"held_out": errors_json(test)}
        log = {} if proof is None else {"proof": dataclasses.asdict(proof)}
        print_json({"is_certified": True, "n_samples": problem.n_samples, **certificate.to_json(), **held, **log})
        return 0
    known = "the bound is its solver's claim" if proof is None else "its bound was checked in the proof log"
    print(f"certified: the tree was recomputed from tree and data alone; {known}")
    print(printable(_text(file, problem, certificate)))
    if test is not None:
        print(f"held out, {errors_text(test)}")
    if proof is not None:
        print(f"proof: no tree costs less than {number(proof.bound)}; {proof.n_lines} lines, {proof.seconds:.3g} s")
    print(printable(numbers_verdict(problem, file.solution, certificate)))
    return 0


def predict_numbers(arguments: argparse.Namespace, file: TreeFile) -> int:
    """Apply a regression tree to a table."""
    _refuse(arguments, {"probabilities": "shares of classes", "label": "a class; expected the target in the table"})
    trained = None if file.preparation is None else file.preparation.index
    table = read_table(arguments.data, arguments.format, as_text=arguments.index or trained)
    predictions = predict_values(file.tree, features_of(file.preparation, file.feature_names, table))
    errors = _errors(file, table, predictions)
    name = one_name(table, arguments.index) if arguments.index else trained if trained in table.columns else None
    index = None if name is None else [str(cell) for cell in table.column(name, "index").tolist()]
    content = _csv(name, index, predictions)
    with then_written(arguments.out, partial(write_bytes, content=content.encode()), is_quiet=True):
        if arguments.json:
            names = {} if index is None else {"index": index}
            held = {} if errors is None else {k: v for k, v in errors_json(errors).items() if k != "n_samples"}
            print_json({"n_samples": len(predictions), **held, **names, "predictions": predictions.tolist()})
            return 0
        if not arguments.out:
            print(visible_lines(content) if sys.stdout.isatty() else content, end="")
        if errors is not None:
            print(errors_text(errors), file=sys.stderr)
    return 0


def report_numbers(arguments: argparse.Namespace, file: TreeFile) -> int:
    """Show a regression tree in words, or write them as text or Markdown."""
    suffix = Path(arguments.out).suffix.lower() if arguments.out else ".txt"
    if suffix not in (".txt", ".md"):
        raise DataError(
            f"--out {arguments.out} asks for {suffix or 'no ending'}, but a regression tree is reported in words; "
            "expected .txt or .md; name such a file, or leave --out out"
        )
    _refuse(arguments, {"proof": "a log of classes", "holdout": "shares of classes"})
    columns = None if file.preparation is None or file.preparation.columns.is_plain else file.preparation.columns
    text = numbers_tree_text(file.tree, file.feature_names, file.leaf_counts, columns)
    text = f"{file.target_column or 'the target'} is predicted as\n\n{text}\n"
    if arguments.data:
        problem = read_numbers(file, arguments.data, arguments.format, arguments.tree)
        certificate = _certified(problem, file)
        test = _tested(arguments, file, problem)
        held = "" if test is None else f"held out, {errors_text(test)}\n"
        text += f"\n{_text(file, problem, certificate)}\n{held}{numbers_verdict(problem, file.solution, certificate)}\n"
    if not arguments.out:
        print(printable(text), end="")
        return 0
    fence = "```" if suffix == ".md" else ""
    write_bytes(arguments.out, (f"{fence}\n{text}{fence}\n" if fence else text).encode())
    print(f"written to {visible(arguments.out)}")
    return 0


def _refuse(arguments: argparse.Namespace, options: dict[str, str]) -> None:
    for name, about in options.items():
        if getattr(arguments, name, None) not in (None, False):
            raise DataError(
                f"--{name} is about {about}, but {arguments.tree} holds a regression tree; expected options of such a "
                f"tree; leave --{name} out"
            )


def _certified(problem: Problem, file: TreeFile) -> Certificate:
    return certify(problem, file.solution)


def _tested(arguments: argparse.Namespace, file: TreeFile, problem: Problem) -> Errors | None:
    if not arguments.test:
        return None
    if file.preparation is None:
        raise CertificateError(
            f"{arguments.tree} does not say how its table was prepared, so --test cannot be read alike; write the file "
            "again with octmip solve --target"
        )
    return tested(arguments.test, problem, file.preparation, file.tree)


def _checked_proof(arguments: argparse.Namespace, file: TreeFile, problem: Problem) -> ProofReport | None:
    if not arguments.proof:
        return None
    with ElapsedLine("checking the proof"):
        return check_proof(problem, arguments.proof, bound=file.solution.bound)


def _text(file: TreeFile, problem: Problem, certificate: Certificate) -> str:
    return numbers_text(file.solution, certificate, problem.loss.name, problem.n_samples)


def _errors(file: TreeFile, table: Table, predictions: NDArray[np.float64]) -> Errors | None:
    """Return the errors in the rows that have a target; None where the table has no such column."""
    if file.target_column is None or file.target_column not in table.columns:
        return None
    is_missing = table.missing(file.target_column, "target")
    if is_missing.all():
        return None
    known = table.rows(~is_missing).with_plain_numbers(file.target_column)
    misses = np.abs(predictions[~is_missing] - known.numbers([file.target_column], "target")[:, 0])
    largest = float(misses.max()) or 1.0  # squares of its shares do not overflow
    return Errors(len(misses), float(misses.mean()), largest * math.sqrt(float(((misses / largest) ** 2).mean())))


def _csv(name: str | None, index: list[str] | None, predictions: NDArray[np.float64]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*([] if index is None else [name]), "prediction"])
    for row, value in enumerate(predictions.tolist()):
        writer.writerow([*([] if index is None else [index[row]]), repr(value)])
    return text.getvalue()
