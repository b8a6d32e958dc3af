"""Recompute what a tree file claims, sample by sample, from the tree and its training data alone.

With --proof, a checker that knows no solver also checks a proof log: that no tree of the problem costs less than the
bound. Exit code 0: every claim holds. 1: one does not, and one line says which. 2: a file cannot be read.
"""

import argparse
import dataclasses

from octmip.certificate import Certificate, certify
from octmip.cli.answer import print_json, printable
from octmip.cli.arguments import MOST_THREADS, add_json_argument
from octmip.errors import CertificateError, DataError
from octmip.formats.checked import shown
from octmip.formats.table import read_table
from octmip.formats.tree_file import TreeFile, finite_or_none, read_tree_file
from octmip.problem import Problem
from octmip.proof import ProofReport, check_proof
from octmip.report.text import number, solution_text


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `octmip certify`."""
    parser.add_argument("tree", metavar="TREE.json", help="tree file of octmip solve --out")
    parser.add_argument("data", metavar="DATA", help="the table that it was trained on, .csv or .parquet")
    parser.add_argument("--label", metavar="COL", help="column with the class (default: that of the training)")
    parser.add_argument("--weights", metavar="COL", help="column with the weights (default: that of the training)")
    parser.add_argument("--proof", metavar="LOG", help="also check this proof log of octmip solve --proof")
    parser.add_argument("--threads", metavar="N", type=int, default=1, help="threads of that check (default 1)")
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Certify and show."""
    file = read_tree_file(arguments.tree)
    problem = _training_problem(arguments, file)
    certificate = certify(problem, file.solution)
    proof = _checked_proof(arguments, problem, file)
    if arguments.json:
        log = {} if proof is None else {"proof": dataclasses.asdict(proof)}
        print_json({"is_certified": True, "n_samples": problem.n_samples, **_fields(certificate), **log})
        return 0
    print("certified: every claim was recomputed from tree and data alone")
    print(printable(solution_text(file.solution, certificate, problem.n_samples)))
    if proof is not None:
        print(f"proof: no tree costs less than {number(proof.bound)}; {proof.n_lines} lines, {proof.seconds:.3g} s")
    return 0


def _checked_proof(arguments: argparse.Namespace, problem: Problem, file: TreeFile) -> ProofReport | None:
    if not 1 <= arguments.threads <= MOST_THREADS:
        raise DataError(f"--threads is {shown(arguments.threads)}; expected 1 or more, and at most {MOST_THREADS}")
    if not arguments.proof:
        return None
    return check_proof(problem, arguments.proof, bound=file.solution.bound, n_jobs=arguments.threads)


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
