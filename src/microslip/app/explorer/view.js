"use strict";
// Boxes and sliders, the address, the four pictures. Nothing is fetched and nothing is kept.

const PREFIXES = [["G", 1e9], ["M", 1e6], ["k", 1e3], ["", 1], ["m", 1e-3], ["µ", 1e-6], ["n", 1e-9], ["p", 1e-12]];
const $ = (id) => document.getElementById(id);

function engineering(value, unit, digits = 3) {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return `0 ${unit}`;
  const [letter, factor] = PREFIXES.find(([, f]) => Math.abs(value) >= 0.99995 * f) || PREFIXES.at(-1);
  return `${plain(value / factor, digits)} ${letter}${unit}`;
}
const plain = (x, digits = 3) =>
  Math.abs(x) >= 10 ** digits ? x.toFixed(0) : Number(x.toPrecision(digits)).toString().replace("-", "−");

// FIELDS: key, label, symbol, unit on the page, its size in SI, least and most [SI], default [SI].
const state = {};

function read() {
  const given = new URLSearchParams(location.hash.slice(1));
  for (const f of FIELDS) {
    const value = Number(given.get(f.key));
    state[f.key] = given.has(f.key) && Number.isFinite(value) && f.valid[0] <= value && value <= f.valid[1] ? value : f.start;
  }
  state.kind = given.get("kind") in HEIGHTS ? given.get("kind") : "gaussian";
  for (const n of [1, 2]) {
    const metal = METALS[given.get(`m${n}`)] ? given.get(`m${n}`) : given.has(`e${n}`) ? "" : "al2017";
    state[`m${n}`] = metal;
    if (metal) useMetal(n, metal);
  }
}

function useMetal(n, name) {
  const metal = METALS[name];
  state[`e${n}`] = metal.e;
  state[`nu${n}`] = metal.nu;
  state[`hardness${n}`] = metal.hardness;
}

function address() {
  const out = new URLSearchParams();
  for (const f of FIELDS) {
    const own = /^(e|nu)[12]$/.test(f.key) && state[`m${f.key.at(-1)}`];
    if (!own) out.set(f.key, String(state[f.key]));
  }
  out.set("kind", state.kind);
  for (const n of [1, 2]) if (state[`m${n}`]) out.set(`m${n}`, state[`m${n}`]);
  return "#" + out;
}

function build() {
  for (const f of FIELDS) {
    const row = document.createElement("label");
    row.className = "row";
    row.innerHTML = `<span>${f.label}</span><input type="range" id="${f.key}-slide" step="any" aria-label="${f.label}, slider">` +
      `<input type="number" id="${f.key}" step="any"><span class="unit">${f.unit}</span>`;
    $(f.group).append(row);
    const slide = $(`${f.key}-slide`), box = $(f.key);
    const to = f.log ? Math.log : (x) => x, from = f.log ? Math.exp : (x) => x;
    [slide.min, slide.max] = [to(f.range[0]), to(f.range[1])];
    slide.addEventListener("input", () => set(f, Number(from(Number(slide.value)).toPrecision(3))));
    box.addEventListener("input", () => {
      const value = box.value.trim() === "" ? NaN : Number(box.value) * f.scale;
      const good = Number.isFinite(value) && value >= f.valid[0] && value <= f.valid[1];
      box.setCustomValidity(good ? "" : `from ${f.valid[0] / f.scale} to ${f.valid[1] / f.scale} ${f.unit}`);
      box.reportValidity();
      if (good) set(f, value, true);
    });
    f.show = (typing) => {
      slide.value = to(Math.min(Math.max(state[f.key], f.range[0]), f.range[1]));
      if (!typing) box.value = Number((state[f.key] / f.scale).toPrecision(6));
    };
  }
  for (const n of [1, 2]) {
    const select = $(`m${n}`);
    select.append(new Option("own values", ""));
    for (const [name, metal] of Object.entries(METALS)) select.append(new Option(`${name}: ${metal.description}`, name));
    select.addEventListener("change", () => {
      state[`m${n}`] = select.value;
      state[`hardness${n}`] = undefined;
      if (select.value) useMetal(n, select.value);
      redraw();
    });
  }
  $("kind").addEventListener("change", () => { state.kind = $("kind").value; redraw(); });
  $("save").addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([studyText(state)], { type: "text/plain" }));
    link.download = "study.toml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  $("reset").addEventListener("click", () => { history.replaceState(null, "", "#"); read(); redraw(); });
  window.addEventListener("hashchange", () => { if (location.hash !== address()) { read(); redraw(); } });
}

