"""Loops: what is read from simple shapes, and samples that make no loop."""

from __future__ import annotations

import math

import numpy as np
import pytest

import microslip as ms

PHASE = np.linspace(0.0, 2.0 * np.pi, 2001)


def rectangle(samples: int = 1) -> ms.Loop:
    """Rigid-plastic: amplitude 2e-6 m, 3 N; ``samples`` steps on each side."""
    corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1], [1, 1]], dtype=float)
    steps = np.arange(4 * samples + 1) / samples
    x, t = (np.interp(steps, range(5), column) for column in corners.T)
    return ms.Loop(2e-6 * x, 3.0 * t)


def ellipse(lag: float, start: float = 0.0, closed: bool = True) -> ms.Loop:
    phase = start + (PHASE if closed else PHASE[:-1])
    return ms.Loop(2e-6 * np.cos(phase), 3.0 * np.cos(phase + lag))


# -- simple shapes ---------------------------------------------------------------------------------


@pytest.mark.parametrize("samples", [1, 7, 50])
def test_rectangle(samples: int) -> None:
    loop = rectangle(samples)
    assert loop.displacement_amplitude == 2e-6
    assert loop.force_amplitude == 3.0
    assert loop.dissipated_energy == pytest.approx(4 * 2e-6 * 3.0, rel=1e-14, abs=0)
    assert loop.energy_ratio == pytest.approx(1.0, rel=1e-14, abs=0)
    assert loop.loss_factor == pytest.approx(4 / math.pi, rel=1e-14, abs=0)
    assert loop.damping_ratio == pytest.approx(2 / math.pi, rel=1e-14, abs=0)
    assert loop.secant_stiffness == pytest.approx(1.5e6, rel=1e-14, abs=0)
    assert loop.sliding_ratio == pytest.approx(1.0, rel=1e-14, abs=0)
    assert loop.closure_error == 0.0


@pytest.mark.parametrize("lag", [1e-3, 0.3, 1.0, math.pi / 2])
@pytest.mark.parametrize("start", [0.0, 1.0, 4.0])
def test_ellipse(lag: float, start: float) -> None:
    """A linear, viscous loop: area pi x t sin(lag), eta = sin(lag)."""
    loop = ellipse(lag, start)
    assert loop.dissipated_energy == pytest.approx(math.pi * 6e-6 * math.sin(lag), rel=1e-5, abs=0)
    assert loop.loss_factor == pytest.approx(math.sin(lag), rel=1e-5, abs=0)
    assert loop.damping_ratio == pytest.approx(0.5 * math.sin(lag), rel=1e-5, abs=0)
    assert loop.energy_ratio == pytest.approx(math.pi / 4 * math.sin(lag), rel=1e-5, abs=0)
    assert loop.secant_stiffness == pytest.approx(1.5e6, rel=1e-5, abs=0)
    assert loop.sliding_ratio == pytest.approx(math.sin(lag), rel=1e-4, abs=0)
    assert loop.closure_error < 1e-14


# -- offsets, openings, scales ---------------------------------------------------------------------


@pytest.mark.parametrize("scale", [1e-200, 1e200])
def test_ratios_at_extreme_scales(scale: float) -> None:
    loop = rectangle(3)
    scaled = ms.Loop(scale * loop.displacement, scale * loop.force)
    assert scaled.secant_stiffness == pytest.approx(1.5e6, rel=1e-14, abs=0)
    assert scaled.sliding_ratio == pytest.approx(1.0, rel=1e-14, abs=0)
    try:
        ratio = scaled.energy_ratio
    except ms.InputError:
        return
    assert ratio == pytest.approx(1.0, rel=1e-14, abs=0)


def test_open_polygon_is_closed_by_its_chord() -> None:
    loop = rectangle(6)
    opened = ms.Loop(loop.displacement[:-1], loop.force[:-1])
    assert opened.dissipated_energy == pytest.approx(loop.dissipated_energy, rel=1e-14, abs=0)
    corners = ms.Loop([1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0])
    assert corners.energy_ratio == 1.0


def test_closure_error() -> None:
    assert ms.Loop([0.0, 1.0, 2.0, 0.0], [0.0, 1.0, 2.0, 1.0]).closure_error == 0.5
    assert ms.Loop([0.0, 1.0, 2.0, 0.0], [0.0, 2.0, 1.0, -2.0]).closure_error == 0.5
    assert ms.Loop([0.0, 1.0, 2.0, 0.0], [7.0, 8.0, 9.0, 7.0]).closure_error == 0.0
