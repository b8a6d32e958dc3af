"""Units as loggers write them, in a row under the header or behind a name: `g1 [mm]`, `Force/N`, `g1 - mm`.

A unit is a quantity and its size in the SI unit of that quantity. Temperatures begin at zeros of their own, so no
factor converts one to another.
"""

import importlib.util
import re
import tokenize
import unicodedata
from functools import cache
from typing import Any

_QUANTITIES = {
    "length": {
        "m": 1.0,
        "mm": 1e-3,
        "cm": 1e-2,
        "dm": 0.1,
        "km": 1e3,
        "um": 1e-6,
        "nm": 1e-9,
        "in": 0.0254,
        "ft": 0.3048,
    },
    "strain": {
        "strain": 1.0,
        "m/m": 1.0,
        "mm/m": 1e-3,
        "millistrain": 1e-3,
        "mε": 1e-3,
        "in/in": 1.0,
        "uin/in": 1e-6,
        "um/m": 1e-6,
        "ue": 1e-6,
        "nm/m": 1e-9,
    }
    | dict.fromkeys(("microstrain", "ustrain", "ustr", "umm/mm", "uε", "uɛ", "uE", "uepsilon"), 1e-6)
    | dict.fromkeys(("ppm", "10^-6", "1e-6", "1E-6"), 1e-6),
    "force": {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "daN": 10.0, "lbf": 4.4482216152605, "kgf": 9.80665},
    "moment": {
        f"{force}{sign}{arm}": newtons * metres
        for force, newtons in {"N": 1.0, "kN": 1e3, "MN": 1e6, "mN": 1e-3, "daN": 10.0}.items()
        for sign in ("", " ", "*", ".", "-")
        for arm, metres in {"m": 1.0, "cm": 1e-2, "mm": 1e-3}.items()
    }
    | dict.fromkeys(("lbf ft", "lbf*ft", "lbf-ft", "lb-ft", "ft-lb", "ft-lbf", "ft lbf", "ft*lbf"), 1.3558179483314004)
    | dict.fromkeys(("lbf in", "lbf*in", "lbf-in", "lb-in", "in-lb", "in-lbf", "in lbf", "in*lbf"), 0.1129848290276167),
    "stiffness": {"N/m": 1.0, "N/mm": 1e3, "kN/m": 1e3, "kN/mm": 1e6, "MN/m": 1e6, "N/um": 1e6},
    "stiffness against turning": {"Nm/rad": 1.0, "N m/rad": 1.0, "kNm/rad": 1e3, "kN m/rad": 1e3},
    "frequency": {"Hz": 1.0, "1/s": 1.0, "kHz": 1e3, "MHz": 1e6, "mHz": 1e-3, "rpm": 1 / 60, "1/min": 1 / 60},
    "pressure": {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "N/mm2": 1e6, "bar": 1e5, "mbar": 1e2}
    | {"psi": 6894.757293168, "kgf/cm2": 98066.5, "kg/cm2": 98066.5, "kgf/mm2": 9.80665e6},
    "time": {
        "s": 1.0,
        "sec": 1.0,
        "Sec": 1.0,
        "ms": 1e-3,
        "us": 1e-6,
        "ns": 1e-9,
        "min": 60.0,
        "h": 3600.0,
        "d": 86400.0,
    }
    | {"second": 1.0, "seconds": 1.0, "minutes": 60.0, "hours": 3600.0, "days": 86400.0},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "km/h": 1 / 3.6, "kn": 1852 / 3600},
    "acceleration": {"m/s2": 1.0, "m/s^2": 1.0, "m/s**2": 1.0, "mm/s2": 1e-3, "g": 9.80665, "mg": 9.80665e-3}
    | dict.fromkeys(("m s-2", "m*s-2", "m s^-2", "m/s/s"), 1.0)
    | dict.fromkeys(("gn", "g_n"), 9.80665),
    "mass": {"kg": 1.0, "t": 1e3},
    "voltage": {"V": 1.0, "Volt": 1.0, "Volts": 1.0, "mV": 1e-3, "uV": 1e-6, "kV": 1e3},
    "ratio of voltages": {"V/V": 1.0, "mV/V": 1e-3, "uV/V": 1e-6},
    "current": {"A": 1.0, "mA": 1e-3, "kA": 1e3},
    "resistance": {"Ohm": 1.0, "Ω": 1.0, "kOhm": 1e3},
    "power": {"W": 1.0, "mW": 1e-3, "kW": 1e3},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": 0.017453292519943295, "°": 0.017453292519943295},
    "rate of turn": {"rad/s": 1.0, "deg/s": 0.017453292519943295, "°/s": 0.017453292519943295},
    "share": {"-": 1.0, "1": 1.0, "%": 1e-2, "pct": 1e-2, "‰": 1e-3}
    | dict.fromkeys(("%RH", "% RH", "%rH", "% rH", "RH%", "%rF", "% r.F."), 1e-2),
    "temperature in degrees Celsius": dict.fromkeys(
        ("degC", "deg C", "°C", "C", "Deg C", "celsius", "oC", "Deg. C", "deg. C"), 1.0
    )
    | dict.fromkeys(("Degrees C", "degrees C", "DegC", "°Celsius"), 1.0),
    "temperature in kelvin": {"K": 1.0, "kelvin": 1.0},
    "temperature in degrees Fahrenheit": dict.fromkeys(("degF", "°F", "deg F", "F"), 1.0),
}
_LOGGER = frozenset({"TS", "RN", "NO.", "Time", "unitless", "bool", "text", "date", "none", "string"})
"""What a row of units says of columns that have none: time stamps and record numbers of a logger among them."""
_LABELS = frozenset({"unit", "units", "einheit", "einheiten", "unité", "unités", "unidad", "unidades"})
"""What a row of units has in a column of words, in any case."""
_TYPES = frozenset(
    {"continuous", "discrete", "class", "meta", "string", "integer", "real", "numeric", "double", "float", "boolean"}
    | {"int32", "int64", "float32", "float64", "varchar", "timestamp", "i32", "i64", "f32", "f64", "str", "object"}
)
"""What a row of types has in each column, and one of roles below it in some, in any case."""
_MEASURE = re.compile(r"(?!.*\d\s*(?:\*\*|\^)).{1,40}")
"""What is given to pint: no long text, and no power of a number, which may have any number of digits."""
_BEHIND = re.compile(
    r"(?P<name>.*?[^\s_,;/])[\s_,;/]*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\)|<(?P<c>[^>]*)>|\{(?P<d>[^}]*)\})"
)
_OVER = re.compile(r"(?P<name>\S.*?)\s*(?:/| in )\s*(?P<unit>\S+(?:/\S+)?)")
_APART = re.compile(r"(?P<name>.*[^\s_,:\u2013—-])(?:\s*[,:\u2013—-]\s*|_(?=..|N$))(?P<unit>[^\s_,:]+)")
"""Of these only what is a unit counts, since names have dashes too; `g1 - min` is the least reading of g1."""


