"""Errors that octmip raises on purpose; a message says what is wrong, where, got, expected, cure."""

from collections.abc import Iterator
from contextlib import contextmanager

EXTRA_OF = {
    "matplotlib": "plot",
    "pyarrow": "parquet",
    "onnx": "onnx",
    "pyomo": "model",
    **dict.fromkeys(("nptdms", "asammdf", "pyulog", "pymavlink", "mcap", "rosbags", "obspy"), "recordings"),
    **dict.fromkeys(("pyuff", "pymatreader", "pint"), "recordings"),
    "pyoma2": "modes",
}
"""The extra of octmip that installs an optional package."""


class OctmipError(Exception):
    """Any error that octmip raises on purpose.

    >>> try:
    ...     Problem([[0], [1]], ["a"], depth=1)
    ... except OctmipError as error:
    ...     print(error)
    targets has shape (1,) but features has 2 rows; give one for each row
    """


class ProblemError(OctmipError, ValueError):
    """The problem as stated is not one that a tree can answer (wrong shape, range or type)."""


class NoTreeError(ProblemError):
    """No tree has all that is asked for, such as a given split that leaves a side empty."""


class DataError(OctmipError, ValueError):
    """A file or table does not hold what was announced (missing column, text in a number, unseen label)."""


class WriteError(DataError):
    """A file could not be written, though its place was there: the disk is full, or was taken away."""


class TreeError(OctmipError, ValueError):
    """A tree or tree file is malformed."""


class TwinError(OctmipError, RuntimeError):
    """A model of somebody else's, or an effect of it, raised, gave the wrong shape, or gave no finite number."""


class CertificateError(OctmipError, ValueError):
    """A solution does not hold what it claims."""


class SolverError(OctmipError, RuntimeError):
    """A solver failed or returned something that its own decoding refutes."""


class MissingExtraError(OctmipError, ImportError):
    """A feature needs a package that belongs to an extra and is not installed."""


OUT_OF_MEMORY = ("failed to map segment", "cannot allocate memory", "can't start new thread")
"""What an import or a thread says that got no memory: neither raises MemoryError."""


def is_out_of_memory(error: BaseException) -> bool:
    """Return whether an error says that the process got no more memory."""
    is_told = isinstance(error, ImportError | RuntimeError | OSError)
    return isinstance(error, MemoryError) or (is_told and any(said in str(error).lower() for said in OUT_OF_MEMORY))


@contextmanager
def needed_by(what: str) -> Iterator[None]:
    """Within the context, the import of an optional package that is not installed names the extra to install.

    Parameters
    ----------
    what
        the feature that needs the package, the beginning of the sentence.

    Raises
    ------
    MissingExtraError
        a package of `EXTRA_OF` is missing.

    Examples
    --------
    >>> with needed_by("export to ONNX"):
    ...     import onnx
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = str(error.name).partition(".")[0]
        if package not in EXTRA_OF:
            raise
        raise MissingExtraError(
            f"{what} needs the package {package}, which is not installed; install octmip[{EXTRA_OF[package]}]"
        ) from error
