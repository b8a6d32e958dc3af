"""Errors that octmip raises on purpose; a message says what is wrong, where, got, expected, cure."""


class OctmipError(Exception):
    """Any error that octmip raises on purpose."""


class ProblemError(OctmipError, ValueError):
    """The problem as stated is not one that a tree can answer (wrong shape, range or type)."""


class DataError(OctmipError, ValueError):
    """A file or table does not hold what was announced (missing column, text in a number, unseen label)."""


class TreeError(OctmipError, ValueError):
    """A tree or tree file is malformed."""


class CertificateError(OctmipError, ValueError):
    """A solution does not hold what it claims."""


class SolverError(OctmipError, RuntimeError):
    """A solver failed or returned something that its own decoding refutes."""
