"""What every page must keep in a real browser, whatever its matter: `check_page` returns what it does not.

Looked at, at 400, 1600 and 2560 px, light and dark, technical matter folded and unfolded:

    width       the page scrolls downwards only
    text        no text is under 11 px on the screen, the scale of its drawing counted
    contrast    text against its ground is at least 4.5, or 3 where it is large (WCAG 2.2, level AA)
    silence     no message, no error, no request of the browser
    axe         axe-core finds no violation: names, roles, landmarks, headings, tables
    keyboard    Tab reaches every control, and the focus can be seen
    controls    every button can be clicked, and pressed by Enter, without any of the above being broken
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

WIDTHS = (400, 1600, 2560)
SCHEMES: dict[Literal["light", "dark"], tuple[int, ...]] = {"light": WIDTHS, "dark": (1600,)}
"""The widths of a scheme: no width changes a colour, no colour a place."""
LEAST_TEXT = 11.0

LOOK = """
(least) => {
  const found = [], seen = new Set();
  const say = (kind, node, words) => {
    const line = `${kind}: ${words} in <${node.tagName} class="${node.getAttribute("class") || ""}">`;
    if (!seen.has(line)) { seen.add(line); found.push(line); }
  };
  const page = document.scrollingElement;
  if (page.scrollWidth > innerWidth) {
    const beyond = (one) => one.getBoundingClientRect().right > innerWidth + 1;
    const wide = [...document.querySelectorAll("body *")].filter(beyond).slice(0, 3).map((one) => one.tagName);
    found.push(`width: ${page.scrollWidth} px in ${innerWidth} px, by ${wide}`);
  }
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const colours = new Map();
  const rgba = (colour) => {
    if (!colours.has(colour)) colours.set(colour, paint(colour));
    return colours.get(colour);
  };
  const paint = (colour) => {
    canvas.clearRect(0, 0, 1, 1);
    canvas.fillStyle = colour;
    canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data];
  };
  const light = (c) => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
  const luminance = ([r, g, b]) => 0.2126 * light(r) + 0.7152 * light(g) + 0.0722 * light(b);
  const shapes = [...document.querySelectorAll("svg rect, svg path, svg circle, svg polygon")]
    .filter((shape) => getComputedStyle(shape).fill !== "none")
    .map((shape) => [shape, shape.getBoundingClientRect(), rgba(getComputedStyle(shape).fill)])
    .filter(([, , fill]) => fill[3] > 250);
  const drawn = (x, y, text) => {  // what is painted under a text of a drawing: the last shape there, or nothing
    let ground = null;
    for (const [shape, box, fill] of shapes) {
      if (shape.ownerSVGElement !== text.ownerSVGElement) continue;
      if (x < box.left || x > box.right || y < box.top || y > box.bottom) continue;
      if (text.compareDocumentPosition(shape) & Node.DOCUMENT_POSITION_PRECEDING) ground = fill;
    }
    return ground;
  };
  const ground = (node) => {
    for (let one = node; one; one = one.parentElement) {
      const colour = rgba(getComputedStyle(one).backgroundColor);
      if (colour[3] > 250) return colour;
    }
    return [255, 255, 255, 255];
  };
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  let smallest = Infinity;
  for (let text = texts.nextNode(); text; text = texts.nextNode()) {
    const node = text.parentElement;
    if (!text.data.trim() || ["SCRIPT", "STYLE", "TITLE", "title", "desc"].includes(node.tagName)) continue;
    if (!node.checkVisibility({ visibilityProperty: true, opacityProperty: true })) continue;
    const range = document.createRange();
    range.selectNodeContents(text);
    const box = range.getBoundingClientRect();
    if (box.width < 1 || box.height < 1) continue;
    const style = getComputedStyle(node), inside = node.ownerSVGElement;
    const matrix = inside && node.getScreenCTM ? node.getScreenCTM() : null;
    const size = parseFloat(style.fontSize) * (matrix ? Math.hypot(matrix.a, matrix.b) : 1);
    smallest = Math.min(smallest, size);
    if (size < least - 0.01) say("text", node, `${size.toFixed(1)} px (${text.data.trim().slice(0, 30)})`);
    if (node.closest("button:disabled, option, select")) continue;
    const ink = rgba(inside ? style.fill : style.color);
    const shape = inside && drawn(box.left + box.width / 2, box.top + box.height / 2, node);
    const under = shape || ground(inside ? inside.parentElement : node);
    const [high, low] = [luminance(ink), luminance(under)].sort((a, b) => b - a);
    const contrast = (high + 0.05) / (low + 0.05);
    const isLarge = size >= 24 || (size >= 18.66 && parseInt(style.fontWeight) >= 700);
    const words = text.data.trim().slice(0, 30);
    if (contrast < (isLarge ? 3 : 4.5)) say("contrast", node, `${contrast.toFixed(2)} (${words})`);
  }
  return [found, smallest];
}
"""
FOCUS = """
() => {
  const one = document.activeElement;
  if (!one || one === document.body) return null;
  one.dataset.reached = "1";
  const drawn = (style) => style.outlineStyle !== "none" && parseFloat(style.outlineWidth) > 0;
  const marked = one.closest("svg") && one.querySelector(".focus-ring");
  const isSeen = drawn(getComputedStyle(one)) || (marked && getComputedStyle(marked).strokeOpacity !== "0");
  return [one.tagName + " " + (one.getAttribute("class") || one.id || ""), Boolean(isSeen)];
}
"""
CONTROLS = "button:enabled, summary, input:enabled, select:enabled, a[href], [tabindex='0']"
NOT_REACHED = """
(controls) => [...document.querySelectorAll(controls)]
  .filter((one) => one.checkVisibility({ visibilityProperty: true }) && one.dataset.reached !== "1")
  .map((one) => one.outerHTML.slice(0, 80))
