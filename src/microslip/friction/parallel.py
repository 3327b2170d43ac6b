"""Parallel sum of friction laws with a common displacement."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np

from microslip._core.checks import Floats, members
from microslip._core.frozen import Locked, assign, lock
from microslip.friction.base import BackboneLaw
from microslip.friction.interface import Interface
from microslip.friction.jenkins import Jenkins
from microslip.friction.sliders import Sliders


@dataclass(frozen=True, eq=False)
class Parallel(Locked, BackboneLaw):
    """Sum of laws with a common displacement, such as the patches of one joint.

    Parameters
    ----------
    laws : sequence of BackboneLaw
        One or more laws of any kind.

    Notes
    -----
    All laws obey Masing's rules with the same reversals, so their sum does too: backbones,
    stiffnesses, energies and slider densities add (Iwan 1966, DOI 10.1115/1.3625199). If one law is
    rigid at rest, such as :class:`microslip.Coulomb`, the sum is rigid too: the displacement is 0
    under forces up to the limit of the rigid laws.
    """

    laws: Sequence[BackboneLaw]

    def __post_init__(self) -> None:
        expected = "a sequence of backbone laws, such as Parallel([joint, other])"
        assign(self, laws=tuple(members("laws", self.laws, BackboneLaw, expected)))

    @cached_property
    def force_limit(self) -> float:
        """Force of gross slip [N]: the sum of the laws' limits."""
        return math.fsum(law.force_limit for law in self.laws)

    @cached_property
    def tangential_stiffness(self) -> float:
        """Stiffness at rest T0'(0) [N/m]: the sum of the laws' stiffnesses."""
        return math.fsum(law.tangential_stiffness for law in self.laws)

    def _sum(self, name: str, u: Floats) -> Floats:
        return np.asarray(sum(getattr(law, name)(u) for law in self.laws))

    def _backbone(self, u: Floats) -> Floats:
        return np.minimum(self._sum("_backbone", u), self.force_limit)

    def _slope(self, u: Floats) -> Floats:
        return self._sum("_slope", u)

    def _backbone_and_slope(self, u: Floats) -> tuple[Floats, Floats]:
        parts = [law._backbone_and_slope(u) for law in self.laws]
        force, slope = (np.asarray(sum(values)) for values in zip(*parts, strict=True))
        return force, slope

    def _backbone_at(self, u: float) -> tuple[float, float]:
        pairs = [law._backbone_at(u) for law in self.laws]
        force = min(sum(force for force, _ in pairs), self.force_limit)
        return force, sum(slope for _, slope in pairs)

    def _energy(self, amplitude: Floats) -> Floats:
        return self._sum("_energy", amplitude)

    def _energy_slope(self, amplitude: Floats) -> Floats:
        return self._sum("_energy_slope", amplitude)

    @cached_property
    def _rigid(self) -> tuple[BackboneLaw, ...]:
        return tuple(law for law in self.laws if math.isinf(law.tangential_stiffness))

    @cached_property
    def _compliant(self) -> Parallel | None:
        soft = [law for law in self.laws if math.isfinite(law.tangential_stiffness)]
        return Parallel(soft) if soft else None

    def _below_limit(self, name: str, force: Floats) -> Floats:
        if self._compliant is None:
            return self._rigid[0]._below_limit(name, force)
        return super()._below_limit(name, force)

    def _inverse(self, force: Floats) -> Floats:
        if not self._rigid or self._compliant is None:
            return super()._inverse(force)
        rigid_force = math.fsum(law.force_limit for law in self._rigid)
        return self._compliant._inverse(np.maximum(force - rigid_force, 0.0))

    @cached_property
    def _kinks(self) -> Floats:
        return np.unique(np.concatenate([law._kinks for law in self.laws]))

    @property
    def _harmonic_parts(self) -> tuple[BackboneLaw, ...]:
        if not self._rigid:
            return (self,)
        laws = self._rigid if self._compliant is None else (*self._rigid, self._compliant)
        return tuple(part for law in laws for part in law._harmonic_parts)

    def sliders(self) -> Sliders:
        """Return the sliders of all laws together.

        The discrete ones have yield displacements [m] and stiffnesses [N/m], the others a
        density [N/m^2] over the yield displacement.
        """
        parts = [law.sliders() for law in self.laws]
        places = np.concatenate([part.yield_displacements for part in parts])
        stiffnesses = np.concatenate([part.stiffnesses for part in parts])
        order = np.argsort(places, kind="stable")
        spread = [part._density for part in parts if part._density is not None]

        def density(u: Floats) -> Floats:
            return np.asarray(sum(part(u) for part in spread))

        return Sliders(lock(places[order]), lock(stiffnesses[order]), density if spread else None)

    def __repr__(self) -> str:
        count = len(self.laws)
        return (
            f"Parallel({count} {'law' if count == 1 else 'laws'}, "
            f"stiffness={self.tangential_stiffness:g}, force_limit={self.force_limit:g})"
        )

    @classmethod
    @cache
    def examples(cls) -> tuple[Parallel, ...]:
        """Return a nonuniformly pressed joint, and a joint in parallel with a Jenkins cell."""
        joint = Interface.examples()[0]
        uneven = [joint.at(normal_load=load) for load in (50.0, 600.0, 1350.0)]
        return cls(uneven), cls([joint, Jenkins(stiffness=2e9, force_limit=300.0)])
