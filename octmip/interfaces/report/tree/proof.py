"""The certificate in words: what was recounted, what is proven, and what neither says."""

import math

from octmip.formats.tree_file import TreeFile
from octmip.input.names import shown
from octmip.interfaces.report.tree.evidence import Evidence
from octmip.interfaces.report.tree.measure import Measure
from octmip.interfaces.report.tree.summary import trees_meant
from octmip.interfaces.report.tree.words import counted, figure, percent


def certificate_words(file: TreeFile, evidence: Evidence | None, measure: Measure, data: str | None) -> list[str]:
    """Return one sentence or two for each claim."""
    is_evident = file.solution.meets_bound and file.solution.objective == 0
    log = [] if is_evident and (evidence is None or evidence.proof is None) else [_log(evidence)]
    return [_recount(file, evidence, measure, data), _bound(file, measure), *log, *_limits(file, evidence)]


def _recount(file: TreeFile, evidence: Evidence | None, measure: Measure, data: str | None) -> str:
    if evidence is None:
        return (
            f"Nothing was recounted for this page: the data were not given. The tree file claims "
            f"{measure.amount(file.solution.objective)} over {counted(file.n_samples, 'sample')}."
        )
    where = f" of {shown(data)}" if data else ""
    return (
        f"Recounted for this page: each of the {counted(file.n_samples, 'sample')}{where} was sent through the tree "
        f"again, without the solver. That gives {measure.amount(file.solution.objective)}{measure.recounted()}, as the "
        "tree file says; depth, size of the leaves, kind of split and sensors keep to the settings. The digest of the "
        "data is the one that the tree was trained on."
    )


def _bound(file: TreeFile, measure: Measure) -> str:
    solution = file.solution
    if not math.isfinite(solution.bound):
        return "No bound is known, so a better tree may exist."
    if solution.meets_bound and solution.objective == 0:
        return f"No tree can have less than {measure.none()} at all: this one is the best."
    least = measure.least(solution.bound)
    gap = (
        f"This tree meets that bound, so it is the best{' of these' if solution.scope else ''}."
        if solution.meets_bound
        else f"This tree has {measure.amount(solution.objective)}: a gap of {percent(solution.gap)}."
    )
    return f"Proven by the solver: {trees_meant(file)} {measure.below(least)}. {gap}"


def _log(evidence: Evidence | None) -> str:
    if evidence is None or evidence.proof is None:
        return (
            "The proof itself was not checked for this page. A solver can write a proof log, which a separate small "
            "program checks line by line."
        )
    log = evidence.proof
    return (
        f"Proof log checked for this page: a separate program that shares nothing with the search read "
        f"{counted(log.n_lines, 'line')} and confirms that no tree is below {figure(log.bound)}."
    )


def _limits(file: TreeFile, evidence: Evidence | None) -> list[str]:
    out = [
        "All this is about the training samples and these settings. A deeper tree, other questions or other columns "
        "may do better, and the proof says nothing about new samples."
    ]
    if evidence is not None and evidence.held_out is not None:
        out.append("Only the samples held out say something about new samples; nothing else used them.")
    return out
