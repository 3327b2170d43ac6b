"use strict";
// The joint in closed form: a Greenwood-Williamson surface, T0 = mu [N(d) - N(d + u/kappa)].
// TABLES, NODES, WEIGHTS and RULES come from the Python package; SI units throughout.

const TERMS = 30, PIECES = 4;

function chebyshev(start, t) {
  let b1 = 0, b2 = 0;
  for (let k = start + TERMS - 1; k > start; k--) [b1, b2] = [2 * t * b1 - b2 + TABLES[k], b1];
  return t * b1 - b2 + TABLES[start];
}

// F_n(h) of the standard Gaussian, n = twice/2 from -1/2 to 5/2.
function gaussianMoment(twice, h) {
  const at = (piece) => ((twice + 1) * PIECES + piece) * TERMS;
  if (h > 1e3) return 0;
  if (h < -10) return (-h) ** (twice / 2) * chebyshev(at(0), 200 / (h * h) - 1);
  if (h < -4) return chebyshev(at(1), (h + 7) / 3);
  if (h < 0) return chebyshev(at(2), (h + 2) / 2);
  // exp(-h^2/2) with the square of the head exact: a rounded square would cost digits.
  const head = Math.floor(h * 128 + 0.5) / 128, r = 1 / (h + 4);
  const decay = Math.exp(-0.5 * head * head) * Math.exp(-0.5 * (h - head) * (h + head));
  return decay * r ** (twice / 2 + 1) * chebyshev(at(3), (h - 4) * r);
}

const GAMMA = [1.772453850905516, 1, 0.886226925452758, 1, 1.329340388179137, 2, 3.3233509704478426];

// Heights over their spread: moments by twice their order, and the end where all summits touch.
const HEIGHTS = {
  gaussian: { moment: gaussianMoment, least: -38, most: 37.5 },
  exponential: { moment: (twice, h) => GAMMA[twice + 1] * Math.exp(-h), least: 0, most: 700 },
};

function integral(g, u) {
  let sum = 0;
  for (let i = 0; i < NODES.length; i++) sum += WEIGHTS[i] * g(u * NODES[i]);
  return u * sum;
}

function composite(p) {
  const bodies = [[p.e1, p.nu1], [p.e2, p.nu2]];
  const modulus = 1 / bodies.reduce((s, [e, nu]) => s + (1 - nu * nu) / e, 0);
  const shear = 1 / bodies.reduce((s, [e, nu]) => s + (2 - nu) / (e / (2 * (1 + nu))), 0);
  return { modulus, ratio: modulus / (4 * shear) };
}

// Newton's method on log N over the standardised separation, kept in brackets.
function separation(heights, target) {
  let low = heights.least, high = heights.most, h = Math.min(Math.max(0, low), high);
  const size = (x) => Math.log(heights.moment(3, x));
  if (size(low) < Math.log(target)) {
    throw new RangeError("every summit touches: this load is beyond these heights");
  }
  if (!(size(high) < Math.log(target))) throw new RangeError("the load is too small to be distinguished from zero");
  for (let step = 0; step < 200; step++) {
    const miss = Math.log(heights.moment(3, h) / target);
    const length = heights.moment(3, h) / (1.5 * heights.moment(1, h));
    if (miss > 0) low = h; else high = h;
    let next = h + miss * length;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const moved = Math.abs(next - h);
    h = next;
    if (moved <= Math.max(4e-16 * Math.abs(h), 1e-16) || miss === 0) break;
  }
  return h;
}

// p: e1, nu1, e2, nu2 [Pa, -], kind, std [m], radius [m], density [1/m^2], area [m^2], mu, load [N].
function makeJoint(p) {
  const { modulus, ratio } = composite(p), s = p.std, heights = HEIGHTS[p.kind];
  const summits = p.density * p.area;
  const constant = summits * (4 / 3) * modulus * Math.sqrt(p.radius);
  const h = separation(heights, p.load / (constant * s ** 1.5));
  const kappa = p.mu * ratio, limit = p.mu * p.load;
  // Derivatives of the load by the separation: order 0, 1, 2 and -1, the integral to infinity.
  const factor = { [-1]: 0.4, 0: 1, 1: -1.5, 2: 0.75 };
  const load = (x, order) =>
    factor[order] * constant * s ** (1.5 - order) * heights.moment(3 - 2 * order, x);
  const here = load(h, 0), length = here / -load(h, 1);
  const kn = -load(h, 1), kt = kn / ratio;

  function backbone(u) {
    const v = u / kappa;
    const drop = v >= 0.5 * length
      ? here - load(h + v / s, 0)
      : integral((x) => -load(h + x / s, 1), v);
    return Math.min(p.mu * drop, limit);
  }
  const slope = (u) => (p.mu / kappa) * -load(h + u / kappa / s, 1);
  function energy(a) {
    const v = a / kappa;
    const excess = v >= length
      ? 0.5 * v * (here + load(h + v / s, 0)) - (load(h, -1) - load(h + v / s, -1))
      : integral((x) => 0.5 * x * (v - x) * load(h + x / s, 2), v);
    return 8 * p.mu * kappa * excess;
  }
  const lossFactor = (a) => energy(a) / (Math.PI * a * backbone(a));
  // From +a down to -a and up again, denser at the turning points.
  function loop(a, samples) {
    const turn = Math.floor(samples / 2), x = [], y = [], peak = backbone(a);
    for (let i = 0; i <= turn; i++) {
      const c = Math.cos((Math.PI * i) / turn);
      x.push(a * c);
      y.push(peak - 2 * backbone(0.5 * a * (1 - c)));
    }
    for (let i = 0; i <= turn; i++) {
      x.push(-x[i]);
      y.push(-y[i]);
    }
    return { x, y };
  }
  const count = summits * heights.moment(0, h);
  const area = Math.PI * summits * p.radius * s * heights.moment(2, h);
  const hardness = Math.min(p.hardness1 || Infinity, p.hardness2 || Infinity);
  const judged = {
    "density * radius * std": p.density * p.radius * s,
    "real over apparent area": area / p.area,
    "contact radius over summit spacing": Math.sqrt((area / (Math.PI * count)) * p.density),
    contacts: count,
  };
  if (hardness < Infinity) judged["plasticity index"] = (modulus / hardness) * Math.sqrt(s / p.radius);
  return {
    h, kappa, limit, kn, kt, count, area, scale: kappa * s, judged,
    backbone, slope, energy, lossFactor, loop,
  };
}

function verdicts(judged) {
  return Object.entries(judged).map(([name, value]) => {
    const rule = RULES[name], rising = rule.watch > rule.outside;
    const beyond = (end) => (rising ? value < end : value > end);
    return { name, value, rule, word: beyond(rule.outside) ? "outside" : beyond(rule.watch) ? "watch" : "ok" };
  });
}
