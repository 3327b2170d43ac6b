"use strict";
// The page of the workbench. What files hold is only ever shown as text.

const $ = (id) => document.getElementById(id);
const shown = new Set(JSON.parse(sessionStorage.getItem("shown") || "[]"));
let picked = null; // the file that is being looked at: {uploads, what, options, preview, columns}

function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== false && value !== undefined) element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

async function ask(path, method = "GET", body) {
  const sent = body instanceof Blob ? body : body === undefined ? (method === "GET" ? undefined : "") : JSON.stringify(body);
  const answer = await fetch(path, { method, body: sent, headers: { "content-type": "application/octet-stream" } });
  const found = await answer.json().catch(() => ({ error: `the workbench answers ${answer.status}` }));
  if (!answer.ok) throw Object.assign(new Error(found.error || `the workbench answers ${answer.status}`), { columns: found.columns });
  return found;
}

async function safely(work) {
  $("error").textContent = "";
  try { return await work(); } catch (error) { $("error").textContent = error.message; return undefined; }
}

// -- files ---------------------------------------------------------------------------------------

const WHAT = { scan: "surface", record: "measure", study: "predict" };

// What a file may be, the likelier first: the first one that can be looked into is taken.
function guesses(name) {
  if (/\.toml$/i.test(name)) return ["study"];
  return /\.(csv|tsv|tdms|h5|hdf5|txt|dat|nc)$/i.test(name) ? ["record", "scan"] : ["scan", "record"];
}

// A file is a manifest by its name, or if it is CSV and its column of files names another file.
async function isManifest(file, files) {
  if (/manifest.*\.(csv|xlsx|xlsm)$/i.test(file.name)) return true;
  if (!/\.csv$/i.test(file.name)) return false;
  const names = /(^|[,;\t])"?(file|file ?name|datei|dateiname|fichier)"?([,;\t\r\n]|$)/im, text = await file.slice(0, 4096).text();
  return names.test(text) && [...files].some((other) => other !== file && text.includes(other.name));
}

async function take(files) {
  await safely(async () => {
    const uploads = [], options = {};
    let manifest = -1;
    for (const file of files) {
      if (manifest < 0 && await isManifest(file, files)) manifest = uploads.length;
      uploads.push(await ask(`/api/uploads?name=${encodeURIComponent(file.name)}`, "POST", file));
    }
    if (!uploads.length) return;
    if (manifest >= 0 && uploads.length > 1) {
      const [list] = uploads.splice(manifest, 1);
      Object.assign(options, { manifest: list.id, "manifest files": list.name });
    }
    const kinds = guesses(uploads[0].name);
    for (const kind of kinds) if (await look(uploads, kind, { ...options })) return;
    if (kinds.length > 1) await look(uploads, kinds[0], { ...options });
  });
}

async function look(uploads, what, options) {
  const before = picked && picked.uploads === uploads && picked.what === what ? picked : {};
  const mine = { uploads, what, options, preview: before.preview, columns: before.columns }; // what is refused leaves them there
  picked = mine;
  sessionStorage.setItem("picked", JSON.stringify({ uploads, what, options }));
  drawForm();
  const found = await safely(async () => {
    try { return await ask(`/api/uploads/${uploads[0].id}/look`, "POST", { what, options: given(what, options) }); } catch (error) {
      if (error.columns?.length) mine.columns = error.columns;
      throw error;
    }
  });
  if (found) Object.assign(mine, { preview: found, columns: found.columns });
  if (picked === mine) drawForm(); // else another file was chosen meanwhile
  return found !== undefined;
}

// The forms are those of the commands: what an option is called, takes and means, they say.
let forms = {};
const commandOf = (what, options) => (what === "record" ? options.command || "measure" : WHAT[what]);
const fieldsOf = (what, options) => forms[commandOf(what, options)] || [];

// What was chosen, as the command takes it: lists where an option may be repeated.
function given(what, options) {
  const values = {};
  for (const field of fieldsOf(what, options)) {
    const value = options[field.name];
    if (value === undefined || value === "" || value === false || value.length === 0) continue;
    const list = (field.several || field.values > 1) && typeof value === "string";
    values[field.name] = list ? value.split(/\s*;\s*/).filter(Boolean) : value;
  }
  return values;
}

