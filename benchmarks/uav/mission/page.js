"use strict";
// One mission, drawn step by step. Everything that is shown lies in the element #data; nothing is fetched.
const data = JSON.parse(document.getElementById("data").textContent);
const steps = data.steps, last = steps.length - 1, NAMES = ["mu1", "mu2"];
const SAFE = "#0072b2", WARN = "#d55e00", INK = "#1f2933", QUIET = "#7b8794", LINE = "#d9dee4";
const percent = v => Math.round(100 * v) + " %";
const by = id => document.getElementById(id);

function element(name, attributes, parent, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}
function picture(id, width, height) {
  const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": id });
  by(id).appendChild(svg);
  return svg;
}
const points = list => list.map(p => p.map(v => v.toFixed(1)).join(",")).join(" ");
function colour(damage) { // white to red over 0 to 80 %
  const t = Math.min(1, damage / 0.8);
  return `rgb(${Math.round(255 - 50 * t)},${Math.round(245 - 190 * t)},${Math.round(235 - 205 * t)})`;
}

// The course: both lines, obstacles, the way flown so far
const course = (() => {
  const svg = picture("course", 700, 190), X = x => 12 + x * 676 / data.goal, Y = y => 165 - y * 1.9;
  const line = (list, dash) => element("polyline", { points: points(list.map(([x, y]) => [X(x), Y(y)])), fill: "none",
    stroke: QUIET, "stroke-dasharray": dash, "stroke-width": 1 }, svg);
  line(data.lines[0], "2 3"); line(data.lines[1], "6 4");
  for (const x of data.obstacles)
    element("ellipse", { cx: X(x), cy: Y(5), rx: data.radius * 676 / data.goal, ry: data.radius * 1.9 - 2, fill: "#9aa5b1" }, svg);
  element("line", { x1: X(data.goal), x2: X(data.goal), y1: 20, y2: 172, stroke: INK, "stroke-width": 3, "stroke-dasharray": "5 5" }, svg);
  element("text", { x: 12, y: 14, class: "q" }, svg, "dotted: tight, turns of 3 g; dashed: wide, turns of 2 g; blue: flown at 3 g; orange: flown at 2 g");
  const flown = element("g", {}, svg), craft = element("path", { d: "M8,0 L-6,5 L-3,0 L-6,-5 Z", fill: INK }, svg);
  return k => {
    flown.replaceChildren();
    for (let i = 1; i <= k; i++)
      element("line", { x1: X(steps[i - 1].x), y1: Y(steps[i - 1].y), x2: X(steps[i].x), y2: Y(steps[i].y),
        stroke: steps[i - 1].load < 3 ? WARN : SAFE, "stroke-width": 3.5, "stroke-linecap": "round" }, flown);
    const a = steps[Math.max(0, k - 1)], b = steps[k];
    const turn = Math.atan2(Y(b.y) - Y(a.y), X(b.x) - X(a.x)) * 180 / Math.PI;
    craft.setAttribute("transform", `translate(${X(b.x)},${Y(b.y)}) rotate(${turn})`);
  };
})();

// The wing twice: as the belief has it and as it is
const wing = (() => {
  const svg = picture("wing", 500, 262), S = 245, place = ([x, y], row) => [20 + y * S, 58 + row * 122 + x * S];
  const patches = [], dots = [];
  ["believed", "true"].forEach((title, row) => {
    element("polygon", { points: points(data.outline.map(p => place(p, row))), fill: "#fff", stroke: INK }, svg);
    patches.push(data.regions.map(r => element("polygon", { points: points(r.map(p => place(p, row))), stroke: QUIET, "stroke-width": .6 }, svg)));
    patches[row].texts = data.regions.map(r => {
      const [x, y] = place(r[2], row); return element("text", { x: x - 28, y: y + 14, "text-anchor": "middle" }, svg);
    });
    element("text", { x: 30, y: 48 + row * 122 }, svg, title);
  });
  for (const g of data.gauges) {
    const [cx, cy] = place(g.at, 0);
    dots.push([g.name, element("circle", { cx, cy, r: 2.6, fill: QUIET }, svg)]);
  }
  element("text", { x: 20, y: 12, class: "q" }, svg, "white: sound, red: 80 % lost; dots: gauges (orange: disagree)");
  return k => {
    const step = steps[k], known = [NAMES.map(n => step.belief[n].median), step.truth];
    patches.forEach((set, row) => set.forEach((p, i) => {
      p.setAttribute("fill", colour(known[row][i]));
      set.texts[i].textContent = `${NAMES[i]} ${percent(known[row][i])}`;
    }));
    for (const [name, dot] of dots) dot.setAttribute("fill", step.off.includes(name) ? WARN : QUIET);
  };
})();

