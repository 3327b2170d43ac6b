"use strict";
// Round numbers along an axis and how they are written: [value, text] between low and high.
function ticks(low, high, log, most = 6) {
  const minus = (text) => text.replace("-", "−"), out = [];
  if (!log || high / low < 30) {
    const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 2.5, 5, 10].find((n) => n * power >= rough * (1 - 1e-9)) * power;
    for (let i = Math.ceil(low / step - 1e-9); i <= high / step + 1e-9; i++) {
      out.push([i * step, minus(String(Number((i * step).toPrecision(8))))]);
    }
    return out;
  }
  const first = Math.ceil(Math.log10(low) - 1e-9), last = Math.floor(Math.log10(high) + 1e-9);
  const every = Math.max(1, Math.ceil((last - first + 1) / most));
  const raised = (n) => String(n).replace(/[-\d]/g, (c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)]);
  for (let n = first; n <= last; n += every) {
    out.push([10 ** n, n >= -3 && n <= 4 ? String(Number((10 ** n).toPrecision(1))) : `10${raised(n)}`]);
  }
  return out;
}