function set(f, value, typing) {
  state[f.key] = value;
  const own = f.key.match(/^(e|nu)([12])$/);
  if (own) { state[`m${own[2]}`] = ""; state[`hardness${own[2]}`] = undefined; }
  redraw(typing ? f : undefined);
}

let waiting = false, typed;
function redraw(f) {
  typed = f;
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; show(); });
}

function show() {
  for (const f of FIELDS) f.show(f === typed);
  for (const n of [1, 2]) $(`m${n}`).value = state[`m${n}`];
  $("kind").value = state.kind;
  try { history.replaceState(null, "", address()); } catch { /* some browsers keep files from it */ }
  let joint;
  try {
    joint = makeJoint(state);
    if (!(joint.kt > 0 && Number.isFinite(joint.kt))) throw new RangeError("no such joint");
  } catch (error) {
    $("answer").textContent = `No joint: ${error.message}.`;
    document.body.classList.add("none");
    return;
  }
  document.body.classList.remove("none");
  tell(joint);
  draw(joint);
}

function tell(joint) {
  const a = state.amplitude, force = joint.backbone(a), eta = joint.lossFactor(a);
  $("answer").innerHTML =
    `Cycled between ±${engineering(a, "m")}, this joint dissipates <b>${engineering(joint.energy(a), "J")}</b> a cycle: ` +
    `loss factor <b>η = ${plain(eta)}</b>, damping ratio of the interface ζ = η/2 = ${plain(eta / 2)}; ` +
    `the force reaches ${plain(100 * force / joint.limit)} % of the friction limit.`;
  const facts = [
    ["Contacts", plain(joint.count, 4)],
    ["Real area", `${plain(100 * joint.area / state.area)} %`],
    ["Stiffness at rest kₜ", engineering(joint.kt, "N/m")],
    ["Secant stiffness", engineering(force / a, "N/m")],
    ["Force limit μN", engineering(joint.limit, "N")],
    ["Slip scale κσ", engineering(joint.scale, "m")],
    ["Separation h = d/σ", plain(joint.h)],
  ];
  $("facts").innerHTML = facts.map(([k, v]) => `<div><dt>${k}</dt><dd>${v}</dd></div>`).join("");
  const doubts = verdicts(joint.judged).filter((v) => v.word !== "ok");
  $("verdict").innerHTML = doubts.length
    ? doubts.map((v) => `<p class="${v.word}"><b>${v.word}:</b> ${v.name} ${plain(v.value)}; assumed: ${v.rule.meaning}</p>`).join("")
    : `<p class="ok"><b>ok:</b> what was judged of the model’s assumptions holds</p>`;
}

// -- pictures ------------------------------------------------------------------------------------

const W = 460, H = 300, LEFT = 64, RIGHT = 12, TOP = 24, BOTTOM = 44;

