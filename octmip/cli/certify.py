"""Recount what a tree file claims, sample by sample, from the tree and its training data alone.

Exit code 0: every claim holds. 1: one does not, and one line says which. 2: a file cannot be read.
"""

import argparse
import dataclasses

from octmip.certificate import Certificate, certify
from octmip.cli.answer import print_json
from octmip.cli.arguments import add_json_argument
from octmip.errors import CertificateError, DataError
from octmip.problem import Problem
from octmip.report.text import solution_text
from octmip.table import read_table
from octmip.tree_file import TreeFile, finite_or_none, read_tree_file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip certify`."""
    parser.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out")
    parser.add_argument("data", metavar="DATA", help="the table that it was trained on, .csv or .parquet")
    parser.add_argument("--label", metavar="COL", help="column with the class (default: the one of the training)")
    parser.add_argument("--weights", metavar="COL", help="column with the weights (default: the one of the training)")
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Certify and show."""
    file = read_tree_file(arguments.tree)
    problem = _training_problem(arguments, file)
    certificate = certify(problem, file.solution)
    if arguments.json:
        print_json({"is_certified": True, "n_samples": problem.n_samples, **_fields(certificate)})
        return 0
    print("certified: every claim was recounted from tree and data alone")
    print(solution_text(file.solution, certificate, problem.n_samples))
    return 0


def _fields(certificate: Certificate) -> dict[str, object]:
    fields = dataclasses.asdict(certificate)
    return {k: finite_or_none(v) if isinstance(v, float) else v for k, v in fields.items()}


def _training_problem(arguments: argparse.Namespace, file: TreeFile) -> Problem:
    label = arguments.label or file.label_column
    weights_column = arguments.weights or file.weights_column
    if label is None:
        raise DataError(f"{arguments.tree} does not say which column held the label; name it with --label")
    table = read_table(arguments.data)
    labels = table.labels(label, file.class_names)
    weights = table.numbers([weights_column], "weight")[:, 0] if weights_column else None
    problem = file.problem(table.numbers(file.feature_names), labels, weights)
    if problem.digest() != file.sha256:
        raise CertificateError(
            f"{arguments.data} is not the table that {arguments.tree} was trained on: sha256 {problem.digest()[:12]}.. "
            f"of {problem.n_samples} samples, expected {file.sha256[:12]}... of {file.n_samples}; give that table"
        )
    return problem