function inputOf(field, options) {
  const { name, kind, choices } = field, value = options[name];
  if (kind === "flag") return make("input", { type: "checkbox", name, checked: Boolean(value) });
  if (kind === "choice" && !field.several) {
    const input = make("select", { name }, make("option", { value: "" }, field.placeholder ? `${field.placeholder} (usual)` : ""));
    for (const word of choices) input.append(make("option", { value: word, selected: word === value }, word));
    return input;
  }
  const columns = kind === "column" && picked.columns || [];
  if (columns.length && name !== "normal-load") {
    const input = make("select", { name }, make("option", { value: "" }, "found by its name"));
    for (const word of [...columns, ...choices]) input.append(make("option", { value: word, selected: word === value }, word));
    return input;
  }
  if (kind === "file" || kind === "study") {
    const input = make("input", { type: "file", name, multiple: field.several, title: value ? "A file is chosen" : "" });
    input.addEventListener("change", (event) => {
      event.stopImmediatePropagation();
      safely(async () => {
        const sent = [];
        for (const file of input.files) sent.push((await ask(`/api/uploads?name=${encodeURIComponent(file.name)}`, "POST", file)).id);
        options[name] = field.several ? sent : sent[0];
        options[`${name} files`] = [...input.files].map((file) => file.name).join(", ");
      });
    });
    return make("span", {}, input, make("span", { class: "small" }, options[`${name} files`] || ""));
  }
  const hint = [field.placeholder, field.several || field.values > 1 ? "several: ;" : "", choices.join(", ")].filter(Boolean).join("; ");
  const input = make("input", { name, placeholder: hint, value: value || "", autocomplete: "off", list: columns.length ? "columns" : undefined });
  if (!columns.length) return input;
  return make("span", {}, input, make("datalist", { id: "columns" }, ...columns.map((word) => make("option", { value: word }))));
}

function drawForm() {
  const form = $("new");
  const open = Boolean(form.querySelector(".more")?.open);
  form.hidden = !picked;
  form.replaceChildren();
  if (!picked) return;
  const { uploads, what, preview, options } = picked;
  form.append(make("h2", {}, uploads.map((u) => u.name).join(", ")));
  if (uploads.length > 1) form.append(make("p", { class: "small" }, `Shown: ${uploads[0].name}. All ${uploads.length} are run together.`));
  const kind = make("select", { "aria-label": "Kind of file", id: "what", onchange: () => look(uploads, kind.value, {}) });
  for (const [name, text] of [["scan", "Scan of a surface"], ["record", "Record of a tribometer"], ["study", "Study"]]) {
    kind.append(make("option", { value: name, selected: name === what }, text));
  }
  form.append(make("label", { class: "field" }, "Kind", kind));
  if (preview?.what === "scan") drawScan(form, preview);
  if (preview?.what === "record") drawRecord(form, preview);
  if (preview?.what === "study") drawStudy(form, preview);
  if (what === "record") {
    const input = make("select", { name: "command" });
    for (const value of ["measure", "identify"]) input.append(make("option", { value, selected: options.command === value }, value));
    input.addEventListener("change", () => { options.command = input.value; keep(); drawForm(); });
    form.append(make("label", { class: "field" }, "Command", input));
  }
  const keep = () => sessionStorage.setItem("picked", JSON.stringify({ uploads, what, options }));
  const fields = fieldsOf(what, options), more = make("details", { class: "more", open }, make("summary", {}, "More options"));
  for (const field of fields) {
    const box = inputOf(field, options), input = box.querySelector("input") || box;
    input.addEventListener("change", () => {
      options[field.name] = input.type === "checkbox" ? input.checked : input.value.trim();
      keep();
      if (field.looks) look(uploads, what, options);
    });
    (field.usual ? form : more).append(make("label", { class: "field", title: field.help }, field.label, box));
  }
  if (fields.some((field) => !field.usual)) form.append(more);
  form.append(make("p", { class: "row" },
    make("button", { type: "submit", class: "main", id: "run", disabled: what === "study" && !preview }, `Run ${commandOf(what, options)}`),
    make("button", { type: "button", onclick: () => { picked = null; sessionStorage.removeItem("picked"); drawForm(); } }, "Close")));
}

$("new").addEventListener("submit", (event) => {
  event.preventDefault();
  safely(async () => {
    const { what, options } = picked;
    let { uploads } = picked;
    const command = commandOf(what, options), asked = given(what, options);
    if (what === "scan" && !asked.cutoff) asked.cutoff = "none";
    if (what === "study") {
      const text = $("study-text").value;
      uploads = [await ask(`/api/uploads?name=${encodeURIComponent(uploads[0].name)}`, "POST", new Blob([text]))];
    }
    const run = await ask("/api/runs", "POST", { kind: command, uploads: uploads.map((u) => u.id), options: asked });
    shown.clear();
    show(run.id, true);
    await follow();
  });
});

// -- previews of files ---------------------------------------------------------------------------

