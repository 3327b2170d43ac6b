"""Makes coupled.json: 40-digit forces and losses while the normal load varies.

    python tests/reference/make_coupled.py

No stack, no incremental force: after each step the function D is written down anew as a list of
intervals from its definition, the front q is found by walking out from the separation, and the
force is summed over all intervals. The loss of a step is the work done less the energy stored:
the work by quadrature between all kinks of the force within the step, the store in closed form.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import mpmath as mp
from make_reference import DIGITS, FiniteLaw, Interface, cases, nearest, write

CASES = ("gaussian-al2017", "exponential-light", "sphere", "seven-summits")

# Separation (in units of the indentation scale, from the joint's own) and displacement (in units).
PATH = (
    (-0.3, 0.1),  # load and shear that stick
    (-0.5, 0.8),  # and now slip
    (-0.5, 0.2),  # a turn at constant load
    (-0.1, 0.0),  # contact lost, slip
    (0.3, 0.05),
    (0.3, 0.05),  # nothing
    (-0.2, -0.4),
    (0.0, -0.4),  # the load falls under a held displacement
    (0.0, 2.5),  # gross slip
    (-0.6, 2.45),
    (-0.2, 2.1),
    (0.4, 2.1),
    (-0.3, 2.0),
)


Pieces = list[tuple[Any, Any, Any]]


def beyond(pieces: Pieces, at: Any) -> Pieces:
    """The intervals of D beyond a place."""
    return [(max(a, at), b, v) for a, b, v in pieces if b > at]


def advance(pieces: Pieces, d: Any, y: Any, to: Any, goal: Any) -> tuple[Pieces, tuple[int, int]]:
    """D after a straight step from separation d and integral y, with the front's sign and row."""
    move, fall = goal - y, d - to
    if abs(move) <= fall:
        return ([(to, d, move / fall), *pieces] if fall > 0 else pieces), (0, 0)
    kept = beyond(pieces, to)
    held = mp.fsum(v * (b - a) for a, b, v in kept)
    sign = mp.sign(goal - held) if fall < 0 else mp.sign(move)
    if sign == 0:
        return kept, (0, 0)
    # D = sign from `to` out to q, which lies in the row that makes the integral right.
    rest = sign * (goal - held) if fall < 0 else sign * move - fall
    q = to if fall < 0 else d
    for row, (a, b, v) in enumerate(kept):  # noqa: B007 - where it ended is the answer
        gain = (1 - sign * v) * (b - a)
        if gain > rest:
            q = a + rest / (1 - sign * v)
            break
        rest, q = rest - gain, b
    return [(to, q, sign), *beyond(pieces, q)], (int(sign), row - len(kept))


def force(joint: Interface, pieces: Pieces) -> Any:
    n = joint.law.load
    return joint.mu * mp.fsum(v * (n(a) - n(b)) for a, b, v in pieces if v)


def stored(joint: Interface, pieces: Pieces) -> Any:
    """mu kappa times the integral of D (-N') g, g the integral of D from the separation."""
    n, m = joint.law.load, joint.law.integral
    total = g = mp.mpf(0)
    for a, b, v in pieces:
        if v:
            total += v * (g * (n(a) - n(b)) + v * (m(a) - m(b) - (b - a) * n(b)))
            g += v * (b - a)
    return joint.mu * joint.kappa * total


def work(joint: Interface, pieces: Pieces, d: Any, y: Any, to: Any, goal: Any) -> Any:
    """Integral of the force over the displacement of a step, between all of its kinks."""
    if goal == y:
        return mp.mpf(0)
    places = [s for s, _ in joint.law.summits] if isinstance(joint.law, FiniteLaw) else [mp.mpf(0)]

    def there(t: Any) -> tuple[Pieces, tuple[Any, ...]]:
        now, mark = advance(pieces, d, y, d + (to - d) * t, y + (goal - y) * t)
        return now, (mark, *(sum(p > edge for p in places) for edge in now[0][:2]))

    marks = [mp.mpf(0)]
    steps = [mp.mpf(k) / 48 for k in range(49)]
    for begin, end in pairwise(steps):
        while there(begin)[1] != there(end)[1] and end - begin > mp.mpf(10) ** -30:
            low, high = begin, end
            while high - low > mp.mpf(10) ** -34:
                middle = (low + high) / 2
                low, high = (middle, high) if there(middle)[1] == there(begin)[1] else (low, middle)
            marks.append(high)
            begin = high
    marks.append(mp.mpf(1))
    integral = mp.quad(lambda t: force(joint, there(t)[0]), marks)
    return integral * joint.kappa * (goal - y)


def follow(joint: Interface, path: list[tuple[Any, Any]]) -> tuple[list[Any], list[Any]]:
    """Forces and accumulated losses along separations and displacements."""
    far = mp.mpf(1)  # one metre: nothing touches there
    pieces: Pieces = [(joint.separation, far, mp.mpf(0))]
    d, y, lost = joint.separation, mp.mpf(0), mp.mpf(0)
    forces, losses = [], []
    for to, x in path:
        goal = x / joint.kappa
        lost += work(joint, pieces, d, y, to, goal) + stored(joint, pieces)
        pieces, _ = advance(pieces, d, y, to, goal)
        lost -= stored(joint, pieces)
        d, y = to, goal
        forces.append(force(joint, pieces))
        losses.append(lost)
    return forces, losses


def make(case: dict[str, Any]) -> dict[str, Any]:
    joint = Interface(case)
    scale = joint.load / -joint.law.slope(joint.separation)
    unit = joint.load * joint.mu / joint.tangent(mp.mpf(0))
    path = [(float(joint.separation + mp.mpf(u) * scale), float(mp.mpf(w) * unit)) for u, w in PATH]
    with mp.workdps(40):
        forces, losses = follow(joint, [(mp.mpf(d), mp.mpf(x)) for d, x in path])
    return {
        "name": case["name"],
        "separation": [d for d, _ in path],
        "displacement": [x for _, x in path],
        "force": [nearest(t) for t in forces],
        "dissipated_energy": [nearest(w) for w in losses],
    }


def main() -> None:
    mp.mp.dps = DIGITS
    chosen = [case for case in cases() if case["name"] in CASES]
    write(
        "coupled.json",
        {"about": "Made by make_coupled.py; SI units.", "cases": [make(case) for case in chosen]},
    )


if __name__ == "__main__":
    main()