"""


def check_page(path: Path, browser: "Browser", *, presses: bool = True) -> list[str]:
    """Return what the page of a file does not keep, nothing where all is well.

    Parameters
    ----------
    path
        of the page.
    browser
        a running Chromium of Playwright.
    presses
        also press every control: by mouse at 400 px, by keyboard at 1600 px.
    """
    page = browser.new_page()
    faults: list[str] = []
    page.on("console", lambda message: faults.append(f"silence: console {message.text}"))
    page.on("pageerror", lambda error: faults.append(f"silence: error {error}"))
    page.on("request", lambda request: _hear(faults, request.url, path))
    page.goto(path.as_uri())
    for is_open in (False, True):
        page.evaluate("(open) => document.querySelectorAll('details').forEach((one) => { one.open = open; })", is_open)
        for scheme, widths in SCHEMES.items():
            page.emulate_media(color_scheme=scheme)
            faults += _look_at_widths(page, widths, f"{scheme}, {'unfolded' if is_open else 'folded'}")
    faults += violations(page) + _reach_by_keyboard(page)
    if presses:
        faults += _press_all(page, path, 400, by_key=False) + _press_all(page, path, 1600, by_key=True)
    page.close()
    return list(dict.fromkeys(faults))


def violations(page: "Page", context: str | None = None) -> list[str]:
    """Return what axe-core finds, in the parts that a selector names; `LOOK` sees contrast in drawings too."""
    from axe_playwright_python.sync_playwright import Axe

    rules = {"resultTypes": ["violations"], "rules": {"color-contrast": {"enabled": False}}}
    found = Axe().run(page, context, rules).response["violations"]
    return [f"axe: {one['id']} ({one['help']}) of {node['html'][:80]}" for one in found for node in one["nodes"]]


def _hear(faults: list[str], url: str, path: Path) -> None:
    if url != path.as_uri():
        faults.append(f"silence: request {url}")


def _look(page: "Page", where: str) -> list[str]:
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    found: list[str] = page.evaluate(LOOK, LEAST_TEXT)[0]
    return [f"{where}: {line}" for line in found]


def _look_at_widths(page: "Page", widths: tuple[int, ...], where: str) -> list[str]:
    faults = []
    for width in widths:
        page.set_viewport_size({"width": width, "height": 900})
        faults += _look(page, f"{width} px, {where}")
    return faults


def _reach_by_keyboard(page: "Page") -> list[str]:
    faults = []
    page.evaluate("() => document.activeElement && document.activeElement.blur()")
    for _ in range(page.locator(CONTROLS).count() + 2):
        page.keyboard.press("Tab")
        at: Any = page.evaluate(FOCUS)
        if at is not None and not at[1]:
            faults.append(f"keyboard: the focus on {at[0]} cannot be seen")
    missed: list[str] = page.evaluate(NOT_REACHED, CONTROLS)
    return faults + [f"keyboard: Tab does not reach {what}" for what in missed]


def _press_all(page: "Page", path: Path, width: int, by_key: bool) -> list[str]:
    """Press every button and summary that is there at first, and look after each."""
    page.set_viewport_size({"width": width, "height": 900})
    page.goto(path.as_uri())
    where = f"{width} px, after {'Enter on' if by_key else 'a click on'}"
    faults = []
    for control in page.locator("button:enabled, summary").element_handles():
        if not control.is_visible() or not control.is_enabled():
            continue
        name = control.get_attribute("aria-label") or control.inner_text()
        if by_key:
            control.press("Enter")
        else:
            control.click(timeout=5000)
        faults += _look(page, f"{where} {name!r}")
    return faults
