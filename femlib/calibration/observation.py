"""What was measured: outputs of a state under a load, the mass, a natural frequency; each entry with its own sd."""

from dataclasses import dataclass

import numpy as np

from femlib.arrays import FloatArray
from femlib.errors import InputError, frozen_floats, is_number, is_whole


@dataclass(frozen=True, slots=True, eq=False)
class OutputReading:
    """Readings of the outputs of one state under one load: strains of gauges, displacements per load.

    Attributes
    ----------
    group : str
        Name under which the report adds up its residuals.
    state, load, output : str
        Names of the design's state, load and output rows.
    measured, sd : FloatArray
        Readings and their standard deviations (n_outputs,), in the outputs' unit.
    reference : str, optional
        State whose outputs are taken off, for the increment that a damage adds.
    labels : tuple of str
        Names of the entries, such as the gauges'; entries can be held out by them.
    """

    group: str
    state: str
    load: str
    output: str
    measured: FloatArray
    sd: FloatArray
    reference: str | None = None
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        measured = frozen_floats(self.measured, f"{self.group} measured", (-1,))
        object.__setattr__(self, "measured", measured)
        object.__setattr__(self, "sd", frozen_floats(self.sd, f"{self.group} sd", measured.shape))
        if (self.sd <= 0.0).any():
            bad = int(np.flatnonzero(self.sd <= 0.0)[0])
            raise InputError(f"{self.group} sd[{bad}] is {self.sd[bad]}; expected more than 0; correct it")
        if self.labels and len(self.labels) != len(measured):
            raise InputError(
                f"{self.group} has {len(self.labels)} labels for {len(measured)} readings; expected one for each; "
                "complete them"
            )

    @property
    def n_entries(self) -> int:
        """Number of residuals."""
        return len(self.measured)


@dataclass(frozen=True, slots=True)
class MassReading:
    """The mass of the structure, weighed or assumed [kg].

    Attributes
    ----------
    measured, sd : float
        Mass and its standard deviation [kg].
    group : str
        Name in the report.
    """

    measured: float
    sd: float
    group: str = "mass"
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_scalar(self.group, self.measured, self.sd)

    @property
    def n_entries(self) -> int:
        """Number of residuals: one."""
        return 1


@dataclass(frozen=True, slots=True)
class FrequencyReading:
    """A natural frequency of the undamaged structure [Hz].

    Modes are counted among those that move the output `moves` more than the output `still`: a wing's flapping modes
    are those whose tip goes up more than fore and aft. Without the two all modes count.

    Attributes
    ----------
    number : int
        Number of the mode, from 0.
    measured, sd : float
        Frequency and its standard deviation [Hz].
    moves, still : str
        Names of output rows, whose first row counts.
    group : str
        Name in the report.
    """

    number: int
    measured: float
    sd: float
    moves: str = ""
    still: str = ""
    group: str = "frequency"
    labels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check_scalar(self.group, self.measured, self.sd)
        if not is_whole(self.number) or self.number < 0:
            raise InputError(f"{self.group} asks for mode {self.number!r}; expected 0 or more; correct it")
        if bool(self.moves) != bool(self.still):
            raise InputError(f"{self.group} names one of moves and still; expected both or neither; name the other")

    @property
    def n_entries(self) -> int:
        """Number of residuals: one."""
        return 1


Observation = OutputReading | MassReading | FrequencyReading


def _check_scalar(group: str, measured: float, sd: float) -> None:
    if not is_number(measured) or not is_number(sd) or sd <= 0.0:
        raise InputError(
            f"{group} is {measured!r} with the sd {sd!r}; expected a finite number and an sd above 0; correct them"
        )
