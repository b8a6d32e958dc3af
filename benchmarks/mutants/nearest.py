"""The tests that are nearest to a module: by the imports between them, then by how often they say its names."""

import ast
import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import cached_property
from hashlib import sha1
from pathlib import Path

PACKAGES = ("octmip", "femlib", "benchmarks", "tests")
KEPT = Path(__file__).parents[2] / "results" / "seconds_of_tests.json"
TOO_LONG = ("test_blind.py", "test_tutorial.py", "test_site.py", "test_uav_study.py", "test_installed.py")
COMMON = {
    "octmip/trees": ("tests/test_octmip/test_every_cell.py", "tests/test_benchmarks/test_fuzz_everything.py"),
    "octmip/gap": ("tests/test_octmip/test_gap_diagnosis.py",),
    "octmip/formats": ("tests/test_octmip/test_hostile_files.py",),
}
"""Files of tests that hold a whole part against its definition: they run last."""


class NearestTests:
    """Files of tests by their distance to a module, in a tree."""

    def __init__(self, root: Path, measure: Callable[[str], float]) -> None:
        self.root, self.measure = root, measure
        self.texts = {
            str(file.relative_to(root)): file.read_text(encoding="utf-8")
            for package in PACKAGES
            for file in sorted((root / package).rglob("*.py"))
        }

    def of(self, file: str, most: float) -> tuple[list[str], float]:
        """Return the files of tests of a source, those that tell most first, and the seconds that they take."""
        common = [test for part, tests in COMMON.items() if file.startswith(part) for test in tests]
        chosen, total = [], 0.0
        for test in self._ordered(file):
            if test not in common and total + (seconds := self._seconds(test)) <= most:
                chosen.append(test)
                total += seconds
            if total > 0.9 * most:
                break
        return [*chosen, *common], total + sum(self._seconds(test) for test in common)

    def _ordered(self, file: str) -> list[str]:
        distances = self._distances(file)
        names = re.findall(r"^(?:def|class) ([^_]\w+)|^([A-Z]\w+) *[:=]|^    def ([^_]\w+)", self.texts[file], re.M)
        said = re.compile(r"\b(" + "|".join({name for found in names for name in found if name} or {"$^"}) + r")\b")
        names = {test: Path(test).name for test in distances if test.startswith("tests/")}
        tests = [test for test, name in names.items() if name.startswith("test_") and name not in TOO_LONG]
        return sorted(tests, key=lambda test: (distances[test], -len(set(said.findall(self.texts[test])))))

    def _distances(self, file: str) -> dict[str, int]:
        """Return how many imports lie between a source and each file that leads to it."""
        found, ring = {file: 0}, [file]
        while ring:
            ring = [one for other in ring for one in self._importers[other] if one not in found]
            ring = list(dict.fromkeys(ring))
            found |= dict.fromkeys(ring, max(found.values()) + 1)
        return found

    @cached_property
    def _importers(self) -> dict[str, set[str]]:
        importers = defaultdict(set)
        for file, text in self.texts.items():
            for module in self._imported(file, text):
                importers[module].add(file)
        return importers

    def _imported(self, file: str, text: str) -> Iterator[str]:
        """Yield the files that a file imports; of a name that a package passes on, the file that has it."""
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.module:
                yield from (self._home(node.module, name.name) for name in node.names)
            elif isinstance(node, ast.Import):
                yield from (self._home(name.name, "") for name in node.names)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
                yield f"{Path(file).parent}/{node.value}.py"  # a table of modules

    def _home(self, module: str, name: str) -> str:
        place = module.replace(".", "/")
        if f"{place}/{name}.py" in self.texts:
            return f"{place}/{name}.py"
        if f"{place}.py" in self.texts:
            return f"{place}.py"
        for node in ast.walk(ast.parse(self.texts.get(f"{place}/__init__.py", ""))):
            if isinstance(node, ast.ImportFrom) and node.module and any(name == one.name for one in node.names):
                return self._home(node.module, name)
        return f"{place}/__init__.py"

    def _seconds(self, test: str) -> float:
        """Return what a file of tests takes without a mutant, kept for the next run as long as the file is the same."""
        kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
        key = f"{test} {sha1(self.texts[test].encode()).hexdigest()[:8]}"
        if key not in kept:
            kept[key] = self.measure(test)
            KEPT.parent.mkdir(exist_ok=True)
            KEPT.write_text(json.dumps(kept, indent=0))
        return float(kept[key])
