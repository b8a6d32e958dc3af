"""The tests that are nearest to a module: by name, then by the imports between them, then by what they say of it."""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("octmip", "femlib", "benchmarks", "tests")
TOO_LONG = ("test_blind", "test_tutorial", "test_site", "test_uav_study", "test_installed", "test_distribution")


class NearestTests:
    """Files of tests by their distance to a source."""

    def __init__(self, root: Path) -> None:
        files = [file for package in PACKAGES for file in sorted((root / package).rglob("*.py"))]
        self.texts = {str(file.relative_to(root)): file.read_text(encoding="utf-8") for file in files}
        self.trees = {file: ast.parse(text) for file, text in self.texts.items()}
        self.importers = defaultdict(set)
        for file in self.texts:
            for other in self._imported(file):
                self.importers[other].add(file)

    def of(self, file: str) -> list[str]:
        """Return all tests that lead to a source, the nearest first; of a Rust file those that bear its part's name."""
        if file.endswith(".rs"):
            part = Path(file.partition("/src/")[2]).with_suffix("").parts[0]
            return [test for test in self.texts if Path(test).stem.startswith("test_") and part in Path(test).stem]
        found, ring = {file: 0}, [file]
        while ring:
            ring = sorted({one for other in ring for one in self.importers[other]} - set(found))
            found |= dict.fromkeys(ring, max(found.values()) + 1)
        public = re.findall(r"^(?: {4})?(?:def|class) ([^_]\w+)|^([A-Z]\w+)\b", self.texts[file], re.MULTILINE)
        names = {name for both in public for name in both if name}
        tests = {test: set(re.findall(r"\w+", self.texts[test])) & names for test in found if "/test_" in test}
        tests = {test: said for test, said in tests.items() if Path(test).stem.startswith("test_")}
        near = [test for test in tests if Path(test).stem not in TOO_LONG]
        stem = Path(file).stem
        return sorted(near, key=lambda test: (stem not in Path(test).stem, found[test], -len(tests[test])))

    def _imported(self, file: str) -> Iterator[str]:
        for node in ast.walk(self.trees[file]):
            if isinstance(node, ast.ImportFrom) and node.module:
                yield from (self._home(node.module, name.name) for name in node.names)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
                yield f"{Path(file).parent}/{node.value}.py"  # a table of modules

    def _home(self, module: str, name: str) -> str:
        """Return the file that has a name of a module: where a package passes it on, that of the other module."""
        place = module.replace(".", "/")
        for file in (f"{place}/{name}.py", f"{place}.py"):
            if file in self.texts:
                return file
        for node in ast.walk(self.trees.get(f"{place}/__init__.py", ast.Module([]))):
            if isinstance(node, ast.ImportFrom) and node.module and any(name == one.name for one in node.names):
                return self._home(node.module, name)
        return f"{place}/__init__.py"
