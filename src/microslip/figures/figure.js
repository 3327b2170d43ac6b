"use strict";
// Figures that answer: values under the pointer, a part drawn larger, curves shown alone. The data
// are those of the drawing itself; without this script, and in print, it stays as it is.

const SPACE = "http://www.w3.org/2000/svg";
let woken = 0;

for (const image of document.querySelectorAll("figure > img")) {
  const wake = () => awake(image);
  for (const event of ["pointerenter", "pointerdown"]) image.addEventListener(event, wake, { once: true });
}

function make(name, attributes, text = "") {
  const element = document.createElementNS(SPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.textContent = text;
  return element;
}

function awake(image) {
  if (!image.isConnected) return;
  const bytes = Uint8Array.from(atob(image.src.split(",")[1]), (c) => c.charCodeAt(0));
  const read = new DOMParser().parseFromString(new TextDecoder().decode(bytes), "image/svg+xml");
  const svg = document.importNode(read.documentElement, true), number = ++woken;
  for (const name of ["width", "height"]) svg.removeAttribute(name);
  for (const clip of svg.querySelectorAll("clipPath")) clip.id = `f${number}-${clip.id}`;
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", image.alt);
  const said = document.createElement("output");
  said.textContent = "Point at a curve for its values; draw a frame to enlarge, double-click to go back; click names to hide.";
  const panels = [...svg.querySelectorAll("g[data-box]")].map((g) => panelOf(g, number));
  for (const panel of panels) {
    const cover = make("rect", { ...panel.rect(), fill: "transparent", "data-cover": "" });
    svg.append(cover);
    listen(svg, cover, panel, panels, said);
  }
  for (const entry of svg.querySelectorAll("g[data-entry]")) {
    entry.style.cursor = "pointer";
    entry.addEventListener("click", () => {
      const off = entry.classList.toggle("off"), color = entry.dataset.entry;
      entry.style.opacity = off ? 0.35 : 1;
      for (const panel of panels) {
        for (const item of panel.items) if (item.color === color) item.element.style.display = off ? "none" : "";
      }
    });
  }
  image.replaceWith(svg, said);
}

function panelOf(g, number) {
  const numbers = (name) => g.dataset[name].split(" ").map(Number);
  const inside = g.querySelector("g[clip-path]"), [left, top, width, height] = numbers("box");
  inside.setAttribute("clip-path", inside.getAttribute("clip-path").replace("#", `#f${number}-`));
  const axis = ([low, high, log], begin, length) => {
    const to = log ? Math.log : (v) => v, from = log ? Math.exp : (v) => v;
    return {
      low, high, log,
      value: (at) => from(to(low) + (to(high) - to(low)) * (at - begin) / length),
      place: (v) => begin + length * (to(v) - to(low)) / (to(high) - to(low)),
    };
  };
  const names = g.dataset.names.split("\n");
  const items = [...inside.children].map((element) => ({
    element, before: element.cloneNode(true),
    color: element.getAttribute("stroke") || element.getAttribute("fill"),
    line: element.tagName === "path" && /^M[-\d. M]+$/.test(element.getAttribute("d")),
  }));
  return {
    g, items, left, top, width, height, names,
    x: axis(numbers("x"), left, width),
    y: axis(numbers("y"), top + height, -height),
    view: [left, left + width, top, top + height],
    rect: () => ({ x: left, y: top, width, height }),
    key: `${g.dataset.x} ${left} ${width}`,
  };
}

function listen(svg, cover, panel, panels, said) {
  let begin = null, frame = null;
  const ring = make("circle", { r: 3.5, fill: "none", stroke: "#D55E00", "stroke-width": 1.6, visibility: "hidden" });
  svg.insertBefore(ring, cover);
  const at = (event) => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return [
      Math.min(Math.max(point.x, panel.left), panel.left + panel.width),
      Math.min(Math.max(point.y, panel.top), panel.top + panel.height),
    ];
  };
  cover.style.cursor = "crosshair";
  cover.style.touchAction = "pan-y";
  cover.addEventListener("pointerdown", (event) => { begin = at(event); cover.setPointerCapture(event.pointerId); });
  cover.addEventListener("pointerleave", () => ring.setAttribute("visibility", "hidden"));
  cover.addEventListener("pointermove", (event) => {
    const [px, py] = at(event);
    if (begin) {
      frame ??= svg.insertBefore(make("rect", { fill: "#0072B2", "fill-opacity": 0.15 }), cover);
      const sides = { x: Math.min(px, begin[0]), y: Math.min(py, begin[1]), width: Math.abs(px - begin[0]), height: Math.abs(py - begin[1]) };
      for (const [name, value] of Object.entries(sides)) frame.setAttribute(name, value);
      return;
    }
    const near = nearest(panel, px, py);
    ring.setAttribute("visibility", near ? "visible" : "hidden");
    if (!near) return;
    ring.setAttribute("cx", near[0]);
    ring.setAttribute("cy", near[1]);
    const back = unseen(panel, near), digits = (v) => Number(v.toPrecision(4)).toString().replace("-", "−");
    said.textContent = `${panel.names[0] || "x"}: ${digits(panel.x.value(back[0]))}   ${panel.names[1] || "y"}: ${digits(panel.y.value(back[1]))}`;
  });
  cover.addEventListener("pointerup", (event) => {
    const end = at(event), old = begin;
    begin = null;
    frame?.remove();
    frame = null;
    if (!old || Math.abs(end[0] - old[0]) < 6 || Math.abs(end[1] - old[1]) < 6) return;
    const one = unseen(panel, old), two = unseen(panel, end);
    const [x, y] = [0, 1].map((i) => [one[i], two[i]].sort((a, b) => a - b));
    zoom(panel, [...x, ...y]);
    for (const other of panels) if (other !== panel && other.key === panel.key) zoom(other, [...x, ...other.view.slice(2)]);
  });
  cover.addEventListener("dblclick", () => {
    for (const other of panels) if (other.key === panel.key) zoom(other, null);
  });
}

