"""Frequency and damping against amplitude from a sine stepped through a resonance."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, record, whole_number
from microslip._core.errors import InputError
from microslip._core.verdicts import Rule, Verdict
from microslip.structures.modal_readings import Values
from microslip.structures.periodic_motion import POWERS, power_of

_NEAR = 0.3  # least sine of the phase behind the force, which is one at resonance
_FEWEST = 5
_KNOTS = 8
_LEVEL_SCATTER, _LEVEL_STEP = 0.03, 0.1  # of ln(amplitude), in a level and from level to level
_FORCED = 0.2  # of ln(force): how far it goes in a level of controlled response, at least

LINEAR = Rule(
    "misfit of one linear mode per level",
    0.05, 0.2,
    "At constant amplitude the mode is linear and isolated.",
    "Rms residual of force over amplitude, relative to its smallest value, which is at the "
    "resonance; for the worst level.",
    "Narrow the range of frequencies; look for a second mode, or a response that is not "
    "held constant.",
)  # fmt: skip
ENOUGH = Rule(
    "values within the half-power bandwidth",
    5.0, 3.0,
    "Each level has values on both sides of its resonance, close to it.",
    "Number of values whose phase is within 45 degrees of resonance, in the level with fewest.",
    "Use smaller frequency steps near the resonance.",
)  # fmt: skip
AGREEING = Rule(
    "modal constants of the levels",
    0.1, 0.3,
    "All levels belong to one mode and one position of the force.",
    "Largest over smallest modal constant of the levels, minus one.",
    "Check the unit and the calibration of the force, and whether a level belongs to another mode.",
    "there is one level",
)  # fmt: skip


class SteppedSine(NamedTuple):
    """Frequency and damping against amplitude from a stepped sine."""

    values: Values
    controlled: str
    """Quantity held constant: "response", or "force" where it was not the response."""
    verdicts: tuple[Verdict, ...] = ()


class _Level(NamedTuple):
    amplitude: float
    frequency: float
    damping_ratio: float
    constant: float
    misfit: float
    close: int


def stepped_sine(
    frequency: ArrayLike,
    amplitude: ArrayLike,
    phase: ArrayLike,
    force: ArrayLike,
    points: Any,
    quantity: Any,
) -> SteppedSine:
    """Evaluate a stepped sine; see :meth:`microslip.ModalTest.from_stepped_sine`."""
    points, power = whole_number("points", points, 1, 1000), power_of(quantity)
    f, sensed = record("frequency", frequency, "Hz"), record("amplitude", amplitude)
    psi, push = record("phase", phase, "rad"), record("force", force)
    if not f.shape == sensed.shape == psi.shape or push.size not in (1, f.size):
        raise InputError(
            "frequency, amplitude, phase and force must be of one length, got "
            f"{f.size}, {sensed.size}, {psi.size} and {push.size}"
        )
    for name, values in (("frequency", f), ("amplitude", sensed), ("force", push)):
        if values.min() <= 0.0:
            raise InputError(f"`{name}` must be above zero, got {values.min():g}")
    behind = 0.5 * math.pi * power - psi  # the displacement's phase behind the force
    near = np.flatnonzero(np.sin(behind) > _NEAR)
    if near.size < _FEWEST:
        raise InputError(
            f"phase of the {quantity} ahead of the force must pass a resonance, where it is "
            f"{90 * (power - 1)} degrees, with at least {_FEWEST} values within 70 degrees of it, "
            f"got {near.size}; {_other_phase(f, psi, power)}"
        )
    omega, sensed, behind = 2.0 * math.pi * f[near], sensed[near], behind[near]
    a = sensed / omega**power
    push = np.broadcast_to(push, f.shape)[near]
    with np.errstate(over="ignore"):
        apparent = push / a
    if not np.isfinite(apparent).all():
        raise InputError("`force` over the amplitude overflows")
    cosine, sine = apparent * np.cos(behind), apparent * np.sin(behind)
    if cosine.min() * cosine.max() >= 0.0:
        raise InputError("phase must pass 90 degrees behind the force, got one side of it alone")
    levels = _controlled_levels(np.log(sensed), np.log(push))
    if levels:
        read = _by_levels(levels, omega, a, cosine, sine, power)
        if read is None:
            raise InputError(
                "phase must pass 90 degrees behind the force in a level of controlled response, "
                "and the force in phase fall with frequency, got none that does; "
                f"{_other_phase(f, psi, power)}"
            )
        return read
    p = _modal_constant(omega, np.log(a), cosine)
    square = omega**2 + p * cosine
    if not p > 0.0 or square.min() <= 0.0:
        raise InputError(
            "frequency and phase do not fit one mode: the two sides of the resonance contradict "
            f"each other; take a narrower range of frequencies, or {_other_phase(f, psi, power)}"
        )
    natural = np.sqrt(square)
    zeta = p * sine / (2.0 * omega * natural)
    return SteppedSine(_means_by_level(a, natural / (2.0 * math.pi), zeta, points), "force")


def _other_phase(frequency: Floats, phase: Floats, power: int) -> str:
    """Return a sentence on how to convert ``phase`` to that of the sensor ahead of the force.

    ``power`` is the order of the time derivative of displacement that the sensor measures.
    """
    turned = np.unwrap(phase[np.argsort(frequency, kind="stable")])
    falling = bool(turned[-1] < turned[0])
    ahead = phase if falling else -phase
    lags = {name: float(np.sin(0.5 * math.pi * k - ahead).sum()) for name, k in POWERS.items()}
    name = max(lags, key=lambda name: lags[name])
    steps = [] if falling else ["change its sign"]
    if POWERS[name] != power:
        steps.append(f"add {90 * (power - POWERS[name]):+d} degrees")
    if not steps:
        return "check its sign and unit"
    sense = "ahead of" if falling else "behind"
    return f"it varies as the phase of the {name} {sense} the force: {' and '.join(steps)}"


def _controlled_levels(sensed: Floats, push: Floats) -> list[np.ndarray[Any, Any]]:
    """Return the indices of the points of each response level; none if it was not controlled."""
    order = np.argsort(sensed, kind="stable")
    levels = np.split(order, np.flatnonzero(np.diff(sensed[order]) > _LEVEL_STEP) + 1)
    steady = [
        np.sort(level)
        for level in levels
        if level.size >= _FEWEST
        and float(sensed[level].std()) < _LEVEL_SCATTER
        and float(np.ptp(push[level])) > max(_FORCED, 2.0 * float(np.ptp(sensed[level])))
    ]
    return steady if 2 * sum(level.size for level in steady) > sensed.size else []


def _by_levels(
    levels: list[Any], omega: Floats, a: Floats, cosine: Floats, sine: Floats, power: int
) -> SteppedSine | None:
    """Fit a linear mode to the points of each level; None if no level passes its resonance.

    At the excitation frequency W, the force over the displacement amplitude ``a`` has the parts
    ``cosine`` in phase, (w^2 - W^2)/p, and ``sine`` at 90 degrees, 2 zeta w W/p, with the natural
    frequency w and the modal constant p. ``power`` is that of :func:`_other_phase`.
    """
    read = []
    for level in levels:
        w, middle = omega[level], float(np.mean(omega[level] ** 2))
        in_phase, behind = cosine[level], sine[level]
        if in_phase.min() * in_phase.max() >= 0.0:
            continue
        stiff, inertia = np.polynomial.polynomial.polyfit(w**2 / middle - 1.0, in_phase, 1)
        if not inertia < 0.0:
            continue
        p = -middle / inertia
        natural = math.sqrt(middle + p * stiff)
        viscous = float(w @ behind / (w @ w))  # 2 zeta w over p
        left = in_phase - stiff - inertia * (w**2 / middle - 1.0), behind - viscous * w
        misfit = math.sqrt(float(np.mean(left[0] ** 2 + left[1] ** 2))) / (viscous * natural)
        close = int(np.count_nonzero(np.abs(in_phase) <= behind))
        order = np.argsort(w, kind="stable")
        at = float(np.exp(np.interp(natural, w[order], np.log(a[level])[order])))
        zeta = 0.5 * p * viscous / natural
        read.append(_Level(at, natural / (2.0 * math.pi), zeta, p, misfit, close))
    if not read:
        return None
    read.sort()
    rows = np.array([level[:3] for level in read]).T
    if len(read) > 1:
        # Held acceleration lets the displacement, and with it the frequency, fall along a level.
        bend = np.gradient(np.log(rows[1]), np.log(rows[0]))
        rows[2] *= 1.0 + power * bend
    constants = [level.constant for level in read]
    spread = float(max(constants) / min(constants)) - 1.0 if len(read) > 1 else None
    verdicts = (
        LINEAR.judge(max(level.misfit for level in read)),
        ENOUGH.judge(float(min(level.close for level in read))),
        AGREEING.judge(spread),
    )
    return SteppedSine((rows[0], rows[1], rows[2]), "response", verdicts)


def _modal_constant(omega: Floats, level: Floats, cosine: Floats) -> float:
    """Return p for which the squared natural frequency is a smooth function of ``level``.

    This square is W^2 + p ``cosine``, with the excitation frequency W = ``omega`` and the ratio
    ``cosine`` of in-phase force to amplitude; ``level`` is the logarithm of the amplitude.
    """
    low, high = float(level.min()), float(level.max())
    count = max(2, min(_KNOTS, omega.size // 5))
    knots = np.linspace(low, high if high > low else low + 1.0, count)
    hats = np.stack([np.interp(level, knots, row) for row in np.eye(count)], axis=1)
    middle = float(np.mean(omega**2))
    scale = float(np.abs(cosine).max())
    matrix = np.column_stack([-cosine / scale, hats])
    solution = np.linalg.lstsq(matrix, omega**2 / middle, rcond=None)[0]
    return float(solution[0]) * middle / scale


def _means_by_level(amplitude: Floats, frequency: Floats, damping: Floats, points: int) -> Values:
    level = np.log(amplitude)
    count = min(points, level.size)
    edges = np.linspace(level.min(), level.max(), count + 1)
    place = np.clip(np.searchsorted(edges, level, side="right") - 1, 0, count - 1)
    occupied = np.unique(place)

    def means(values: Floats) -> Floats:
        return np.array([np.exp(np.log(values[place == k]).mean()) for k in occupied])

    return means(amplitude), means(frequency), means(damping)
