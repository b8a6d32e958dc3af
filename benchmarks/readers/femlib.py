"""The readers of femlib's files, as the fuzz of files tries them."""

import contextlib
import functools
import hashlib
import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.readers.file_reader import Reader
from benchmarks.readers.mangled_arrays import mangled_archive, mangled_parquet
from benchmarks.readers.mangling import Generator, mangled_csv, mangled_json, mangled_tokens
from femlib.arrays import FloatArray
from femlib.dataset import (
    Recipe,
    Sampling,
    build_dataset,
    grid_states,
    open_dataset,
    published_strains,
    stream_dataset,
    study_states_percent,
)
from femlib.errors import FemlibError
from femlib.export.calculix import read_elements
from femlib.rom import ReducedModel
from femlib.rom.bound import LEVELS, ErrorBound
from femlib.wing import Wing, uav_wing
from femlib.wing.export import calculix
from femlib.wing.reduced import WORK, ReducedWing

# Datasets, reduced models, results of CalculiX.


def sealed(folder: Path, name: str) -> None:
    """Write the digest of a data file into its side file, as a stranger would, where that still is JSON."""
    if not all((folder / file).is_file() and not (folder / file).is_symlink() for file in (name, f"{name}.json")):
        return
    with contextlib.suppress(ValueError, TypeError, RecursionError):
        side = json.loads((folder / f"{name}.json").read_bytes())
        content = (folder / name).read_bytes()
        (folder / f"{name}.json").write_text(json.dumps(side | {"sha256": hashlib.sha256(content).hexdigest()}))


class Slope:
    """A model whose strains grow with damage."""

    parameters = ("mu1", "mu2")
    model_hash = "slope"

    class gauges:  # noqa: N801 - stands for the gauges of a model
        """Three gauges."""

        names = ("g1", "g2", "g3")
        is_usable = np.array([True, True, True])

    def strains_microstrain(self, states: FloatArray, load_factor: float) -> FloatArray:
        """Return the strains."""
        return np.asarray(load_factor * (1000.0 + states @ np.array([[300.0, 1.0, 2.0], [0.0, 200.0, 0.0]])))


def make_stream(number: int, folder: Path) -> None:
    """Write a streamed dataset."""
    library = grid_states({"mu1": [0.0, 0.4], "mu2": [0.0, 0.2 * (number + 1)]})
    stream_dataset(folder / "data.parquet", Slope(), library, Sampling(recipe=Recipe(2, 0.0)))


def read_stream(rng: Generator, folder: Path) -> None:
    """Open a streamed dataset and read its rows."""
    if rng.random() < 0.9:
        sealed(folder, "data.parquet")
    data = open_dataset(folder / "data.parquet")
    data.read([*data.parameters, *data.gauges])
    data.read()


def make_published(number: int, folder: Path) -> None:
    """Write a table in the published layout."""
    gauges = [f"strain_{k:02d}" for k in range(1, 25)]
    rows = [",".join(["mu1_percent", "mu2_percent", "load_factor", "kind", *gauges])]
    for k, (mu1, mu2) in enumerate(study_states_percent().tolist()):
        for load, kind in ((3, "mean"), (1, "mean"), (3, "sd")):
            strains = (f"{k + j / 7 + number:.4f}" for j in range(24))
            rows.append(",".join([str(mu1), str(mu2), str(load), kind, *strains]))
    (folder / "strains.csv").write_text("\n".join(rows) + "\n")


def read_published(rng: Generator, folder: Path) -> None:
    """Read a table in the published layout and draw a dataset from it."""
    build_dataset(published_strains(folder / "strains.csv"), Recipe(samples_per_state=1))


def make_model(number: int, folder: Path) -> None:
    """Write a reduced model of two regions with two modes each; all are leading for odd numbers."""
    rng = np.random.default_rng([94, number])
    owner, n = np.array([0, 0, 1, 1]), 4
    coupling = 0.05 * rng.normal(size=(n, n)) if number % 2 else np.diag([0.1, 0.2, 0.1, 0.3])
    bound = ErrorBound(
        tuple(rng.normal(size=(3, 1 + n + 2)) for _ in range(2)),
        tuple(rng.normal(size=(3, 3 + n + 2)) for _ in range(2)),
        rng.uniform(0.0, 1.0, 6),
        rng.uniform(0.0, 0.9, len(LEVELS)),
        rng.uniform(0.0, 0.9, (len(LEVELS), 2, 2)),
    )
    ReducedModel(
        ("mu1", "mu2"),
        ("g1", "g2", WORK),
        rng.normal(size=3),
        owner,
        rng.normal(size=n),
        coupling,
        rng.normal(size=(3, n)),
        rng.normal(size=(3, 2)),
        bound,
        {"model": "abc"},
        n if number % 2 else 0,
        rng.normal(size=(12, n + 3)).astype(np.float32),
    ).save(folder / "model.npz")


def read_reduced(rng: Generator, folder: Path) -> None:
    """Read a reduced wing and ask it for strains, displacements and bounds."""
    wing = ReducedWing.load_file(folder / "model.npz")
    states = np.array([[0.0] * len(wing.parameters), [0.5] * len(wing.parameters)])
    with contextlib.suppress(FemlibError):
        wing.strains_microstrain(states, 3.0)
        wing.error_bound_microstrain(states, 3.0)
        wing.solve({}, 1.0)


@functools.cache
def _wing() -> Wing:
    return uav_wing(refinement=0.4)


def make_result(number: int, folder: Path) -> None:
    """Write a result as CalculiX prints it: the strains of every element that a gauge reads."""
    out = io.StringIO()
    out.write(" strains (elem, integ.pnt.,exx,eyy,ezz,exy,exz,eyz) for set GAUGES and time  1.0\n\n")
    for element in read_elements(_wing().structure.shells.mesh, _wing().strain_gauges):
        for point in range(1, 9):
            out.write(f" {element + 1} {point} 0. {-1e-3 * (point > 4):.6E} 0. 0. 0. 0. S\n")
    (folder / "wing.dat").write_text(out.getvalue())


def read_result(rng: Generator, folder: Path) -> None:
    """Read the gauges of a result."""
    assert np.isfinite(calculix.read_gauges(_wing(), folder / "wing.dat")).all()


def _side(make: Callable[[int, Path], None], name: str, read: Callable[[Generator, Path], None]) -> Reader:
    return Reader(make, f"{name}.json", mangled_json, read)


FEMLIB = {
    "streamed dataset": Reader(make_stream, "data.parquet", mangled_parquet, read_stream),
    "streamed dataset, side file": _side(make_stream, "data.parquet", read_stream),
    "published strains": Reader(make_published, "strains.csv", mangled_csv, read_published),
    "reduced model": Reader(make_model, "model.npz", mangled_archive, read_reduced),
    "result of CalculiX": Reader(make_result, "wing.dat", mangled_tokens, read_result, n_made=1),
}