// Returns a canvas with the line y over x, in SI units; with log, both axes are logarithmic. The
// axes have labels along and up, each a [name, unit], to which a prefix is added.
function chart([x, y], { log = false, height = 150, marks = [], label, along, up }) {
  const W = 880, H = 2 * height, left = 120, right = W - 14, top = 10, bottom = H - 62;
  const canvas = make("canvas", { width: W, height: H, role: "img", "aria-label": label });
  const to = log ? Math.log10 : (v) => v, pen = canvas.getContext("2d");
  const reach = (values) => values.filter((v) => !log || v > 0)
    .reduce(([a, b], n) => [Math.min(a, n), Math.max(b, n)], [Infinity, -Infinity]);
  const [x0, x1] = reach(x), [y0, y1] = reach(y);
  const px = (v) => left + (right - left) * (to(v) - to(x0)) / (to(x1) - to(x0) || 1);
  const py = (v) => bottom - (bottom - top) * (to(v) - to(y0)) / (to(y1) - to(y0) || 1);
  const axis = ([name, unit], low, high, vertical) => {
    const [letter, factor] = unit === "" || log && vertical ? ["", 1] : prefix(Math.max(Math.abs(low), Math.abs(high)));
    pen.fillStyle = "#444";
    for (const [v, text] of low < high ? ticks(low / factor, high / factor, log, vertical ? 4 : 7) : []) {
      pen.textAlign = vertical ? "right" : "center";
      pen.fillText(text, vertical ? left - 8 : px(v * factor), vertical ? py(v * factor) + 7 : bottom + 24);
      pen.strokeStyle = "#e6e6e6";
      pen.beginPath();
      if (vertical) { pen.moveTo(left, py(v * factor)); pen.lineTo(right, py(v * factor)); } else { pen.moveTo(px(v * factor), top); pen.lineTo(px(v * factor), bottom); }
      pen.stroke();
    }
    const words = unit === "" ? name : `${name} [${letter.replace("u", "µ")}${unit}]`;
    pen.textAlign = "center";
    pen.save();
    if (vertical) { pen.translate(22, (top + bottom) / 2); pen.rotate(-Math.PI / 2); pen.fillText(words, 0, 0); } else pen.fillText(words, (left + right) / 2, H - 10);
    pen.restore();
  };
  pen.font = "21px system-ui, 'DejaVu Sans', sans-serif";
  axis(along, x0, x1, false);
  axis(up, y0, y1, true);
  pen.strokeStyle = "#999";
  pen.strokeRect(left, top, right - left, bottom - top);
  for (const mark of marks) { pen.beginPath(); pen.moveTo(px(mark), top); pen.lineTo(px(mark), bottom); pen.stroke(); }
  pen.strokeStyle = "#0072B2";
  pen.lineWidth = 2;
  pen.beginPath();
  x.forEach((v, i) => { if (!log || v > 0 && y[i] > 0) pen.lineTo(px(v), py(y[i])); });
  pen.stroke();
  return canvas;
}

const PREFIXES = [["G", 1e9], ["M", 1e6], ["k", 1e3], ["", 1], ["m", 1e-3], ["u", 1e-6], ["n", 1e-9], ["p", 1e-12]];
const prefix = (v) => PREFIXES.find(([, f]) => Math.abs(v) >= f) || PREFIXES.at(-1);
function length(v) {
  const [letter, factor] = prefix(v);
  return `${Number((v / factor).toPrecision(3))} ${letter}m`;
}

function drawScan(form, preview) {
  const [rows, columns] = [preview.shape[0], preview.shape[1] || 1];
  form.append(make("p", { class: "small" }, `${preview.shape.toReversed().join(" × ")} points, pixel ${preview.pixel.map(length).join(" × ")}` +
    (preview.rms ? `, rms height ${length(preview.rms)} after levelling` : "") + (preview.missing ? `, ${(100 * preview.missing).toPrecision(2)} % missing` : "")));
  if (preview.picture) {
    const canvas = make("canvas", { width: 880, height: Math.round(Math.min(Math.max(880 * rows / columns, 120), 1200)), role: "img", "aria-label": "Map of the heights" });
    const pen = canvas.getContext("2d"), image = new Image();
    image.onload = () => pen.drawImage(image, 0, 0, canvas.width, canvas.height);
    image.src = preview.picture;
    form.append(make("figure", {}, canvas, make("figcaption", {}, `Levelled (${preview.level}).`)));
  }
  form.append(make("figure", {}, chart(preview.spectrum, { log: true, label: "Power spectrum over wavelength", along: ["Wavelength", "m"], up: ["Density", preview.picture ? "m⁴" : "m³"] }),
    make("figcaption", {}, "Power spectrum over wavelength.")));
}

