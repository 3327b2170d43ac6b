"""The rule of memory diagrams, followed in exact fractions: slow, plain, without a stack."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

import microslip as ms

Piece = tuple[Fraction, Fraction, Fraction]
"""From a separation to a separation, and D there."""


class ExactContact:
    """D(eta) >= d as a list of pieces, in the order of eta, exact in every tie."""

    def __init__(self, joint: ms.Interface) -> None:
        self._joint = joint
        self._slip = Fraction(joint.slip_per_indentation)
        self._separation = Fraction(joint.separation)
        self._place = Fraction(0)
        self._pieces: list[Piece] = []

    def step(self, separation: float, displacement: float) -> float:
        """Force [N] after a straight step to a separation [m] and a displacement [m]."""
        d, place = Fraction(separation), Fraction(displacement) / self._slip
        fall, move = self._separation - d, place - self._place
        if fall > 0 and abs(move) <= fall:
            self._pieces.insert(0, (d, self._separation, move / fall))
        else:
            self._slide(d, place, 1 if self._missing(d, place) > 0 else -1)
        self._separation, self._place = d, place
        return self._force()

    def _missing(self, d: Fraction, place: Fraction) -> Fraction:
        """Place that the pieces beyond d leave to be made up."""
        return place - sum(
            ((end - max(start, d)) * value for start, end, value in self._pieces if end > d),
            Fraction(0),
        )

    def _slide(self, d: Fraction, place: Fraction, sign: int) -> None:
        """Let D be the sign from d to the front where the place is reached."""
        missing = self._missing(d, place) * sign
        kept = [(max(start, d), end, value) for start, end, value in self._pieces if end > d]
        front = max(d, self._separation)  # new contact slips with the rest
        gained = front - d if d < self._separation else Fraction(0)
        while gained < missing:
            if not kept:
                front += missing - gained
                gained = missing
                break
            start, end, value = kept[0]
            if start > front:  # nothing is stored between
                room = start - front
                if gained + room >= missing:
                    front += missing - gained
                    gained = missing
                    break
                front, gained = start, gained + room
            rate = 1 - sign * value
            if rate == 0:
                front = end
                kept.pop(0)
                continue
            if gained + rate * (end - start) <= missing:
                gained += rate * (end - start)
                front = end
                kept.pop(0)
            else:
                front = start + (missing - gained) / rate
                gained = missing
                kept[0] = (front, end, value)
        if front > d:
            kept = [(max(start, front), end, value) for start, end, value in kept if end > front]
            kept.insert(0, (d, front, Fraction(sign)))
        self._pieces = kept

    def _force(self) -> float:
        """mu times the integral of D (-N'), each piece by the drop of the load over it."""
        if not self._pieces:
            return 0.0
        surface = self._joint.surface
        ends = np.array([[float(start), float(end)] for start, end, _ in self._pieces])
        share = np.array([float(value) for _, _, value in self._pieces])
        load = np.asarray(surface.load(ends))
        return float(self._joint.friction_coefficient * np.sum(share * (load[:, 0] - load[:, 1])))
