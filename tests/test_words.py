"""The words of the field: what docs/words.md calls gone stands nowhere else."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
ALLOWED = {"CHANGELOG.md", "docs/words.md"}


def gone() -> list[str]:
    """Return the words of the first table of docs/words.md."""
    table = (ROOT / "docs" / "words.md").read_text().split("## Gone")[1]
    rows = re.findall(r"^\| ([^|]+) \|", table, flags=re.MULTILINE)
    return [word.strip() for row in rows if row != "was" for word in row.split(",")]


@pytest.fixture(scope="module")
def texts() -> dict[str, str]:
    suffixes = ("*.py", "*.pyi", "*.rs", "*.md", "*.toml", "Makefile")
    listed = subprocess.run(["git", "ls-files", *suffixes], cwd=ROOT, capture_output=True, text=True, check=False)
    names = listed.stdout.split()
    if not names:
        pytest.skip("the sources are not a git repository here")
    return {name: (ROOT / name).read_text() for name in names if name not in ALLOWED and (ROOT / name).exists()}


def test_there_are_words_to_look_for():
    assert len(gone()) > 30
    assert {"Climber", "swing", "Vigil"} <= set(gone())


def test_a_word_that_is_gone_stands_nowhere(texts):
    one_of = "|".join(map(re.escape, gone()))
    whole = re.compile(rf"\b(?:{one_of})\b", flags=re.IGNORECASE)
    found = {name: set(whole.findall(text)) for name, text in texts.items() if whole.search(text)}
    found.pop("tests/test_words.py", None)
    assert not found, "docs/words.md has the new words"
