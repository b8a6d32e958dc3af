"""The page that plays a mission: one HTML file with its own style, script and data, nothing from elsewhere."""

import base64
import hashlib
import json
from pathlib import Path
from typing import Any

from octmip.formats.names import html_text

FOLDER = Path(__file__).parent
SECTIONS = (
    ("course", "The course: three obstacles"),
    ("wing", "The wing, as it is believed to be and as it is"),
    ("over1", "mu1 over time"),
    ("over2", "mu2 over time"),
    ("now", "The belief now"),
    ("tree1", "Tree for mu1, the way of this reading"),
    ("tree2", "Tree for mu2, the way of this reading"),
    ("strain", "Three gauges"),
)


def mission_page(flight: dict[str, Any]) -> str:
    """Return the page of a recorded mission (see flight.py)."""
    kinds = {
        "paper": "both regions lose stiffness from 0 to 80 %",
        "own rate": "each region at a rate of its own",
        "sudden": "a sudden damage",
        "dead gauge": "both regions lose stiffness, and a gauge dies",
        "outside": "both regions lose stiffness, and a third that the library lacks",
    }
    style, script = (FOLDER / "page.css").read_text(), (FOLDER / "page.js").read_text()
    # "<" as an escape: no text in the data can then end the element
    data = json.dumps(flight, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    sections = "\n".join(f'<section id="{name}"><h2>{title}</h2></section>' for name, title in SECTIONS)
    policy = _policy(script)
    about = f"{kinds[flight['kind']]}; {flight['source']}; policy: {flight['policy']}; seed {flight['seed']}"
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8">{policy}<meta name="viewport" content="width=device-width">
<title>A self-aware aircraft</title><link rel="icon" href="data:,"><style>{style}</style></head>
<body><main>
<header><h1>A self-aware aircraft</h1><p>{html_text(about)}</p></header>
<section id="controls"><button id="play">Play</button>
<input id="slider" type="range" min="0" value="0" step="1" aria-label="step"><span id="step"></span></section>
<section id="words" aria-live="polite">
<span id="decision"></span><span id="reason"></span><p id="numbers"></p></section>
{sections}
</main>
<script type="application/json" id="data">{data}</script>
<script>{script}</script>
</body></html>
"""


def _policy(script: str) -> str:
    """Return the element by which a browser runs this one script, by its hash, and fetches nothing."""
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    sources = f"default-src 'none'; script-src 'sha256-{digest}'; style-src 'unsafe-inline'; img-src data:"
    rest = "base-uri 'none'; form-action 'none'"
    return f'<meta http-equiv="Content-Security-Policy" content="{sources}; {rest}">'
