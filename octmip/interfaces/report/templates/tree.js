"use strict";
// The page of one tree: look into a node, and follow one case from question to question.
(() => {
  const data = JSON.parse(document.getElementById("tree-data").textContent);
  const { nodes, classes, total, samples } = data;
  const svg = document.getElementById("tree"), detail = document.getElementById("detail");
  const group = (index) => svg.querySelector(`[data-node="${index}"]`);
  const edge = (index) => svg.querySelector(`[data-to="${index}"]`);
  const grouped = (count) => count.toLocaleString("en-US");
  const digits = (value) => (value >= 1 ? { maximumFractionDigits: 1 } : { maximumSignificantDigits: 2 });
  const percent = (share) => `${(100 * share).toLocaleString("en-US", digits(100 * share))} %`;
  const counted = (count, noun) => `${grouped(count)} ${noun}${count === 1 ? "" : "s"}`;
  const sum = (counts) => counts.reduce((a, b) => a + b, 0);

  function make(tag, attributes = {}, ...children) {
    const node = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
      else if (value !== false) node.setAttribute(name, value === true ? "" : value);
    }
    node.append(...children);
    return node;
  }

  const parents = new Map();
  nodes.forEach((node, index) => {
    if ("left" in node) [node.left, node.right].forEach((side) => parents.set(side, index));
  });
  const sides = (node) => (node.yesIsLeft ? [node.left, node.right] : [node.right, node.left]);  // as drawn: yes, no
  const leaves = nodes.flatMap((node, index) => ("label" in node ? [index] : []));

  // ---- a look into one node

  function bars(counts) {
    const box = make("div", { class: "bars" }), all = Math.max(1, sum(counts));
    const shown = counts.map((count, k) => [count, k]).filter(([count]) => count > 0).sort((a, b) => b[0] - a[0]);
    for (const [count, k] of shown.slice(0, 12)) {
      const bar = make("span", { class: `class-${k % 8}` });
      bar.style.width = `${100 * count / all}%`;
      box.append(make("span", { class: "name" }, classes[k]), make("span", { class: "bar" }, bar),
        make("span", { class: "value" }, `${grouped(count)} (${percent(count / all)})`));
    }
    if (shown.length > 12) box.append(make("span", { class: "name" }, `and ${shown.length - 12} more classes`));
    return box;
  }

  function sampleTable(leaf) {
    if (!samples) return make("p", { class: "note" }, "The page was made without the data, so single samples are not in it.");
    const rows = samples.leaves[leaves.indexOf(leaf)], count = sum(nodes[leaf].counts);
    if (!rows.length) return make("p", { class: "note" }, "No sample ends here.");
    const kind = (k) => (samples.isNumber[k] ? "n" : false);
    const head = make("tr", {}, make("th", { scope: "col", class: "n" }, "row"), make("th", { scope: "col" }, classes.length ? `true ${data.label}` : `${data.label} (missed by)`),
      ...samples.columns.map((name, k) => make("th", { scope: "col", class: kind(k) }, name)));
    const body = rows.map(([row, code, isWrong, ...cells]) => make("tr", { class: isWrong ? "marked" : false },
      make("td", { class: "n" }, grouped(row)), make("td", {}, code), ...cells.map((cell, k) => make("td", { class: kind(k) }, cell))));
    const which = rows.length < count ? `The first ${grouped(rows.length)} of ${grouped(count)} samples` : `All ${counted(count, "sample")}`;
    const columns = samples.columns.length < samples.of ? `, ${samples.columns.length} of ${grouped(samples.of)} columns` : "";
    const some = rows.some((row) => row[2]) ? "; wrong ones are marked" : "";
    const note = make("p", { class: "note" }, `${which}${columns}, in the order of the data${some}.`);
    const scroll = make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Samples of this leaf" },
      make("table", {}, make("thead", {}, head), make("tbody", {}, ...body)));
    const box = make("div");
    box.append(note, scroll);
    return box;
  }

  function splitTable(node) {
    const [yes, no] = sides(node);
    const row = (name, counts) => make("tr", {}, make("th", { scope: "row" }, name), make("td", { class: "n" }, grouped(counts)));
    const head = ["", "yes", "no"].map((name, k) => make("th", { scope: "col", class: k ? "n" : false }, name));
    const line = (name, a, b) => {
      const out = row(name, a);
      out.append(make("td", { class: "n" }, grouped(b)));
      return out;
    };
    const [left, right] = [nodes[yes].counts, nodes[no].counts];
    const lines = classes.map((name, k) => [name, left[k], right[k]]).filter(([, a, b]) => a + b > 0).slice(0, 30);
    return make("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Samples of each side" },
      make("table", {}, make("thead", {}, make("tr", {}, ...head)),
        make("tbody", {}, line("all samples", sum(left), sum(right)), ...lines.map((entry) => line(...entry)))));
  }

  function otherColumns(node) {
    if (!node.others.length) return [];
    const price = make("output", { for: "other" });
    const say = (event) => { price.textContent = event.target.value ? node.others[Number(event.target.value)][1] : ""; };
    const options = node.others.map(([name], k) => make("option", { value: String(k) }, name));
    const select = make("select", { id: "other", onchange: say }, make("option", { value: "" }, "as it is"), ...options);
    return [make("p", { class: "row" }, make("label", { for: "other" }, "Another column here:"), select, price)];
  }

  function choose(index) {
    const node = nodes[index], here = sum(node.counts);
    svg.querySelectorAll(".chosen").forEach((one) => one.classList.remove("chosen"));
    group(index).classList.add("chosen");
    const close = make("button", { type: "button", onclick: () => { detail.hidden = true; group(index).classList.remove("chosen"); group(index).focus(); } }, "Close");
    const share = `${counted(here, "sample")}, ${percent(here / Math.max(1, total))} of all`;
    if ("label" in node) {
      const missed = node.miss ? `${share}; ${node.miss}.` : `${share}.`;
      detail.replaceChildren(make("h3", {}, make("span", {}, `Leaf: ${data.label} is ${node.answer}`), close),
        make("p", {}, classes.length ? `${missed} Their true classes:` : missed),
        ...(classes.length ? [bars(node.counts)] : []), sampleTable(index));
    } else {
      detail.replaceChildren(make("h3", {}, make("span", {}, node.text), close),
        make("p", {}, `${share}, come to this split. Where they go:`), splitTable(node), ...otherColumns(node));
    }
    detail.hidden = false;
  }

  function move(from, key) {
    const node = nodes[from], up = parents.get(from);
    if (key === "ArrowUp") return up;
    if (key === "ArrowDown") return "left" in node ? sides(node)[0] : undefined;
    const step = key === "ArrowRight" ? 1 : -1;  // along the level
    const level = (index) => (parents.has(index) ? 1 + level(parents.get(index)) : 0);
    const below = (index) => [index, ...("left" in nodes[index] ? sides(nodes[index]).flatMap(below) : [])];
    const row = below(0).filter((index) => level(index) === level(from));
    return row[row.indexOf(from) + step];
  }

  svg.addEventListener("click", (event) => {
    const at = event.target.closest("[data-node]");
    if (at) choose(Number(at.dataset.node));
  });
  svg.addEventListener("keydown", (event) => {
    const at = event.target.closest("[data-node]");
    if (!at || event.ctrlKey || event.altKey || event.metaKey) return;
    const index = Number(at.dataset.node);
    if (event.key === "Enter" || event.key === " ") choose(index);
    else if (event.key.startsWith("Arrow")) {
      const next = move(index, event.key);
      if (next !== undefined) {
        at.setAttribute("tabindex", "-1");
        group(next).setAttribute("tabindex", "0");
        group(next).focus({ preventScroll: true });
        group(next).scrollIntoView({ block: "nearest", inline: "nearest" });
      }
    } else return;
    event.preventDefault();
  });

  // ---- one case

  const trail = document.getElementById("trail"), ask = document.getElementById("ask"), answer = document.getElementById("answer");
  const back = document.getElementById("back"), again = document.getElementById("again");
  let steps = [];  // {node, isLeft, values: {column: number, text or null}}, values only where some were given

  const said = () => Object.assign({}, ...steps.map((step) => step.values || {}));

  function featureOf(asked, value) {
    if (asked.kind === "is") return value === asked.value ? 1 : 0;
    if (asked.kind === "is-missing") return value === null ? 1 : 0;
    if (asked.kind === "among") return asked.members.includes(value) ? 1 : 0;
    if (value === null) return asked.kind === "missing-left" ? -Infinity : asked.kind === "missing-right" ? Infinity : NaN;
    const number = asked.isOrder ? asked.values.indexOf(value) : Number(value);
    if (asked.kind === "missing-left") return Math.max(number, asked.least);
    return asked.kind === "missing-right" ? Math.min(number, asked.most) : number;
  }

  function goesLeft(node, values) {
    let result = 0;
    for (const asked of node.asks) result += asked.coefficient * featureOf(asked, values[asked.key]);
    if (Number.isNaN(result)) return node.missing === "left";
    return node.cut === null ? node.missing === "right" : result <= node.cut;
  }

  // Answers of yes and no bound a feature from both sides, and may decide a later split that reads it.
  function implied(node) {
    if (node.asks.length > 1) return undefined;
    for (const step of steps) {
      const before = nodes[step.node];
      if (before.asks.length > 1 || before.asks[0].feature !== node.asks[0].feature) continue;
      if (before.cut === null || node.cut === null) continue;
      // What is missing may have come this way, too: it has to go on to the same side.
      const comesMissing = before.missing && step.isLeft === (before.missing === "left");
      const agrees = (isLeft) => !comesMissing || isLeft === (node.missing === "left");
      if (step.isLeft && before.cut <= node.cut && agrees(true)) return true;
      if (!step.isLeft && before.cut >= node.cut && agrees(false)) return false;
    }
    return undefined;
  }

  function walk() {
    const values = said(), way = [];
    let at = 0;
    const known = new Map(steps.map((step) => [step.node, step]));
    while (!("label" in nodes[at])) {
      const node = nodes[at], step = known.get(at);
      let isLeft = step ? step.isLeft : undefined;
      const source = step ? (step.values ? "value" : "said") : "implied";
      if (isLeft === undefined) {
        isLeft = node.asks.every((asked) => asked.key in values) ? goesLeft(node, values) : implied(node);
      }
      if (isLeft === undefined) return { at, way };
      way.push({ node: at, isLeft, source });
      at = isLeft ? node.left : node.right;
    }
    return { at, way };
  }

  function field(asked, id) {
    const label = make("label", { for: id }, asked.unit ? `${asked.column} [${asked.unit}]` : asked.column);
    if (asked.values && asked.values.length) {
      const options = asked.values.map((value, k) => make("option", { value: String(k) }, asked.shown[k]));
      if (asked.hasMissing) options.push(make("option", { value: "missing" }, "missing"));
      if (!asked.isOrder) options.push(make("option", { value: "other" }, "another value"));
      label.append(make("select", { id }, ...options));
      return label;
    }
    label.append(make("input", { id, type: "text", inputmode: asked.time ? "text" : "decimal", autocomplete: "off" }));
    return label;
  }

  const DAY = 864e11;  // nanoseconds, a whole number for float64

  function clock(hours, minutes, seconds, part) {
    return (Number(hours || 0) * 3600 + Number(minutes || 0) * 60 + Number(seconds || 0)) * 1e9 + Number((part || "").padEnd(9, "0"));
  }

  // The days since 1970 (UTC) of 2024-03-01, 2024-03-01 10:00:00.33 or 2024-03-01 10:00+01:00; NaN of another text.
  function dayOf(text, hasZone) {
    const found = /^(\d{4})-(\d\d)-(\d\d)(?:[ T](\d\d):(\d\d)(?::(\d\d)(?:\.(\d{1,9}))?)?)?\s*(?:(Z)|([-+])(\d\d):?(\d\d))?$/.exec(text);
    if (!found || (hasZone && !found[8] && !found[9])) return NaN;
    const ahead = found[9] ? Number(found[9] + "1") * clock(found[10], found[11]) : 0;
    const rest = clock(found[4], found[5], found[6], found[7]) - ahead;
    return Date.UTC(found[1], found[2] - 1, found[3]) / 864e5 + Math.floor(rest / DAY) + (rest - Math.floor(rest / DAY) * DAY) / DAY;
  }

  // The days of 3 days, 3 days 02:00:00, -00:05:12.3 or a number of days.
  function daysOf(text) {
    const found = /^(-?)(?:(\d+) days?)?\s*(?:(\d\d):(\d\d):(\d\d)(?:\.(\d{1,9}))?)?$/.exec(text);
    if (!found || text === "") return text === "" ? NaN : Number(text);
    return Number(found[1] + "1") * (Number(found[2] || 0) + clock(found[3], found[4], found[5], found[6]) / DAY);
  }

  function valueOf(asked, control) {
    const text = control.value.trim();
    if (asked.values && asked.values.length) {
      return text === "missing" ? null : text === "other" ? undefined : asked.values[Number(text)];
    }
    if (asked.hasMissing && (text === "" || text.toLowerCase() === "missing")) return null;
    if (asked.time) return asked.time === "date" ? dayOf(text, asked.hasZone) : daysOf(text);
    const number = Number(text.replace(/,(?=\d{3}(\D|$))/g, "").replace("\u2212", "-"));
    return text === "" || !Number.isFinite(number) ? NaN : number;
  }

  function takeStep(step) {
    steps.push(step);
    draw(true);
  }

  function drawQuestion(at) {
    const node = nodes[at], values = said();
    const columns = new Map(node.asks.map((asked) => [asked.key, asked]));
    const open = [...columns.values()].filter((asked) => !(asked.key in values));
    const complaint = make("p", { class: "problem", role: "alert", hidden: true });
    const fields = open.map((asked, k) => field(asked, `case-${at}-${k}`));
    const submit = (event) => {
      event.preventDefault();
      const found = {};
      for (const [k, asked] of open.entries()) {
        const value = valueOf(asked, document.getElementById(`case-${at}-${k}`));
        if (Number.isNaN(value)) {
          const wanted = asked.time ? `a ${asked.time} such as ${asked.example}` : "a number";
          complaint.textContent = `Give ${wanted} for ${asked.column}${asked.hasMissing ? ", or leave it empty if it is missing" : ""}.`;
          complaint.hidden = false;
          document.getElementById(`case-${at}-${k}`).focus();
          return;
        }
        found[asked.key] = value;
      }
      takeStep({ node: at, values: found, isLeft: goesLeft(node, { ...values, ...found }) });
    };
    const form = make("form", { onsubmit: submit, novalidate: true }, ...fields, make("button", { class: "main" }, "Next"), complaint);
    const side = (word, isYes) => make("button", { type: "button",
      onclick: () => takeStep({ node: at, isLeft: isYes === node.yesIsLeft }) }, word);
    const gap = open.some((asked) => asked.hasMissing && !(asked.values && asked.values.length));
    ask.replaceChildren(make("p", { class: "question" }, `${node.text}`), form,
      make("div", { class: "row" }, side("Yes", true), side("No", false)));
    if (gap) form.append(make("p", { class: "note" }, "Leave the field empty if the value is missing."));
  }

  function drawAnswer(leaf) {
    const node = nodes[leaf], here = sum(node.counts);
    const came = classes.length ? `Of ${counted(here, "training sample")} that came this way, the true classes were:`
      : `${counted(here, "training sample")} came this way${node.miss ? `; ${node.miss}` : ""}.`;
    answer.replaceChildren(make("p", { class: "result" }, `Answer: ${data.label} is ${node.answer}`),
      make("p", { class: "note" }, here ? came : "No training sample came this way."),
      ...(classes.length ? [bars(node.counts)] : []));
    answer.append(make("button", { type: "button", onclick: () => { choose(leaf); detail.scrollIntoView({ block: "center" }); } }, "Show its samples"));
  }

  function draw(takesFocus) {
    const { at, way } = walk(), isEnd = "label" in nodes[at];
    trail.replaceChildren(...way.map(({ node, isLeft, source }) => make("li", {}, `${nodes[node].text} `,
      make("b", {}, isLeft === nodes[node].yesIsLeft ? "yes" : "no"), source === "implied" ? " (follows from what was said)" : "")));
    svg.querySelectorAll(".lit").forEach((one) => one.classList.remove("lit"));
    svg.classList.toggle("has-way", steps.length > 0);
    if (steps.length) {
      group(0).classList.add("lit");
      for (const { node, isLeft } of way) {
        const next = isLeft ? nodes[node].left : nodes[node].right;
        group(next).classList.add("lit");
        edge(next).classList.add("lit");
      }
    }
    answer.hidden = !isEnd;
    ask.hidden = isEnd;
    if (isEnd) drawAnswer(at);
    else drawQuestion(at);
    back.disabled = again.disabled = steps.length === 0;
    if (takesFocus) (isEnd ? again.disabled ? svg : again : ask.querySelector("input, select, button")).focus();
  }

  back.addEventListener("click", () => { steps.pop(); draw(true); });
  again.addEventListener("click", () => { steps = []; draw(true); });
  draw(false);
})();