// From the page as it is shown to the page as it was drawn, and back.
function unseen(panel, [px, py]) {
  const [x0, x1, y0, y1] = panel.view;
  return [x0 + (px - panel.left) / panel.width * (x1 - x0), y0 + (py - panel.top) / panel.height * (y1 - y0)];
}

function seen(panel, px, py) {
  const [x0, x1, y0, y1] = panel.view;
  return [panel.left + (px - x0) / (x1 - x0) * panel.width, panel.top + (py - y0) / (y1 - y0) * panel.height];
}

function nearest(panel, px, py) {
  let best = null, least = 20 ** 2;
  const offer = (x, y) => {
    const far = (x - px) ** 2 + (y - py) ** 2;
    if (far < least) [best, least] = [[x, y], far];
  };
  for (const { element, line } of panel.items) {
    if (element.tagName !== "path" || element.style.display === "none") continue;
    const d = element.getAttribute("d");
    for (const part of d.split("M").slice(1)) {
      const v = part.match(/-?\d+\.\d+/g)?.map(Number) || [];
      if (!line) { if (/[a-z]/.test(part) && !/[hv]/.test(part.slice(0, 24))) offer(v[0], v[1]); continue; }
      for (let i = 0; i + 3 < v.length; i += 2) {
        const [ax, ay, bx, by] = v.slice(i, i + 4), size = (bx - ax) ** 2 + (by - ay) ** 2;
        const share = size ? Math.min(Math.max(((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / size, 0), 1) : 0;
        offer(ax + share * (bx - ax), ay + share * (by - ay));
      }
    }
  }
  return best;
}

function zoom(panel, view) {
  panel.view = view || [panel.left, panel.left + panel.width, panel.top, panel.top + panel.height];
  const whole = !view, show = (x, y) => seen(panel, Number(x), Number(y)).map((v) => v.toFixed(2)).join(" ");
  for (const { element, before } of panel.items) {
    const d = before.getAttribute("d");
    if (d) {
      const rule = d.match(/^M(\S+) (\S+)([hv])\S+$/);
      const moved = rule && rule[3] === "h" ? `M${panel.left} ${show(0, rule[2]).split(" ")[1]}h${panel.width}`
        : rule ? `M${show(rule[1], 0).split(" ")[0]} ${panel.top}v${panel.height}`
        : d.replace(/([M ])(-?\d+\.\d\d) (-?\d+\.\d\d)/g, (_, pen, x, y) => pen + show(x, y));
      element.setAttribute("d", moved);
    } else if (before.hasAttribute("width")) {
      const [x, y, w, h] = ["x", "y", "width", "height"].map((n) => Number(before.getAttribute(n)));
      const [a, b] = [seen(panel, x, y), seen(panel, x + w, y + h)];
      Object.entries({ x: a[0], y: a[1], width: b[0] - a[0], height: b[1] - a[1] }).forEach(([n, v]) => element.setAttribute(n, v));
    } else element.style.display = whole ? "" : "none";
  }
  for (const old of panel.g.querySelectorAll("[data-ticks]")) old.style.display = whole ? "" : "none";
  panel.g.querySelector("[data-own]")?.remove();
  if (whole) return;
  const own = make("g", { "data-own": "" }), { left, top, width, height } = panel;
  const bare = (name) => !panel.g.querySelector(`[data-ticks="${name}"]`);
  const corner = unseen(panel, [left, top + height]), far = unseen(panel, [left + width, top]);
  for (const [v, text] of ticks(panel.x.value(corner[0]), panel.x.value(far[0]), panel.x.log, Math.max(3, width / 70))) {
    const x = seen(panel, panel.x.place(v), 0)[0];
    own.append(make("path", { d: `M${x} ${top}v${height}`, stroke: "#d9d9d9", "stroke-width": 0.5 }));
    if (!bare("x")) own.append(make("text", { x, y: top + height + 12.5, "text-anchor": "middle" }, text));
  }
  for (const [v, text] of ticks(panel.y.value(corner[1]), panel.y.value(far[1]), panel.y.log, Math.max(3, height / 40))) {
    const y = seen(panel, 0, panel.y.place(v))[1];
    own.append(make("path", { d: `M${left} ${y}h${width}`, stroke: "#d9d9d9", "stroke-width": 0.5 }));
    if (!bare("y")) own.append(make("text", { x: left - 4, y: y + 3, "text-anchor": "end" }, text));
  }
  panel.g.prepend(own);
}
