"use strict";
// The same joint as a study for the command; every number with all its digits.
function studyText(s) {
  const own = [1, 2].filter((n) => !s[`m${n}`]);
  const names = [1, 2].map((n) => s[`m${n}`] || `body${n}`);
  const lines = ["# Written by the explorer; predict it with: microslip predict study.toml", "", "schema = 1", 'title = "Joint from the explorer"', ""];
  for (const n of own) lines.push(`[material.body${n}]`, `young_modulus = "${s[`e${n}`]} Pa"`, `poisson_ratio = ${decimal(s[`nu${n}`])}`, "");
  const heights = s.kind === "gaussian" ? `{ kind = "gaussian", std = "${s.std} m" }` : `{ kind = "exponential", scale = "${s.std} m" }`;
  lines.push("[surface]", `materials = ["${names[0]}", "${names[1]}"]`, 'law = "greenwood-williamson"', `heights = ${heights}`,
    `radius = "${s.radius} m"`, `density = "${s.density} 1/m^2"`, `area = "${s.area} m^2"`, "",
    "[joint]", `friction_coefficient = ${decimal(s.mu)}`, `normal_load = ["${s.load} N"]`, "",
    "[excitation]", `amplitudes = ["${s.amplitude} m"]`, "");
  return lines.join("\n");
}
const decimal = (x) => (Number.isInteger(x) ? x.toFixed(1) : String(x));
