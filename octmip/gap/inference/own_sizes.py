"""Signatures at the sizes that effects have: what an effect is judged by is its exact map at its own refitted size.

An effect with a forward map g is not linear in its size. Its column of S is the chord g(theta) / theta, so that the
readings are met exactly where it is judged. theta is refitted with it, alone for the effects that explain most alone,
and together for those that matching pursuit adds one by one, as the second of a pair has another size alone.
Source: Pati, Rezaiifar and Krishnaprasad (1993), 27th Asilomar Conference (orthogonal matching pursuit).
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from octmip.errors import TwinError
from octmip.gap.inference.candidates import sizes_by_test
from octmip.gap.inference.inputs import Inputs
from octmip.gap.inference.linear_model import LinearModel, linearise, missed_by
from octmip.gap.inference.signatures import exact_change, ratios

Floats = NDArray[np.float64]

LAPS, N_ALONE, N_TOGETHER = 5, 3, 3
WIDE = 3.0
"""Prior sds within which a size is refitted."""
CLOSE, NEAR = 0.04, 0.2
"""Relative change of a size below which its chord stays: of effects that explain the readings together, of others."""
LIKE = 0.5
"""Share of the greatest gain from which an effect alone may yet be the best at its own size."""
SEEN, AHEAD = 3.0, 4.0
"""d' below which an effect is as good as linear; steps that one by the last two chords takes at most."""


def about(inputs: Inputs, states: Floats, level: float = 1.0) -> LinearModel:
    """Return the model about states (n_cells, n_parameters) at a level of the difference, effects at their sizes."""
    return at_own_sizes(linearise(inputs, states, level))


def at_own_sizes(model: LinearModel) -> LinearModel:
    """Return the model with the chords of the effects that explain its readings best."""
    candidates, prior = model.inputs.candidates, model.inputs.priors
    forward = np.array([candidate.forward is not None for candidate in candidates])
    if not forward.any():
        return model
    chords: dict[int, float] = {}
    ends: dict[int, tuple[float, float]] = {}
    missed = missed_by(model.inputs, model.rows, model.given)
    ratio = ratios(model.inputs, model.states, missed)[model.average, model.gauge]
    for _ in range(LAPS):
        named = {**_together(model), **_by_test(model)}
        wanted = _alone(model, forward) | named
        seen = {j: size for j, size in wanted.items() if forward[j] and abs(size) * np.sqrt(model.lengths[j]) > SEEN}
        at = {j: (chords.get(j, 0.0), size - chords.get(j, 0.0)) for j, size in seen.items()}
        new = {j: float(np.clip(_between(ends.get(j), *here), *prior.bounds[:, j])) for j, here in at.items()}
        far = {j: max(abs(new[j] - chord), abs(off)) for j, (chord, off) in at.items()}
        close = {j: (CLOSE if j in named else NEAR) * abs(size) for j, size in seen.items()}
        new = {j: size for j, size in new.items() if far[j] > close[j] and size and size != at[j][0]}
        ends |= {j: at[j] for j in new}
        if not new:
            break
        chords |= new
        signatures = model.signatures.copy()
        for j, size in new.items():
            try:
                rows = exact_change(model.inputs, model.states, candidates[j], size)
            except TwinError:  # the model has no answer at that size: its slope stays
                continue
            own = ratio if getattr(candidates[j].effect, "load_power", None) != 0 else 1.0
            signatures[:, j] = own * rows[model.average, model.gauge] / size
        signatures.flags.writeable = False
        model = replace(model, signatures=signatures, chords=dict(chords))
    return model


def _between(before: tuple[float, float] | None, chord: float, off: float) -> float:
    """Return the size of the next chord, given by how much the size on the last one and the one before was off it.

    Where a reading goes as 1 / (1 + size) the sizes on chords swing about the one that is met, where it saturates they
    creep there: it lies where the line through the last two is 0, at most `AHEAD` times as far as the size on the last
    chord. Without two, or where they lead away, it is that size.
    """
    if before is None or (before[1] * off >= 0.0 and abs(off) >= abs(before[1])):
        return chord + off
    step = off * (chord - before[0]) / (before[1] - off)
    return chord + float(np.clip(step, -AHEAD * abs(off), AHEAD * abs(off)))


def _alone(model: LinearModel, forward: NDArray[np.bool_]) -> dict[int, float]:
    """Return the sizes of the nonlinear effects that gain most alone, by candidate."""
    sizes = model.projection / (model.lengths + (WIDE * model.inputs.priors.sd) ** -2)
    gain = np.where(forward, sizes * model.projection, -np.inf)
    best = np.argsort(-gain, kind="stable")[:N_ALONE]
    return {int(j): float(sizes[j]) for j in best if forward[j] and gain[j] >= LIKE * gain[best[0]]}


def _together(model: LinearModel) -> dict[int, float]:
    """Return the joint sizes of the effects that matching pursuit takes, by candidate."""
    taken: list[int] = []
    sizes = np.zeros(0)
    for _ in range(N_TOGETHER):
        left = model.projection - model.gram_rows(taken).T @ sizes if taken else model.projection
        gain = left**2 / (model.lengths + (WIDE * model.inputs.priors.sd) ** -2)
        gain[taken] = -np.inf
        best = int(np.argmax(gain))
        if gain[best] < SEEN**2:
            break
        taken.append(best)
        sizes = _sizes(model, taken)
    return dict(zip(taken, sizes.tolist(), strict=True))


def _by_test(model: LinearModel) -> dict[int, float]:
    """Return the sizes, one for every test, of the effect that gains most so, by candidate."""
    found = [(own, _sizes(model, own)) for own in sizes_by_test(model.inputs.candidates)]
    gains = [float(model.projection[list(own)] @ sizes) for own, sizes in found]
    own, sizes = found[int(np.argmax(gains))] if found else ((), np.zeros(0))
    return dict(zip(own, sizes.tolist(), strict=True))


def _sizes(model: LinearModel, taken: Sequence[int]) -> Floats:
    index = list(taken)
    gram = model.gram_rows(index)[:, index] + np.diag((WIDE * model.inputs.priors.sd[index]) ** -2)
    return np.asarray(np.linalg.solve(gram, model.projection[index]))
