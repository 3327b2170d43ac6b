"""Figure of a friction law: backbone or a measure of closed cycles over amplitude."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from microslip._core.checks import Floats, show
from microslip._core.errors import InputError
from microslip._core.quantities import QUANTITIES
from microslip.figures.kit import axis_of
from microslip.figures.plot import DASHED, THIN, Guide, Panel, Plot

_SAME = "secant_stiffness", "dissipated_energy", "loss_factor", "damping_ratio"
_QUANTITIES = {
    "backbone": QUANTITIES["force"],
    "backbone_stiffness": QUANTITIES["tangent_stiffness"],
    **{name: QUANTITIES[name] for name in (*_SAME, "dissipation_exponent")},
}
_POINTS = 241
_RIGID = (1e-9, 1e-4)  # amplitudes [m] of a law without slip scale


def law_figure(law: Any, quantity: Any, amplitudes: Any) -> Plot:
    """Return a plot of a quantity over amplitudes [m]; default: from microslip to gross slip."""
    if not isinstance(quantity, str) or quantity not in _QUANTITIES:
        names = ", ".join(_QUANTITIES)
        raise InputError(f"`quantity` must be one of {names}, got {show(quantity)}")
    a = _amplitudes(law) if amplitudes is None else np.sort(law._amplitudes(amplitudes, None))
    a = a.reshape(-1)
    values = np.asarray(getattr(law, quantity)(a), dtype=float)
    largest = float(values[np.isfinite(values)].max(initial=0.0))
    log = quantity != "dissipation_exponent" and bool((values > 0.0).any())
    across = QUANTITIES["displacement" if quantity.startswith("backbone") else "amplitude"]
    panel = Panel(
        axis_of(across, float(a.max()), log=True, margin=0.0),
        axis_of(_QUANTITIES[quantity], largest, log=log),
    )
    x_unit, unit = panel.x.unit, panel.y.unit
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
