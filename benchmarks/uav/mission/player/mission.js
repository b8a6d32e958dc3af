"use strict";
// One mission, drawn step by step. Everything that is shown lies in the element #mission; nothing is fetched. Charts are
// drawn at the width that they have, so that their text keeps its size.
(() => {
  const data = JSON.parse(document.getElementById("mission").textContent);
  const steps = data.steps, last = steps.length - 1;
  const by = (id) => document.getElementById(id);
  const percent = (v) => `${Math.round(100 * v)} %`;

  function element(name, attributes, parent, text) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    if (parent) parent.appendChild(made);
    return made;
  }
  function picture(box, height, title) {
    const width = Math.max(240, box.clientWidth);
    const svg = element("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img" }, null);
    element("title", {}, svg, title);
    box.replaceChildren(svg);
    return [svg, width];
  }
  const points = (list) => list.map((p) => p.map((v) => v.toFixed(1)).join(",")).join(" ");
  const line = (svg, x1, y1, x2, y2, kind) => element("line", { x1, y1, x2, y2, class: kind }, svg);
  const words = (svg, x, y, text, anchor = "middle", kind = "") =>
    element("text", { x, y, "text-anchor": anchor, class: kind }, svg, text);

  function drawCourse() {
    const box = by("course"), course = data.course;
    const every = [...course.lines.flatMap((one) => one.points), ...steps.filter((s) => s.at).map((s) => s.at),
      ...course.obstacles.flatMap(([x, y, r]) => [[x - r, y - r], [x + r, y + r]])];
    const range = (k) => [Math.min(...every.map((p) => p[k])), Math.max(...every.map((p) => p[k]))];
    const [left, right] = range(0), [low, high] = range(1), height = 220;
    const [svg, width] = picture(box, height, "The course from above, and the way so far");
    const X = (x) => 14 + (x - left) / (right - left || 1) * (width - 28);
    const Y = (y) => height - 14 - (y - low) / (high - low || 1) * (height - 28);
    course.lines.forEach((one, k) => element("polyline",
      { points: points(one.points.map(([x, y]) => [X(x), Y(y)])), class: k ? "plan second" : "plan" }, svg));
    for (const [x, y, r] of course.obstacles)
      element("ellipse", { cx: X(x), cy: Y(y), rx: X(x + r) - X(x), ry: Y(y) - Y(y + r), class: "obstacle" }, svg);
    if (course.goal !== null) line(svg, X(course.goal), 6, X(course.goal), height - 6, "plan second");
    by("course-words").textContent = course.lines.map((one, k) => `${k ? "dashed" : "thin"}: ${one.name}`).join("; ")
      + `${course.lines.length ? "; " : ""}thick: the way, orange where cautious`;
    const flown = element("g", {}, svg), craft = element("path", { d: "M9,0 L-6,5 L-3,0 L-6,-5 Z", class: "craft" }, svg);
    return (k) => {
      flown.replaceChildren();
      const seen = steps.slice(0, k + 1).filter((s) => s.at);
      for (let i = 1; i < seen.length; i++)
        line(flown, X(seen[i - 1].at[0]), Y(seen[i - 1].at[1]), X(seen[i].at[0]), Y(seen[i].at[1]),
          seen[i - 1].cautious ? "cautious" : "bold");
      const b = seen[seen.length - 1], a = seen[Math.max(0, seen.length - 2)];
      if (!b) return;
      const turn = Math.atan2(Y(b.at[1]) - Y(a.at[1]), X(b.at[0]) - X(a.at[0])) * 180 / Math.PI;
      craft.setAttribute("transform", `translate(${X(b.at[0])},${Y(b.at[1])}) rotate(${turn})`);
    };
  }

  function drawStructure() {
    const { outline, gauges, regions } = data.structure;
    const every = [...outline, ...gauges.map((g) => g.at), ...regions.flatMap((r) => r.outline)];
    const range = (k) => [Math.min(...every.map((p) => p[k])), Math.max(...every.map((p) => p[k]))];
    const [fore, aft] = range(0), [root, tip] = range(1);
    const rows = !regions.length ? [""] : steps[last].truth ? ["as believed", "as it is"] : ["as believed"];
    const box = by("structure"), wide = Math.max(240, box.clientWidth);
    const scale = (wide - 30) / (tip - root || 1), depth = Math.min(150, Math.max(30, (aft - fore) * scale));
    const [svg] = picture(box, rows.length * (depth + 40), "The structure, its gauges and its regions");
    const across = (aft - fore) ? depth / (aft - fore) : 0;
    const patches = [], dots = [];
    rows.forEach((title, row) => {
      const top = row * (depth + 40) + 24, place = ([x, y]) => [15 + (y - root) * scale, top + (x - fore) * across];
      words(svg, 4, top - 8, title, "start", "name");
      if (outline.length) element("polygon", { points: points(outline.map(place)), class: "outline" }, svg);
      patches.push(regions.map((r) => element("polygon", { points: points(r.outline.map(place)), class: "region" }, svg)));
      for (const g of row ? [] : gauges) {
        const [cx, cy] = place(g.at), dot = element("circle", { cx, cy, r: 3.2, class: "dot" }, svg);
        element("title", {}, dot, g.name);
        dots.push([g.name, dot]);
      }
    });
    return (k) => {
      const step = steps[k], known = [step.belief && step.belief.map((one) => one.median), step.truth];
      patches.forEach((set, row) => set.forEach((patch, i) => {
        const of = regions[i].of, value = known[row] ? known[row][of] : 0, most = data.parameters[of].most;
        const share = Math.round(100 * Math.min(1, Math.max(0, value / most)));
        patch.setAttribute("style", `fill: color-mix(in srgb, var(--class-5) ${share}%, var(--paper))`);
      }));
      for (const [name, dot] of dots) dot.setAttribute("class", step.off.includes(name) ? "off" : "dot");
    };
  }

  const ticks = (most) => [0, .25, .5, .75, 1].map((t) => t * most);

  function drawNow(j) {
    const parameter = data.parameters[j], [svg, width] = picture(by(`now${j + 1}`), 190, `Belief in ${parameter.name}`);
    const X = (v) => 18 + v / parameter.most * (width - 50), bottom = 160;
    const first = steps.find((s) => s.belief).belief[j], step = parameter.most / first.at.length;
    const bars = first.at.map((v) => element("rect",
      { x: X(v - step / 2) + .5, width: Math.max(1, X(step) - X(0) - 1), class: "bar" }, svg));
    line(svg, X(0), bottom, X(parameter.most), bottom, "grid");
    for (const v of ticks(parameter.most)) words(svg, X(v), bottom + 17, percent(v));
    if (parameter.limit !== null) line(svg, X(parameter.limit), 8, X(parameter.limit), bottom, "limit");
    const truth = line(svg, 0, 8, 0, bottom, "truth"), told = element("path", { d: "M0,0 l-5,-10 h10 Z", class: "told" }, svg);
    const tree = data.trees.findIndex((one) => one.name === parameter.name);
    return (k) => {
      const at = steps[k], belief = at.belief && at.belief[j], top = belief ? Math.max(...belief.bars) : 1;
      bars.forEach((bar, i) => {
        const tall = belief ? 130 * belief.bars[i] / top : 0;
        bar.setAttribute("y", bottom - tall);
        bar.setAttribute("height", tall);
      });
      truth.setAttribute("visibility", at.truth ? "visible" : "hidden");
      if (at.truth) for (const end of ["x1", "x2"]) truth.setAttribute(end, X(at.truth[j]));
      const says = tree < 0 ? null : at.told[tree];
      told.setAttribute("visibility", says === null ? "hidden" : "visible");
      if (says !== null) told.setAttribute("transform", `translate(${X(says)},${bottom})`);
    };
  }

  function axes(svg, width, height, most) {
    const X = (k) => 46 + k * (width - 58) / (last || 1), Y = (v) => height - 32 - v / most * (height - 44);
    return [X, Y];
  }
  function stepAxis(svg, X, height) {
    for (const k of [...new Set([0, Math.round(last / 2), last])])
      words(svg, X(k), height - 17, k, k === last && last ? "end" : "middle");
    words(svg, X(last / 2), height - 4, "step");
  }

  function drawOver(j) {
    const parameter = data.parameters[j], height = 190;
    const [svg, width] = picture(by(`over${j + 1}`), height, `${parameter.name} over the steps`);
    const [X, Y] = axes(svg, width, height, parameter.most);
    for (const v of ticks(parameter.most)) {
      line(svg, 46, Y(v), width - 12, Y(v), "grid");
      words(svg, 41, Y(v) + 4, percent(v), "end");
    }
    if (parameter.limit !== null) line(svg, 46, Y(parameter.limit), width - 12, Y(parameter.limit), "limit");
    stepAxis(svg, X, height);
    const band = element("polygon", { class: "band" }, svg), told = element("g", {}, svg);
    const truth = element("polyline", { class: "truth" }, svg), median = element("polyline", { class: "belief" }, svg);
    const tree = data.trees.findIndex((one) => one.name === parameter.name);
    return (k) => {
      const seen = steps.slice(0, k + 1).map((s, i) => [s, i]), believed = seen.filter(([s]) => s.belief);
      const of = (name) => believed.map(([s, i]) => [X(i), Y(Math.min(parameter.most, s.belief[j][name]))]);
      median.setAttribute("points", points(of("median")));
      band.setAttribute("points", points([...of("low"), ...of("high").reverse()]));
      truth.setAttribute("points", points(seen.filter(([s]) => s.truth).map(([s, i]) => [X(i), Y(s.truth[j])])));
      told.replaceChildren(...(tree < 0 ? [] : seen.filter(([s]) => s.told[tree] !== null))
        .map(([s, i]) => element("circle", { cx: X(i), cy: Y(s.told[tree]), r: 2, class: "told" })));
    };
  }

  function drawStrain(g, box) {
    const name = data.traced[g], height = 190, [svg, width] = picture(box, height, `Strain of gauge ${name}`);
    const values = steps.flatMap((s) => s.strain[g]).filter((v) => v !== null);
    const low = Math.min(...values), high = Math.max(...values);
    const [X] = axes(svg, width, height, 1), Y = (v) => height - 34 - (v - low) / (high - low || 1) * (height - 50);
    for (const v of high > low ? [low, high] : [low]) {
      line(svg, 46, Y(v), width - 12, Y(v), "grid");
      words(svg, 41, Y(v) + 4, Math.round(v), "end");
    }
    stepAxis(svg, X, height);
    const dots = element("g", {}, svg), expected = element("polyline", { class: "belief" }, svg);
    return (k) => {
      const seen = steps.slice(0, k + 1).map((s, i) => [s.strain[g], i]);
      expected.setAttribute("points", points(seen.filter(([s]) => s[1] !== null).map(([s, i]) => [X(i), Y(s[1])])));
      dots.replaceChildren(...seen.filter(([s]) => s[0] !== null)
        .map(([s, i]) => element("circle", { cx: X(i), cy: Y(s[0]), r: 2, class: "dot" })));
    };
  }

  function drawTree(t) {
    const box = by(`tree${t + 1}`), nodes = data.trees[t].nodes, spans = [];
    const html = (name, parent, kind, text) => {
      const made = document.createElement(name);
      if (kind) made.className = kind;
      if (text !== undefined) made.textContent = text;
      parent.appendChild(made);
      return made;
    };
    box.replaceChildren();
    const lists = [];
    nodes.forEach((node, i) => {
      const parent = node.parent < 0 ? html("ul", box) : lists[node.parent];
      const item = html("li", parent);
      if (node.side) html("span", item, "side", node.side);
      spans.push(html("span", item, node.leaf ? "leaf" : "", node.text + (node.leaf ? "" : " ?")));
      lists[i] = node.leaf ? null : html("ul", item);
    });
    return (k) => {
      const lit = new Set(steps[k].paths[t]);
      spans.forEach((span, i) => span.classList.toggle("lit", lit.has(i)));
    };
  }

  let drawers = [];
  function build() {
    const boxes = data.traced.map((name) => {
      const figure = document.createElement("figure"), head = document.createElement("h3"), box = document.createElement("div");
      head.textContent = `Gauge ${name}`;
      box.className = "chart";
      figure.append(head, box);
      return figure;
    });
    by("strain").replaceChildren(...boxes);
    drawers = [
      ...(by("course") ? [drawCourse()] : []), ...(by("structure") ? [drawStructure()] : []),
      ...data.parameters.flatMap((_, j) => by(`over${j + 1}`) ? [drawOver(j), drawNow(j)] : []),
      ...boxes.map((figure, g) => drawStrain(g, figure.lastChild)), ...data.trees.map((_, t) => drawTree(t)),
    ];
  }

  const slider = by("slider"), play = by("play"), live = by("words");
  let at = 0, timer = null;
  function show(k) {
    at = Math.max(0, Math.min(last, k));
    slider.value = at;
    drawers.forEach((draw) => draw(at));
    const step = steps[at];
    by("decision").textContent = step.decision;
    by("decision").className = step.cautious ? "cautious" : "";
    by("reason").textContent = step.refused ? `This reading is refused: ${step.refused}` : step.reason;
    by("found").textContent = step.alarm;
    const numbers = [["Reading taken at load factor", step.load], ...step.figures];
    if (step.p !== null) numbers.push(["Chance of a reading as far off, were the library right", step.p.toFixed(3)]);
    by("numbers").replaceChildren(...numbers.map(([name, value]) => {
      const pair = document.createElement("div"), dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name;
      dd.textContent = value;
      pair.append(dt, dd);
      return pair;
    }));
    by("step").value = `step ${at} of ${last}`;
  }
  function stop() {
    clearInterval(timer);
    timer = null;
    play.textContent = "Play";
    live.setAttribute("aria-live", "polite");
  }
  function toggle() {
    if (timer) return stop();
    if (at === last) show(0);
    play.textContent = "Pause";
    live.setAttribute("aria-live", "off");  // a sentence for each step would be read out of breath
    timer = setInterval(() => { show(at + 1); if (at === last) stop(); }, 90);
  }
  const jump = (k) => { stop(); show(k); };
  slider.addEventListener("input", () => jump(Number(slider.value)));
  play.addEventListener("click", toggle);
  by("back").addEventListener("click", () => jump(at - 1));
  by("on").addEventListener("click", () => jump(at + 1));
  document.querySelectorAll("[data-step]").forEach((button) => {
    button.addEventListener("click", () => { jump(Number(button.dataset.step)); live.scrollIntoView({ block: "center" }); });
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const moves = { ArrowRight: at + 1, ArrowLeft: at - 1, PageDown: at + 10, PageUp: at - 10, Home: 0, End: last };
    const onControl = event.target.closest("button, summary, a, .scroll, .frame");
    if (event.key === " " && !onControl) { event.preventDefault(); toggle(); }
    else if (event.key in moves && (!onControl || event.key.startsWith("Arrow"))) {
      event.preventDefault();
      jump(moves[event.key]);
    }
  });
  build();
  show(location.hash ? Math.min(last, Number(location.hash.slice(1)) || 0) : last);  // the whole mission at first
  let width = document.body.clientWidth;
  new ResizeObserver(() => {
    if (document.body.clientWidth === width) return;
    width = document.body.clientWidth;
    build();
    show(at);
  }).observe(document.body);
})();
