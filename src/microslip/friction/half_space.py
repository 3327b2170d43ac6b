"""Displacements of the surface of an elastic half-space under axisymmetric layers of traction.

Boussinesq's and Cerruti's kernels (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6) need two
integrals of a layer q(r): its potential and its deviator at the distance r from the centre,

    phi(r)            = integral of q / distance dA,
    psi(r) cos(2 angle) = integral of q (x^2 - y^2) / distance^3 dA,

x and y being the components of the distance. The second is the mean of the first over the disc of
radius r, less the first at its edge. For a Hertz layer that is cut out inside,

    q(r) = k [sqrt(a^2 - r^2) - sqrt(c^2 - r^2)]   (a root of a negative number being nothing),

both are integrals of one positive function g(t) = min(a^2 - t^2, a^2 - c^2), t < a:

    phi = pi k integral of g(r sin p) dp,   psi = pi k integral of g(r sin p) cos(2p) dp

over 0 <= p <= pi/2, so that neither loses digits far from the contact, nor with c next to a.
"""

from __future__ import annotations

import math

import numpy as np

from microslip._core.checks import Floats
from microslip.numerics.quadrature import gauss_legendre

# g is a polynomial of sines: on any part of a quarter turn this is exact to rounding.
_NODES, _WEIGHTS = gauss_legendre(16)


def potentials(k: float, outer: float, removed: float, r: Floats) -> tuple[Floats, Floats]:
    """Potential and deviator of a Hertz layer that is cut out inside."""
    inner = math.sqrt(max(outer * outer - removed, 0.0))
    far = np.maximum(r, np.finfo(float).tiny)  # the sine is 1 at the centre
    sine, edge = np.minimum(inner / far, 1.0), np.minimum(outer / far, 1.0)
    first, last = np.arcsin(sine), np.arcsin(edge)
    angle = first[:, None] + (last - first)[:, None] * _NODES
    g = np.maximum(outer**2 - (r[:, None] * np.sin(angle)) ** 2, 0.0)
    width = last - first
    phi = removed * first + width * (g @ _WEIGHTS)
    # The cosine of twice the angle integrates to sine times cosine: nothing in the stick circle.
    cosine = np.sqrt((1.0 - sine) * (1.0 + sine))
    psi = removed * sine * cosine + width * ((g * np.cos(2.0 * angle)) @ _WEIGHTS)
    return math.pi * k * phi, math.pi * k * psi
