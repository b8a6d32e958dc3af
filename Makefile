# `make uav` and `make test` do all the set-up themselves; a second run starts in seconds.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
ZIG = $(shell test "$$(uname -s)" = Linux && $(BIN)/python -m ziglang version >/dev/null 2>&1 && echo --zig --compatibility manylinux2014)
NATIVE := $(shell find octmip/trees/native -name target -prune -o -type f ! -name Cargo.lock -print)
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# The tests start hundreds of processes: modules are compiled once, whatever the environment says.
export PYTHONDONTWRITEBYTECODE :=
# Packages that all processes of pytest import at the same time: each would compile them by itself.
LARGE := scipy.stats scipy.optimize scipy.signal scipy.interpolate pandas pyarrow sklearn.utils.estimator_checks \
	matplotlib.pyplot pyomo.environ distributed hypothesis.strategies libcst.matchers rosbags.highlevel
PYTEST := MAKEFLAGS= OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest --numprocesses auto --dist loadfile --no-loadscope-reorder -r s

.PHONY: uav mission blind test lint lint-python lint-rust lint-python-then-test-rust test-rust pytest long wheel site verified tools benchmarks clean

uav: $(VENV)/.installed
	@$(BIN)/python -m benchmarks.uav $(if $(STRAINS),--strains $(STRAINS)) $(ARGS)

# The tables of docs/results/mission.md: make mission ARGS="--policies --watch 100 --lives 1000"
mission: $(VENV)/.installed
	@$(BIN)/python -m benchmarks.uav.mission $(if $(STRAINS),--strains $(STRAINS) --out results/uav/mission/published) $(ARGS)

# Sealed cases, diagnosed without their keys, then scored: make blind ARGS="--cases 600 --seed 7 --out blind"
blind: $(VENV)/.installed
	@$(BIN)/python -m benchmarks.blind $(ARGS)

# One job builds the native core, which keeps one core of the machine busy for minutes; the other installs the packages,
# checks Python and tests Rust. The tests of Python begin when the core is built. Clippy is `make lint`'s.
test: | tools
	$(MAKE) --jobs 2 $(VENV)/.core lint-python-then-test-rust pytest

pytest: $(VENV)/.installed-test
	$(PYTEST)

# The tests marked long: more seeds and cases, studies, the whole site, the wheel in detail.
long: $(VENV)/.installed-test
	$(PYTEST) --long

lint: lint-python lint-rust

# In a folder of its own: cargo lets no two commands into one, and the tests of Rust would wait.
lint-rust: | tools
	cd octmip/trees/native && cargo fmt --all --check && MAKEFLAGS= cargo clippy --profile checks --target-dir target/lint --quiet --workspace --all-targets -- -D warnings

lint-python-then-test-rust: $(VENV)/.packages-test
	$(BIN)/python -W ignore -c "from importlib import import_module as load; [load(name) for name in '$(LARGE)'.split()]"
	$(MAKE) lint-python
	$(MAKE) test-rust

lint-python: $(VENV)/.packages-test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python docs/_extensions/notebooks.py $(VENV)/typed && MYPYPATH=$(VENV)/typed $(BIN)/mypy --package pages

test-rust: | tools
	cd octmip/trees/native && MAKEFLAGS= cargo test --profile checks --quiet --workspace

# An abi3 wheel and the source distribution in dist/; a wheel is built from the latter too, to see that it can be. Linked
# by zig the wheel runs on every Linux since 2014 (manylinux2014); without zig maturin's audit gives it the tag of this
# machine's C library.
wheel: $(VENV)/.wheel-tools
	rm -rf dist
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/maturin build --release --quiet --interpreter $(BIN)/python $(ZIG) --out dist
	$(BIN)/maturin sdist --out dist
	PATH="$(abspath $(BIN)):$$PATH" $(BIN)/python -m pip wheel --quiet --no-deps --no-build-isolation --wheel-dir $(VENV)/from-source dist/*.tar.gz
	$(BIN)/python -m twine check --strict dist/*
	$(BIN)/python -m check_wheel_contents --toplevel octmip,femlib dist/*.whl
	@ls -l dist

# The documentation as a site in site/, warnings as errors; make site DRAW=1 draws the pictures of the examples again.
site: $(VENV)/.installed-test
	@$(BIN)/python -m sphinx -W --keep-going -q -b html $(if $(DRAW),-D draw_examples=1) docs site

# The proof checker with a theorem (docs/theory/proofs/verified.md): octmip/trees/verified/build/octmip-verified
verified:
	@command -v coqc >/dev/null && command -v ocamlfind >/dev/null && ocamlfind query zarith >/dev/null 2>&1 || { echo "Coq, OCaml or Zarith is missing: install them, for instance with apt-get install coq ocaml-nox ocaml-findlib libzarith-ocaml-dev"; exit 2; }
	$(MAKE) -C octmip/trees/verified

tools:
	@command -v $(PYTHON) >/dev/null || { echo "$(PYTHON) is missing: install Python 3.11 or newer, or say make PYTHON=/path/to/python"; exit 2; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "$$($(PYTHON) --version) is too old: install Python 3.11 or newer, or say make PYTHON=/path/to/python"; exit 2; }
	@command -v cc >/dev/null || { echo "a C compiler (cc) is missing: install gcc or clang, for instance apt-get install build-essential"; exit 2; }
	@command -v cargo >/dev/null || { echo "the Rust toolchain (cargo) is missing: install stable Rust 1.89 or newer, for instance with rustup"; exit 2; }

# Editable: Python files are used where they lie, and the native core is built again when a Rust file changes.
$(VENV)/.core: pyproject.toml $(NATIVE) | $(BIN)/python
	$(BIN)/python -m pip install --quiet --no-compile --no-deps --editable .
	@touch $@

# What the project and some extras need, with octmip[EXTRA] written out: pip would build the native core for it.
define REQUIREMENTS
import re, sys, tomllib
project = tomllib.load(open("pyproject.toml", "rb"))["project"]
def lines(extra):
    for line in project["optional-dependencies"][extra]:
        own = re.fullmatch(r"octmip\[(.*)\]", line)
        yield from (part for name in own[1].split(",") for part in lines(name)) if own else [line]
every = [*project["dependencies"], *(line for extra in sys.argv[1:] for line in lines(extra))]
print("\n".join(dict.fromkeys(every)))
endef
export REQUIREMENTS

$(VENV)/.packages: EXTRAS = all
$(VENV)/.packages-test: EXTRAS = test docs
$(VENV)/.packages $(VENV)/.packages-test: pyproject.toml | $(BIN)/python
	$(BIN)/python -c "$$REQUIREMENTS" $(EXTRAS) > $@.txt
	$(BIN)/python -m pip install --quiet --no-compile --requirement $@.txt
	@touch $@

$(VENV)/.installed: $(VENV)/.core $(VENV)/.packages
	@touch $@

# Its packages are those of .installed and more.
$(VENV)/.installed-test: $(VENV)/.core $(VENV)/.packages-test
	@touch $(VENV)/.packages $(VENV)/.installed $@

$(BIN)/python: | tools
	$(PYTHON) -m venv $(VENV)

$(VENV)/.wheel-tools: | $(BIN)/python
	$(BIN)/python -m pip install --quiet 'maturin>=1.13,<2' 'twine>=6.1' 'check-wheel-contents>=0.6'
	@$(BIN)/python -m pip install --quiet ziglang || echo "ziglang cannot be installed: the wheel gets the tag of this machine's C library, and older systems refuse it"
	@touch $@

clean:
	rm -rf $(VENV) results dist octmip/trees/native/target octmip/trees/verified/build octmip/trees/*.so