function drawRecord(form, preview) {
  const unit = preview.has_time ? "s" : "samples", along = preview.has_time ? ["Time", "s"] : ["Samples", ""];
  form.append(make("p", { class: "small" }, `${preview.samples} samples, ${preview.cycles.length} cycles found`));
  if (preview.no_cycles) form.append(make("p", { class: "error small" }, preview.no_cycles));
  form.append(make("figure", {}, chart(preview.displacement, { marks: preview.cycles, height: 100, along, up: ["x", "m"], label: "Displacement against time" }),
    chart(preview.force, { marks: preview.cycles, height: 100, along, up: ["T", "N"], label: "Force against time" }),
    make("figcaption", {}, `Displacement and force against time [${unit}], grey: where cycles begin.`),
    chart(preview.path, { height: 150, along: ["Displacement", "m"], up: ["Force", "N"], label: "Force over displacement" }), make("figcaption", {}, "Force over displacement")));
  if (preview.notes.length) form.append(make("details", {}, make("summary", { class: "small" }, "Reading of the file"), ...preview.notes.map((n) => make("p", { class: "small" }, n))));
}

function drawStudy(form, preview) {
  const text = make("textarea", { id: "study-text", spellcheck: "false", "aria-label": "The study" });
  text.value = preview.text;
  form.append(text);
}

// -- runs ----------------------------------------------------------------------------------------

let timer = null;
async function follow() {
  clearTimeout(timer);
  const runs = await ask("/api/runs").catch(() => null);
  if (runs === null) { $("error").textContent = "The workbench has been stopped: start microslip app again."; return; }
  drawRuns(runs.toReversed());
  const busy = runs.some((run) => ["waiting", "running"].includes(run.state));
  timer = setTimeout(follow, busy ? 400 : 4000);
}

function drawRuns(runs) {
  $("none").hidden = runs.length > 0;
  $("runs").replaceChildren(...runs.map((run) => {
    const busy = ["waiting", "running"].includes(run.state);
    const tick = make("input", { type: "checkbox", "aria-label": "Show", checked: shown.has(run.id), onchange: () => show(run.id, tick.checked) });
    tick.checked = shown.has(run.id);
    return make("li", { class: `${run.state} ${shown.has(run.id) ? "shown" : ""}`, "data-id": run.id },
      make("div", { class: "row" }, tick, make("strong", {}, run.kind), make("span", { class: "state" }, run.state),
        busy ? make("button", { type: "button", onclick: () => safely(async () => { await ask(`/api/runs/${run.id}`, "POST"); follow(); }) }, "Cancel")
          : make("button", { type: "button", onclick: () => safely(async () => { await ask(`/api/runs/${run.id}`, "DELETE"); show(run.id, false); follow(); }) }, "Remove"),
        run.state === "done" ? make("a", { href: `/runs/${run.id}/download.zip` }, "Download") : null,
        make("code", {}, run.command)),
      run.state === "running" ? make("progress", { max: 1, ...(run.progress > 0 ? { value: run.progress } : {}) }) : null,
      run.state === "failed" ? make("p", { class: "small" }, run.message) : null);
  }));
  drawShown(runs);
}

function show(id, on) {
  if (on) shown.add(id); else shown.delete(id);
  sessionStorage.setItem("shown", JSON.stringify([...shown]));
  follow();
}

const drawn = new Map();
function drawShown(runs) {
  const right = $("right"), wanted = runs.filter((run) => shown.has(run.id));
  for (const [id, article] of drawn) if (!wanted.some((run) => run.id === id && article.dataset.state === run.state)) { article.remove(); drawn.delete(id); }
  for (const run of wanted) {
    if (drawn.has(run.id)) continue;
    const article = make("article", { "data-state": run.state, "data-id": run.id }, make("h2", {}, `${run.kind}: ${run.command.split(" ").at(-1)}`));
    if (run.state === "done") {
      if (run.files.includes("report.html")) article.append(make("iframe", { src: `/runs/${run.id}/files/report.html`, sandbox: "allow-scripts", title: "Report" }));
      article.append(make("p", { class: "row small" }, "Files: ", ...run.files.map((name) => make("a", { href: `/runs/${run.id}/files/${encodeURIComponent(name)}`, target: "_blank" }, name))));
    } else article.append(make("p", {}, run.message || run.state));
    if (run.printed) article.append(make("details", {}, make("summary", {}, "Output of the command"), make("pre", {}, run.printed)));
    drawn.set(run.id, article);
    right.append(article);
  }
  right.querySelector("p.small:not(.row)")?.toggleAttribute("hidden", wanted.length > 0);
}

// -- begin ---------------------------------------------------------------------------------------

$("file").addEventListener("change", () => { take([...$("file").files]); $("file").value = ""; });
$("example").addEventListener("click", () => safely(async () => look([await ask("/api/example", "POST")], "study", {})));
for (const event of ["dragover", "dragleave", "drop"]) {
  $("drop").addEventListener(event, (e) => {
    e.preventDefault();
    $("drop").classList.toggle("over", event === "dragover");
    if (event === "drop") take([...e.dataTransfer.files]);
  });
}
const kept = JSON.parse(sessionStorage.getItem("picked") || "null");
safely(async () => {
  forms = await ask("/api/forms");
  if (kept) look(kept.uploads, kept.what, kept.options);
});
follow();