function draw(joint) {
  const a = state.amplitude, { x, y } = joint.loop(a, 400), peak = joint.backbone(a);
  const xs = prefixFor(a, "m"), ys = prefixFor(peak, "N");
  plot("loop", "Hysteresis loop", `Displacement [${xs.name}]`, `Force [${ys.name}]`,
    [{ x: x.map((v) => v / xs.factor), y: y.map((v) => v / ys.factor) }],
    { x: [-1.08 * a / xs.factor, 1.08 * a / xs.factor], y: [-1.12 * peak / ys.factor, 1.12 * peak / ys.factor], cross: true });
  const low = Math.min(1e-3 * joint.scale, a / 3), high = Math.max(300 * joint.scale, 3 * a);
  const grid = Array.from({ length: 121 }, (_, i) => low * (high / low) ** (i / 120));
  const along = grid.map((u) => u / 1e-6), here = a / 1e-6;
  const log = (title, label, f, extra = {}) => plot(title[0], title[1], "Displacement amplitude [µm]", label,
    [{ x: along, y: grid.map(f) }, ...(extra.lines || [])], { log: true, x: [low / 1e-6, high / 1e-6], mark: [here, f(a)], ...extra });
  const unit = prefixFor(joint.limit, "N");
  log(["backbone", "First loading (backbone)"], `Force [${unit.name}]`, (u) => joint.backbone(u) / unit.factor, {
    lines: [{ x: along, y: grid.map((u) => Math.min(joint.kt * u, 4 * joint.limit) / unit.factor), dash: true, cut: 3.9 * joint.limit / unit.factor },
      { x: [along[0], along.at(-1)], y: [joint.limit / unit.factor, joint.limit / unit.factor], dash: true }] });
  log(["energy", "Energy lost in a cycle"], "Energy [J]", joint.energy);
  log(["damping", "Loss factor η; damping ratio ζ = η/2"], "Loss factor η", joint.lossFactor,
    { lines: [{ x: [along[0], along.at(-1)], y: [4 / Math.PI, 4 / Math.PI], dash: true }] });
}

function prefixFor(value, unit) {
  const [letter, factor] = PREFIXES.find(([, f]) => value >= f) || PREFIXES.at(-1);
  return { name: letter + unit, factor };
}

function plot(id, title, xLabel, yLabel, lines, look) {
  const values = lines[0].y.filter((v) => v > 0 || !look.log);
  let [y0, y1] = look.y || [Math.min(...values), Math.max(...values)];
  if (look.log) [y0, y1] = [y0 / 2, Math.max(y1, ...(lines.slice(1).flatMap((l) => l.cut ? [] : l.y))) * 2.5];
  const [x0, x1] = look.x, to = look.log ? Math.log : (v) => v;
  const px = (v) => LEFT + (W - LEFT - RIGHT) * (to(v) - to(x0)) / (to(x1) - to(x0));
  const py = (v) => H - BOTTOM - (H - TOP - BOTTOM) * (to(v) - to(y0)) / (to(y1) - to(y0));
  const parts = [`<text x="${LEFT}" y="15" class="head">${title}</text>`];
  for (const [v, text] of ticks(x0, x1, look.log)) parts.push(`<path class="grid" d="M${px(v).toFixed(1)} ${TOP}V${H - BOTTOM}"/><text x="${px(v).toFixed(1)}" y="${H - BOTTOM + 15}" text-anchor="middle">${text}</text>`);
  for (const [v, text] of ticks(y0, y1, look.log)) parts.push(`<path class="grid" d="M${LEFT} ${py(v).toFixed(1)}H${W - RIGHT}"/><text x="${LEFT - 6}" y="${(py(v) + 4).toFixed(1)}" text-anchor="end">${text}</text>`);
  if (look.cross) parts.push(`<path class="cross" d="M${LEFT} ${py(0)}H${W - RIGHT}M${px(0)} ${TOP}V${H - BOTTOM}"/>`);
  for (const line of [...lines].reverse()) {
    let d = "", pen = "M";
    line.x.forEach((v, i) => {
      const w = line.y[i];
      if (!(w > 0 || !look.log) || w > 1.001 * y1 || (line.cut && w > line.cut)) { pen = "M"; return; }
      d += `${pen}${px(v).toFixed(1)} ${py(w).toFixed(1)}`;
      pen = "L";
    });
    parts.push(`<path class="${line.dash ? "dash" : "line"}" d="${d}"/>`);
  }
  if (look.mark) parts.push(`<circle cx="${px(look.mark[0]).toFixed(1)}" cy="${py(look.mark[1]).toFixed(1)}" r="4.5"/>`);
  parts.push(`<rect x="${LEFT}" y="${TOP}" width="${W - LEFT - RIGHT}" height="${H - TOP - BOTTOM}"/>`,
    `<text x="${(W + LEFT - RIGHT) / 2}" y="${H - 8}" text-anchor="middle">${xLabel}</text>`,
    `<text transform="translate(14 ${(H + TOP - BOTTOM) / 2}) rotate(-90)" text-anchor="middle">${yLabel}</text>`);
  $(id).innerHTML = parts.join("");
}

build();
read();
show();
