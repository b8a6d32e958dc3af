"""The tests that are nearest to a module: those of its name, those that import it, then by the words in common."""

import math
import re
from collections import Counter, defaultdict
from pathlib import Path

PACKAGES = ("octmip", "femlib", "benchmarks", "tests")
TOO_LONG = (
    *("test_blind", "test_uav_study", "test_fuzz_everything", "test_kills_and_soak", "test_pictures"),
    *("test_cli_signals", "test_cluster"),
)
"""Run where they have the source's name alone."""
AROUND = 12
"""The words of so many lines before and behind a line count twice."""
IMPORT = re.compile(r"^ *from ([\w.]+) import (\([^)]*\)|.*)", re.MULTILINE)


class NearestTests:
    """Files of tests by their distance to a source."""

    def __init__(self, root: Path) -> None:
        self.root = root
        files = [file for package in PACKAGES for file in sorted((root / package).rglob("*.py"))]
        self.texts = {str(file.relative_to(root)): file.read_text(encoding="utf-8") for file in files}
        self.imports = {
            file: [(module.replace(".", "/"), name) for module, names in IMPORT.findall(text) for name in _words(names)]
            for file, text in self.texts.items()
        }
        self.n_texts = Counter(word for text in self.texts.values() for word in _words(text))
        self.importers = defaultdict(set)
        for file, imports in self.imports.items():
            tables = {f"{Path(file).parent}/{name}.py" for name in re.findall(r'"(\w+)"', self.texts[file])}
            for other in {self._home(*one) for one in imports} | tables | {f"{Path(file).parent}/conftest.py"}:
                self.importers[other].add(file)

    def of(self, file: str, line: int) -> list[str]:
        """Return the tests of behaviour that lead to a line of a source, the nearest first; of a Rust file all.

        Those of the documentation and of the house stand in no folder of their own.
        """
        found, ring = {file: 0}, [file]
        while ring:
            ring = sorted({one for other in ring for one in self.importers[other]} - set(found))
            found |= dict.fromkeys(ring, max(found.values()) + 1)
        is_rust = file.endswith(".rs")
        stem = _subject(file) if is_rust else Path(file).stem
        lines = (self.root / file).read_text(encoding="utf-8").splitlines()
        around = lines[max(0, line - AROUND) : line + AROUND]
        sought = Counter([*_words("\n".join(lines)), *_words("\n".join(around))])
        far = {
            test: (
                stem not in name,
                not self._names(test, stem) if is_rust else found[test] > 1,
                -self._alike(sought, test),
            )
            for test in (self.texts if is_rust else found)
            if (name := Path(test).stem).startswith("test_")
            and test.count("/") > 1
            and (name not in TOO_LONG or stem in name)
        }
        return sorted(far, key=far.__getitem__)

    def _names(self, test: str, part: str) -> bool:
        return re.search(rf"import .*\b{part}\b", self.texts[test]) is not None

    def _alike(self, sought: Counter[str], test: str) -> float:
        """Return how many words a test shares with others, the rarer the more, for its length."""
        words = _words(self.texts[test])
        shared = (count / self.n_texts[word] for word, count in sought.items() if word in words)
        return math.fsum(shared) / math.cbrt(len(words))

    def _home(self, place: str, name: str) -> str:
        """Return the file that has a name of a module: where a package passes it on, that of the other module."""
        for file in (f"{place}/{name}.py", f"{place}.py"):
            if file in self.texts:
                return file
        package = f"{place}/__init__.py"
        passed_on = (self._home(other, one) for other, one in self.imports.get(package, ()) if one == name)
        return next(passed_on, package)


def _subject(file: str) -> str:
    """Return the crate of a Rust file; the module where the crate holds many subjects."""
    crate, _, inside = file.partition("/src/")
    many = Path(crate).name in {"native", "check", "frame"}
    return Path(inside).parts[0].removesuffix(".rs") if many else Path(crate).name


def _words(text: str) -> set[str]:
    return set(re.findall(r"\w+", text))
