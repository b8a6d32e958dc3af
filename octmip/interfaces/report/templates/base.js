"use strict";
// What every page does: the switch between light and dark, figures that zoom, and details that open for print.
(() => {
  const LEAST_TEXT = 11, STEP = 1.25, MOST = 4;

  const theme = document.getElementById("theme");
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const isDark = () => (document.documentElement.dataset.theme || (dark.matches ? "dark" : "light")) === "dark";
  const nameTheme = () => { theme.textContent = isDark() ? "Light" : "Dark"; };
  theme.addEventListener("click", () => {
    document.documentElement.dataset.theme = isDark() ? "light" : "dark";
    nameTheme();
  });
  dark.addEventListener("change", nameTheme);
  nameTheme();
  theme.hidden = false;

  let opened = [];
  addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open])")];
    opened.forEach((one) => { one.open = true; });
  });
  addEventListener("afterprint", () => opened.forEach((one) => { one.open = false; }));

  // A figure in a frame: its size is the svg's width and height, its place the frame's own scrolling.
  function zoomable(box) {
    const frame = box.querySelector(".frame"), svg = frame.querySelector("svg"), output = box.querySelector(".scale");
    const width = Number(svg.getAttribute("width")), height = Number(svg.getAttribute("height"));
    const least = LEAST_TEXT / Number(box.dataset.text);
    let scale = 1;

    const fitting = () => Math.min(1, frame.clientWidth / width);
    function set(wanted, x = frame.clientWidth / 2, y = frame.clientHeight / 2) {
      const before = scale;
      scale = Math.min(MOST, Math.max(Math.min(fitting(), least) / 2, wanted));
      const left = (frame.scrollLeft + x) * scale / before - x, top = (frame.scrollTop + y) * scale / before - y;
      svg.style.width = `${width * scale}px`;
      svg.style.height = `${height * scale}px`;
      frame.classList.toggle("tiny", scale < least - 1e-9);
      frame.scrollLeft = left;
      frame.scrollTop = top;
      output.value = `${Math.round(100 * scale)} %` + (scale < least - 1e-9 ? ", text left out" : "");
    }
    function show(fraction) {  // the point of the figure at this fraction of its width stands in the middle
      frame.scrollLeft = fraction * width * scale - frame.clientWidth / 2;
    }
    const acts = {
      in: () => set(scale * STEP),
      out: () => set(scale / STEP),
      fit: () => set(fitting()),
      full: () => set(1),
    };
    const keys = { "+": "in", "=": "in", "-": "out", "0": "fit", "1": "full" };
    box.querySelectorAll("[data-zoom]").forEach((button) => {
      button.addEventListener("click", () => acts[button.dataset.zoom]());
    });
    frame.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in keys)) return;
      acts[keys[event.key]]();
      event.preventDefault();
    });
    frame.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.metaKey) return;  // plain scrolling stays the page's and the frame's
      const place = frame.getBoundingClientRect();
      set(scale * Math.exp(-event.deltaY / 300), event.clientX - place.left, event.clientY - place.top);
      event.preventDefault();
    }, { passive: false });
    drag(frame, (ratio, x, y) => set(scale * ratio, x, y));
    box.querySelector(".tools").hidden = false;
    set(Math.max(fitting(), least));
    show(Number(svg.dataset.centre || 0.5));
    let lastWidth = frame.clientWidth;
    new ResizeObserver(() => {
      if (frame.clientWidth === lastWidth) return;
      lastWidth = frame.clientWidth;
      set(Math.max(fitting(), least));
      show(Number(svg.dataset.centre || 0.5));
    }).observe(frame);
  }

  function drag(frame, pinch) {
    const pointers = new Map();
    let moved = false;
    const spread = () => {
      const [a, b] = [...pointers.values()];
      return Math.hypot(a.x - b.x, a.y - b.y);
    };
    frame.addEventListener("pointerdown", (event) => {
      if (event.button === 0) pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      moved = false;
    });
    frame.addEventListener("pointermove", (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      const now = { x: event.clientX, y: event.clientY };
      if (pointers.size === 2) {
        const before = spread(), place = frame.getBoundingClientRect();
        pointers.set(event.pointerId, now);
        const [a, b] = [...pointers.values()];
        if (before > 0) pinch(spread() / before, (a.x + b.x) / 2 - place.left, (a.y + b.y) / 2 - place.top);
      } else if (event.pointerType === "mouse") {  // touch pans by itself
        if (!moved && Math.hypot(now.x - last.x, now.y - last.y) < 4) return;
        moved = true;
        frame.classList.add("drags");
        frame.scrollLeft -= now.x - last.x;
        frame.scrollTop -= now.y - last.y;
        pointers.set(event.pointerId, now);
      }
    });
    const end = (event) => { pointers.delete(event.pointerId); frame.classList.remove("drags"); };
    for (const name of ["pointerup", "pointercancel", "pointerleave"]) frame.addEventListener(name, end);
    frame.addEventListener("click", (event) => { if (moved) event.stopPropagation(); moved = false; }, true);
  }

  document.querySelectorAll(".zoom").forEach(zoomable);
})();
