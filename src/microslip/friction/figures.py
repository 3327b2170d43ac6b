"""Figure of a friction law: backbone or a measure of closed cycles over amplitude."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.units import prefix
from microslip.figures.kit import length_prefix
from microslip.figures.plot import DASHED, THIN, Axis, Guide, Panel, Plot

_LABELS = {
    "backbone": ("Force of first loading", "N"),
    "backbone_stiffness": ("Tangent stiffness", "N/m"),
    "secant_stiffness": ("Secant stiffness", "N/m"),
    "dissipated_energy": ("Dissipated energy per cycle", "J"),
    "loss_factor": ("Loss factor η", ""),
    "damping_ratio": ("Damping ratio ζ of the interface", ""),
    "dissipation_exponent": ("Local exponent d ln E / d ln δ", ""),
}
_POINTS = 241
_RIGID = (1e-9, 1e-4)  # amplitudes [m] of a law without slip scale


def law_figure(law: Any, quantity: Any, amplitudes: Any) -> Plot:
    """Return a plot of a quantity over amplitudes [m]; default: from microslip to gross slip."""
    if not isinstance(quantity, str) or quantity not in _LABELS:
        names = ", ".join(_LABELS)
        raise InputError(f"`quantity` must be one of {names}, got {show(quantity)}")
    a = _amplitudes(law) if amplitudes is None else np.sort(law._amplitudes(amplitudes, None))
    a = a.reshape(-1)
    values = np.asarray(getattr(law, quantity)(a), dtype=float)
    x_unit, x_letter = length_prefix(float(a.max()))
    name, symbol = _LABELS[quantity]
    finite = values[np.isfinite(values)]
    unit, letter = prefix(float(finite.max(initial=0.0)) or 1.0) if symbol else (1.0, "")
    log = quantity != "dissipation_exponent" and bool((values > 0.0).any())
    displacement = "Displacement" + " amplitude" * (not quantity.startswith("backbone"))
    panel = Panel(
        Axis(f"{displacement} [{x_letter}m]", log=True, margin=0.0, unit=x_unit),
        Axis(f"{name} [{letter}{symbol}]" if symbol else name, log=log, unit=unit),
    )
    panel.line(a / x_unit, values / unit)
    if quantity == "backbone":
        stuck = law.tangential_stiffness * a
        near = stuck < 4.0 * law.force_limit
        panel.line(a[near] / x_unit, stuck[near] / unit, width=THIN, dash=DASHED)
        panel.add(Guide(law.force_limit / unit))
        panel.note = "dashed: full stick, T = kₜ δ, and gross slip"
    elif quantity in ("loss_factor", "damping_ratio"):
        factor = 4.0 if quantity == "loss_factor" else 2.0
        panel.add(Guide(factor / math.pi))
        panel.note = f"dashed: rigid–plastic, {factor:g}/π"
    return Plot([panel], 4.2)


def _amplitudes(law: Any) -> Floats:
    scale = law.force_limit / law.tangential_stiffness
    low, high = (1e-3 * scale, 1e2 * scale) if 0.0 < scale < math.inf else _RIGID
    return np.geomspace(low, high, _POINTS)