def plain_unit(text: str) -> str:
    """Return a unit without brackets, long words in small letters, in ASCII where that does: µm/m is um/m."""
    text = unicodedata.normalize("NFKC", text.strip()).strip("[](){}<> ")
    text = text.replace("μ", "u").replace("·", "*").strip()
    return text.lower() if len(text) > 4 and text.isalpha() else text  # Microstrain, Volts; but MN is no mN


_UNITS = {plain_unit(unit): (quantity, size) for quantity, units in _QUANTITIES.items() for unit, size in units.items()}


def is_unit(text: str) -> bool:
    """Whether a text is the name of a unit, in brackets or without, or says that units stand beside it."""
    plain = plain_unit(text)
    return plain in _UNITS or plain in _LOGGER or not unit_in(text)


def is_type(cell: str) -> bool:
    """Whether a cell of a row of types, or of roles, names one."""
    return cell.lower() in _TYPES


def unit_in(cell: str) -> str:
    """Return the unit in a cell of a row of units, without brackets; "" where it only says that units stand here."""
    bare = cell.strip("[]()")
    return "" if bare.rstrip(" :").lower() in _LABELS else bare


def unit_behind(name: str) -> tuple[str, str]:
    """Return a column's name without the unit behind it, and that unit, "" where there is none."""
    apart = _APART.fullmatch(name.strip())
    if (
        apart is not None
        and apart["unit"] != "min"
        and not apart["unit"].isdigit()
        and plain_unit(apart["unit"]) in _UNITS
    ):
        return apart["name"], apart["unit"]
    for pattern in (_BEHIND, _OVER):
        found = pattern.fullmatch(name.strip())
        if found is not None:
            base, *units = found.groups()
            return base.strip(), next((unit.strip() for unit in units if unit), "")
    return name, ""


def factor_between(given: str, wanted: str) -> float | None:
    """Return what numbers in the `given` unit are multiplied by to be in the `wanted` one; None where nothing does."""
    one, other = plain_unit(given), plain_unit(wanted)
    if one == other:
        return 1.0
    (a, size), (b, wanted_size) = _UNITS.get(one, ("", 0.0)), _UNITS.get(other, (" ", 1.0))
    if {a, b} == {"strain", "share"} and {"%", "‰"} & {one, other}:  # 0.1 % of strain is 1000 microstrain
        b = a
    return size / wanted_size if a == b else _by_pint(one, other)


@cache
def _registry() -> Any:
    """Return the units of pint and strain; making them takes as long as importing pint."""
    import pint

    registry: Any = pint.UnitRegistry()
    registry.define("strain = [strain]")
    return registry


def _by_pint(given: str, wanted: str) -> float | None:
    """Return the factor that pint knows, None where it is not installed or knows none.

    pint takes rad for 1, so that 1 rpm would be 0.105 Hz and a strain an angle: units count as one quantity where
    their roots are the same, angles and strains included. Zeros of their own have no factor.
    """
    if not (given and wanted and all(map(_MEASURE.fullmatch, (given, wanted))) and importlib.util.find_spec("pint")):
        return None
    import pint  # half a second, for units that the table lacks

    registry = _registry()
    try:
        one, other = (registry.parse_expression(text) for text in (given, wanted))
        roots = [registry.Quantity(1.0, quantity.units).to_root_units().units for quantity in (one, other)]
        if roots[0] != roots[1] or (0.0 * one).to(other.units).magnitude != 0.0:
            return None
        return float((1.0 * one).to(other.units).magnitude / other.magnitude)
    except (pint.PintError, AttributeError, TypeError, ValueError, ArithmeticError, tokenize.TokenError):
        return None
    except AssertionError:  # what pint says of an inch mark
        return None
