"""Write the instances, or print their table: `python -m benchmarks.instances [--out DIR] [--only REGEX] [--cip]`.

Each is written as MPS by HiGHS; with `--cip` also as SCIP's own format, which needs the package pyscipopt. Beside them
stands sizes.json with rows, columns, integers and nonzeros of each.
"""

import argparse
import json
import re
import sys
from pathlib import Path

from benchmarks.instances.catalogue import INSTANCES, Instance
from benchmarks.instances.known import known, markdown
from benchmarks.main_program import run_main
from octmip.trees.mip.rows import Rows
from octmip.trees.mip.rows_file import write_rows


def main(words: list[str] | None = None) -> int:
    """Write the instances, or print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.instances", description=__doc__)
    parser.add_argument("--out", type=Path, help="folder to write into; made if it is not there")
    parser.add_argument("--only", default="", help="only instances whose name holds this regular expression")
    parser.add_argument("--cip", action="store_true", help="also write SCIP's format, through pyscipopt")
    parser.add_argument("--table", action="store_true", help="print what is known of all instances, in Markdown")
    options = parser.parse_args(words)
    if options.table:
        print(markdown(known()))
    if options.out is not None:
        chosen = _chosen(options.only, parser)
        if options.out.exists() and not options.out.is_dir():
            parser.error(f"--out {options.out} is a file; expected a folder, made if it is not there; choose another")
        try:
            options.out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            parser.error(f"--out {options.out} cannot be made ({error.strerror}); choose another place")
        _write(chosen, options.out, with_cip=options.cip)
    elif not options.table:
        parser.error("nothing to do; give --out DIR, or --table")
    return 0


def _chosen(only: str, parser: argparse.ArgumentParser) -> list[Instance]:
    """Return the instances whose name holds a regular expression; the command ends where there is none."""
    try:
        chosen = [instance for instance in INSTANCES if re.search(only, instance.name)]
    except re.error as error:
        parser.error(f"--only {only!r} is no regular expression ({error}); expected one such as ^flow-; correct it")
    if not chosen:
        parser.error(
            f"--only {only!r} names none of the {len(INSTANCES)} instances; expected part of a name such as "
            f"{INSTANCES[0].name}; correct it"
        )
    return chosen


def _write(instances: list[Instance], folder: Path, *, with_cip: bool) -> None:
    sizes = {}
    for instance in instances:
        rows, path = instance.rows(), folder / f"{instance.name}.mps"
        write_rows(rows, path, f"octmip instance {instance.name}")
        if with_cip:
            write_cip(path)
        sizes[instance.name] = size_of(rows)
        print(f"{path}  {path.stat().st_size / 1e6:.2f} MB  {sizes[instance.name]}", file=sys.stderr)
    (folder / "sizes.json").write_text(json.dumps(sizes, indent=1) + "\n")


def size_of(rows: Rows) -> dict[str, int]:
    """Return rows, columns, integer columns and nonzeros of a model."""
    n_integers = int(rows.is_integer.sum())
    return {
        "rows": rows.n_rows,
        "columns": rows.n_columns,
        "integers": n_integers,
        "nonzeros": int(rows.matrix().nnz),
    }


def write_cip(path: Path) -> None:
    """Write an MPS file again beside itself as SCIP's own format.

    Raises
    ------
    SystemExit
        pyscipopt is not installed.
    """
    try:
        from pyscipopt import Model
    except ModuleNotFoundError as error:
        raise SystemExit(
            "--cip needs the package pyscipopt, which is not installed; install it, or leave out --cip"
        ) from error
    model = Model()
    model.hideOutput()
    model.readProblem(str(path))
    model.writeProblem(str(path.with_suffix(".cip")), verbose=False)


if __name__ == "__main__":
    run_main(main)