// The belief at this step
const now = (() => {
  const svg = picture("now", 600, 150), all = [];
  NAMES.forEach((name, j) => {
    const left = 40 + j * 300, W = 240, X = v => left + v / 0.8 * W;
    const bars = steps[0].belief[name].bars.map((_, i, list) =>
      element("rect", { x: left + i * W / list.length + .5, width: W / list.length - 1, fill: SAFE }, svg));
    element("line", { x1: left, x2: left + W, y1: 120, y2: 120, stroke: LINE }, svg);
    for (const v of [0, .2, .4, .6, .8]) element("text", { x: X(v), y: 134, "text-anchor": "middle", class: "q" }, svg, percent(v));
    element("line", { x1: X(data.critical), x2: X(data.critical), y1: 12, y2: 120, stroke: WARN, "stroke-dasharray": "4 3" }, svg);
    const truth = element("line", { y1: 8, y2: 120, stroke: INK, "stroke-width": 2 }, svg);
    const told = element("path", { d: "M0,0 l-5,-9 h10 Z", fill: "#e69f00" }, svg);
    element("text", { x: left - 6, y: 20, "text-anchor": "end" }, svg, name);
    all.push({ name, j, X, bars, truth, told });
  });
  element("text", { x: 300, y: 148, "text-anchor": "middle", class: "q" }, svg,
    "bars: belief of the filter; black: truth; yellow: what the tree says of this reading alone; dashed: 40 %");
  return k => {
    for (const { name, j, X, bars, truth, told } of all) {
      const step = steps[k], top = Math.max(...step.belief[name].bars);
      step.belief[name].bars.forEach((p, i) => {
        bars[i].setAttribute("y", 120 - 95 * p / top); bars[i].setAttribute("height", 95 * p / top);
      });
      truth.setAttribute("x1", X(step.truth[j])); truth.setAttribute("x2", X(step.truth[j]));
      told.setAttribute("transform", `translate(${X(step.told[j])},119)`);
    }
  };
})();

// Estimates over time
const over = NAMES.map((name, j) => {
  const svg = picture("over" + (j + 1), 300, 180), X = k => 34 + k * 256 / last, Y = v => 155 - v * 165;
  for (const v of [0, .2, .4, .6, .8]) {
    element("line", { x1: 34, x2: 290, y1: Y(v), y2: Y(v), stroke: v === .4 ? WARN : LINE, "stroke-dasharray": v === .4 ? "4 3" : "" }, svg);
    element("text", { x: 30, y: Y(v) + 4, "text-anchor": "end", class: "q" }, svg, percent(v));
  }
  const band = element("polygon", { fill: SAFE, opacity: .22 }, svg), told = element("g", {}, svg);
  const truth = element("polyline", { fill: "none", stroke: INK, "stroke-width": 1.5 }, svg);
  const median = element("polyline", { fill: "none", stroke: SAFE, "stroke-width": 2 }, svg);
  element("text", { x: 162, y: 174, "text-anchor": "middle", class: "q" }, svg, "step");
  return k => {
    const seen = steps.slice(0, k + 1), of = s => s.belief[name];
    truth.setAttribute("points", points(seen.map((s, i) => [X(i), Y(s.truth[j])])));
    median.setAttribute("points", points(seen.map((s, i) => [X(i), Y(of(s).median)])));
    band.setAttribute("points", points([...seen.map((s, i) => [X(i), Y(of(s).low)]), ...seen.map((s, i) => [X(i), Y(of(s).high)]).reverse()]));
    told.replaceChildren(...seen.map((s, i) => element("circle", { cx: X(i), cy: Y(s.told[j]), r: 1.8, fill: "#e69f00" })));
  };
});

