"""Pages from templates: one HTML text, whole in itself, that asks for nothing from elsewhere.

Every page extends `templates/base.html`, which says what its blocks are. Text is escaped wherever it stands, and
characters that act instead of being seen are shown as escapes (`octmip.input.names`). A browser runs only the
scripts that were written for the page: their digests stand in its security policy.
"""

import base64
import datetime
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import jinja2
from jinja2.utils import htmlsafe_json_dumps
from markupsafe import Markup

from octmip.input.names import shown, visible, visible_lines
from octmip.interfaces.report.text import number, percent

POLICY = (
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; script-src {}"
)


@dataclass(frozen=True, slots=True)
class Masthead:
    """What a reader says of a page: its heading, the machine that it is about, its day.

    Attributes
    ----------
    title
        heading of the page; "" for the page's own.
    asset
        name of the machine, above the heading; "" where it has none.
    made
        day of the page; today by default.
    """

    title: str = ""
    asset: str = ""
    made: datetime.date | None = None


def render(
    template: str,
    *,
    masthead: Masthead | None = None,
    folder: Path | None = None,
    styles: Sequence[str] = (),
    scripts: Sequence[str] = (),
    **context: Any,
) -> str:
    """Return the page that a template makes of a context.

    Parameters
    ----------
    template
        name of a file of `octmip/interfaces/report/templates` that extends base.html.
    masthead
        heading and asset that stand in place of the template's own.
    folder
        where else template and further files may lie.
    styles, scripts
        names of further files there, used after style.css and base.js.
    **context
        values for the template; one that it names and that is not given is an error. `facts`, the pairs of names and
        texts in the footer, is needed by every page (`page_facts`).
    """
    environment = _environment(folder)
    texts = [_source(environment, name) for name in ("base.js", *scripts)]
    page = environment.get_template(template).render(
        context,
        masthead=masthead or Masthead(),
        policy=POLICY.format(" ".join(f"'sha256-{_digest(text)}'" for text in texts)),
        styles=[Markup(_source(environment, name)) for name in ("style.css", *styles)],
        scripts=[Markup(text) for text in texts],
    )
    return page + "\n"


def page_facts(
    data: str | None = None, sha256: str | None = None, made: datetime.date | None = None, **more: str
) -> list[tuple[str, str]]:
    """Return the pairs of a footer: date, data file, digest of the data, version, and others by name.

    Parameters
    ----------
    data
        name of the data file.
    sha256
        digest of the data.
    made
        day on which the page was made; today by default.
    **more
        further facts, underscores of their names read as blanks.
    """
    made = made or datetime.date.today()
    facts = [("Made", f"{made.day} {made:%B %Y}")]
    facts += [("Data", shown(data))] if data else []
    facts += [("SHA-256 of the data", sha256)] if sha256 else []
    facts += [(name.replace("_", " "), value) for name, value in more.items()]
    return [*facts, ("octmip", version("octmip"))]


def count(value: int) -> str:
    """Return a whole number with its thousands apart: 1,234,567."""
    return f"{value:,}"


@cache
def _environment(folder: Path | None) -> jinja2.Environment:
    own: list[jinja2.BaseLoader] = [jinja2.PackageLoader("octmip.interfaces.report")]
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader(own if folder is None else [*own, jinja2.FileSystemLoader(folder)]),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: value if isinstance(value, jinja2.Undefined) else _readable(value),
    )
    environment.globals["embed"] = _embedded
    environment.filters |= {
        "number": number,
        "percent": percent,
        "count": count,
        "shown": shown,
        "lines": _lines,
        "px": _pixels,
        "markup": Markup,  # for drawings made by this package, whose texts are escaped
    }
    return environment


def _embedded(name: str, value: Mapping[str, Any] | Sequence[Any]) -> Markup:
    """Return data for the scripts of a page, as an element that no browser runs."""
    text = htmlsafe_json_dumps(value, allow_nan=False, separators=(",", ":"))
    return Markup('<script type="application/json" id="{}">{}</script>').format(visible(name), text)


def _lines(text: str) -> Markup:
    return Markup("{}").format(visible_lines(text))


def _pixels(value: float, digits: int = 1) -> str:
    """Return a length for an attribute: no thousands, no zeros that say nothing."""
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") if value != int(value) else str(int(value))


def _readable(value: Any) -> Any:
    """Return what may stand on a page: text made visible, whole numbers; nothing else has a form for readers."""
    if hasattr(value, "__html__"):
        return value
    if isinstance(value, str):
        return visible(value)
    if isinstance(value, int) and not isinstance(value, bool):
        return count(value)
    raise TypeError(f"a page was given {value!r} of type {type(value).__name__}; expected text or a whole number")


def _source(environment: jinja2.Environment, name: str) -> str:
    assert environment.loader is not None
    return environment.loader.get_source(environment, name)[0]


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
