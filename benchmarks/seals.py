"""Sealed answers: their fingerprints, their opening, and whether a selector named the truth."""

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any


def fingerprint(answer: object) -> str:
    """Return the SHA-256 of a salted answer."""
    return hashlib.sha256(json.dumps(answer, sort_keys=True).encode()).hexdigest()


def open_keys(folder: Path, keys: Path) -> dict[str, Any]:
    """Return the answers by case after checking each against its seal."""
    answers: dict[str, Any] = json.loads(keys.read_text())
    seals: dict[str, str] = json.loads((folder / "seals.json").read_text())
    broken = [name for name in {**answers, **seals} if fingerprint(answers.get(name)) != seals.get(name)]
    if broken:
        raise SystemExit(f"{len(broken)} answers do not match their seals, first {broken[0]}: the keys were changed")
    return answers


def is_right(groups: Sequence[Sequence[str]], truth: Sequence[str]) -> bool:
    """Return whether groups of names that cannot be told apart hold the true names one by one."""
    if len(groups) != len(truth):
        return False
    if not groups:
        return True
    first, rest = truth[0], truth[1:]
    return any(first in group and is_right([*groups[:k], *groups[k + 1 :]], rest) for k, group in enumerate(groups))