// Three gauges: measured, and as the believed model has it
const strain = (() => {
  const svg = picture("strain", 1200, 170), W = 350, all = [];
  data.traced.forEach((name, g) => {
    const values = steps.flatMap(s => s.strain[g]), low = Math.min(...values), high = Math.max(...values);
    const left = 40 + g * 395, X = k => left + k * (W - 20) / last, Y = v => 135 - (v - low) / (high - low || 1) * 110;
    element("text", { x: left, y: 14 }, svg, name);
    element("text", { x: left - 4, y: Y(high) + 4, "text-anchor": "end", class: "q" }, svg, Math.round(high));
    element("text", { x: left - 4, y: Y(low) + 4, "text-anchor": "end", class: "q" }, svg, Math.round(low));
    all.push({ g, X, Y, dots: element("g", {}, svg), line: element("polyline", { fill: "none", stroke: SAFE, "stroke-width": 2 }, svg) });
  });
  element("text", { x: 600, y: 162, "text-anchor": "middle", class: "q" }, svg,
    "microstrain per unit of load factor; dots: measured; line: model of the believed state");
  return k => all.forEach(({ g, X, Y, dots, line }) => {
    const seen = steps.slice(0, k + 1);
    line.setAttribute("points", points(seen.map((s, i) => [X(i), Y(s.strain[g][1])])));
    dots.replaceChildren(...seen.map((s, i) => element("circle", { cx: X(i), cy: Y(s.strain[g][0]), r: 1.6, fill: QUIET })));
  });
})();

// The trees, the way of this reading lit
const trees = data.trees.map((nodes, t) => {
  const svg = picture("tree" + (t + 1), 600, 190), X = v => 40 + v * 520, Y = v => 18 + v * 150;
  const edges = nodes.map(n => n.parent < 0 ? null : element("line", { x1: X(nodes[n.parent].x), y1: Y(nodes[n.parent].y), x2: X(n.x), y2: Y(n.y) }, svg));
  const boxes = nodes.map(n => element("rect", { x: X(n.x) - (n.is_leaf ? 22 : 42), y: Y(n.y) - 9, width: n.is_leaf ? 44 : 84, height: 18, rx: n.is_leaf ? 9 : 2 }, svg));
  nodes.forEach(n => element("text", { x: X(n.x), y: Y(n.y) + 4, "text-anchor": "middle", style: "font-size:10px" }, svg, n.text));
  return k => {
    const lit = new Set(steps[k].paths[t]);
    nodes.forEach((n, i) => {
      const on = lit.has(i);
      boxes[i].setAttribute("fill", on ? "#ffe8b3" : "#fff"); boxes[i].setAttribute("stroke", on ? "#e69f00" : LINE);
      if (edges[i]) { edges[i].setAttribute("stroke", on ? "#e69f00" : LINE); edges[i].setAttribute("stroke-width", on ? 3 : 1); }
    });
  };
});

const drawers = [course, wing, now, strain, ...over, ...trees];
const slider = by("slider"), play = by("play");
let at = 0, timer = null;
function show(k) {
  at = Math.max(0, Math.min(last, k));
  slider.value = at;
  drawers.forEach(draw => draw(at));
  const step = steps[at];
  by("decision").textContent = step.load < 3 ? "2 g, wide" : "3 g, tight";
  by("decision").style.background = step.load < 3 ? WARN : SAFE;
  by("reason").textContent = step.words;
  by("numbers").textContent = `Capability ${step.believed_to_bear.toFixed(2)} g believed, ${step.bears.toFixed(2)} g true; P(either over 40 %) ${percent(step.above)}; reading taken at ${step.read_at} g; `
    + `p of the reading ${step.p.toFixed(3)}; log10 evidence against the library ${step.log_e.toFixed(1)}.`;
  by("step").textContent = `step ${at} of ${last}`;
}
function stop() { clearInterval(timer); timer = null; play.textContent = "Play"; }
function toggle() {
  if (timer) return stop();
  if (at === last) show(0);
  play.textContent = "Pause";
  timer = setInterval(() => { show(at + 1); if (at === last) stop(); }, 90);
}
slider.max = last;
slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
play.addEventListener("click", () => { toggle(); play.blur(); }); // so that a space is heard once, by the page
document.addEventListener("keydown", event => {
  const moves = { ArrowRight: at + 1, ArrowLeft: at - 1, PageDown: at + 10, PageUp: at - 10, Home: 0, End: last };
  if (event.key === " ") { event.preventDefault(); toggle(); }
  else if (event.key in moves) { event.preventDefault(); stop(); show(moves[event.key]); }
});
show(Math.min(last, Number(location.hash.slice(1)) || 0));
