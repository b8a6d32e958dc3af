"""Recompute what a tree file claims: `octmip.interfaces.cli.options.certify` says how the command is called."""

import argparse
import dataclasses

from octmip.errors import CertificateError, DataError
from octmip.formats.tree_file import TreeFile, read_tree_file
from octmip.input.messages import shown
from octmip.interfaces.cli.answer import print_json, printable, score_json, verdict
from octmip.interfaces.cli.arguments import MOST_THREADS
from octmip.interfaces.cli.samples.training import Training, read_test, read_training
from octmip.interfaces.cli.stages import StageLine
from octmip.interfaces.report.text import number, solution_text
from octmip.trees.answer.certificate import certify
from octmip.trees.evidence.proof import ProofReport, check_proof
from octmip.trees.question.problem import Problem
from octmip.trees.tradeoff import Samples, Score, score


def run(arguments: argparse.Namespace) -> int:
    """Certify and show."""
    file = read_tree_file(arguments.tree)
    with StageLine("certifying"):
        training = read_training(
            file,
            arguments.data,
            label=arguments.label,
            weights=arguments.weights,
            source=arguments.tree,
        )
        certificate = certify(training.problem, file.solution)
        held_out = _checked_held_out(arguments, file, training)
    proof = _checked_proof(arguments, training.problem, file)
    if arguments.json:
        log = {} if proof is None else {"proof": dataclasses.asdict(proof)}
        held = {} if held_out is None else {"held_out": score_json(held_out)}
        n_samples = training.problem.samples.n_samples
        print_json({"is_certified": True, "n_samples": n_samples, **certificate.to_json(), **held, **log})
        return 0
    known = "the bound is its solver's claim" if proof is None else "its bound was checked in the proof log"
    print(f"certified: the tree was recomputed from tree and data alone; {known}")
    print(printable(solution_text(training.problem, file.solution, certificate)))
    if held_out is not None:
        print(f"held out: {file.loss.words_of(held_out.measures, held_out.n_samples)}")
    elif file.held_out is not None:
        print("held out: not recomputed, the samples are of another table; give it with --test")
    if proof is not None:
        print(f"proof: no tree costs less than {number(proof.bound)}; {proof.n_lines} lines, {proof.seconds:.3g} s")
    print(printable(verdict(training.problem, file.solution, certificate)))
    return 0


def _checked_held_out(arguments: argparse.Namespace, file: TreeFile, training: Training) -> Score | None:
    """Return what the tree loses on the samples held out, once the file's own figures agree."""
    samples: Samples | None = training.held_out
    if arguments.test:
        samples = read_test(file, training.problem, arguments.test)
    if samples is None:
        return None
    found, claim = score(training.problem, file.tree, samples), file.held_out
    if claim is not None and (claim.share is None) == bool(arguments.test):
        pairs = [(claim.cost, found.cost), *((claim.measures[name], found.measures[name]) for name in found.measures)]
        if claim.n_samples != found.n_samples or any(abs(a - b) > 1e-9 * max(1.0, b) for a, b in pairs):
            of_claim, of_found = (file.loss.words_of(of.measures, of.n_samples) for of in (claim, found))
            raise CertificateError(
                f"{arguments.tree} claims of the samples held out: {of_claim}, cost {claim.cost:g}; but recounted it "
                f"is: {of_found}, cost {found.cost:g}; tree and data do not belong together or one was changed"
            )
    return found


def _checked_proof(arguments: argparse.Namespace, problem: Problem, file: TreeFile) -> ProofReport | None:
    if not 1 <= arguments.threads <= MOST_THREADS:
        raise DataError(f"--threads is {shown(arguments.threads)}; expected 1 or more, and at most {MOST_THREADS}")
    if not arguments.proof:
        return None
    with StageLine("checking the proof"):
        return check_proof(problem, arguments.proof, bound=file.solution.bound, n_jobs=arguments.threads)
