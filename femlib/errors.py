"""The errors of femlib: one parent, children that also answer to the built-in errors a caller expects."""


class FemlibError(Exception):
    """Any failure that femlib reports about its input or its solution."""


class InputError(FemlibError, ValueError):
    """An argument, a file or a state cannot be used; the message says what, where, got, expected and the cure."""


class MeshError(InputError):
    """A mesh has an element that the shell elements cannot represent."""


class SolveError(FemlibError, RuntimeError):
    """A linear or nonlinear system could not be solved to the asked accuracy."""
