"""The sensors that features are read from, and what they cost, from a table."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from octmip.errors import DataError
from octmip.formats.table.samples import read_table
from octmip.input.files import PathLike
from octmip.input.messages import shown


@dataclass(frozen=True, slots=True)
class Sensors:
    """The sensor that each feature is read from, and the cost of each sensor."""

    of_feature: tuple[str, ...]
    cost: Mapping[str, float]


def read_sensors(path: PathLike, feature_names: Sequence[str]) -> Sensors:
    """Return the sensors of a CSV file: columns `sensor,cost`, or `feature,sensor,cost` where sensors give several.

    Without a column `feature` every feature is its own sensor. Rows of columns that are not used are skipped.

    Raises
    ------
    DataError
        a column or feature is missing or named twice, or one sensor has two costs.
    """
    table = read_table(path)
    column = "feature" if "feature" in table.columns else "sensor"
    names = [str(value) for value in table.labels(column, purpose=f"{column} name")]
    sensors = [str(value) for value in table.labels("sensor", purpose="sensor name")]
    costs = table.numbers(["cost"], "sensor cost")[:, 0].tolist()
    times = Counter(names)
    missing = [name for name in feature_names if times[name] != 1]
    if missing:
        raise DataError(
            f"{path} names the feature {shown(missing[0])} {times[missing[0]]} times; expected one row for each "
            "feature used"
        )
    found: dict[str, float] = {}
    of_feature = []
    for name in feature_names:
        sensor, cost = sensors[names.index(name)], costs[names.index(name)]
        if found.setdefault(sensor, cost) != cost:
            raise DataError(f"{path} gives sensor {shown(sensor)} two costs, {found[sensor]} and {cost}; expected one")
        of_feature.append(sensor)
    return Sensors(tuple(of_feature), MappingProxyType(found))
