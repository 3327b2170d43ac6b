"""Floor 8: what a study gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from microslip.friction import Interface
    from microslip.loops import Loop
    from microslip.study.schema import Study

Progress = Callable[[float], None]
Floats = NDArray[np.float64]

UNITS: dict[str, str] = {
    "normal_load": "N",
    "amplitude": "m",
    "displacement": "m",
    "force": "N",
    "force_amplitude": "N",
    "force_ratio": "-",
    "dissipated_energy": "J",
    "energy_ratio": "-",
    "loss_factor": "-",
    "damping_ratio": "-",
    "secant_stiffness": "N/m",
    "dissipation_exponent": "-",
    "stick_area": "m^2",
    "separation": "m",
    "standardised_separation": "-",
    "contact_count": "-",
    "contact_area": "m^2",
    "contact_area_fraction": "-",
    "normal_stiffness": "N/m",
    "tangential_stiffness": "N/m",
    "force_limit": "N",
    "slip_per_indentation": "-",
    "slip_scale": "m",
    "cubic_coefficient": "J/m^3",
    "linear_offset": "m",
}
"""Unit of every quantity in the tables and in the summary."""


def some(count: int, most: int) -> list[int]:
    """Indices of at most `most` of `count` things, evenly, the first and the last among them."""
    return sorted({round(i) for i in np.linspace(0, count - 1, min(count, most)).tolist()})


@dataclass(frozen=True, eq=False)
class AmplitudeCurve:
    """Cyclic quantities of one joint against the displacement amplitude, as equal-length arrays.

    `force_ratio` is the force amplitude over the force limit; `stick_area` is None where the
    normal law does not know its contacts. The rest is what the methods of
    :class:`microslip.Interface` of the same name return.
    """

    amplitude: Floats
    force_amplitude: Floats
    force_ratio: Floats
    dissipated_energy: Floats
    energy_ratio: Floats
    loss_factor: Floats
    damping_ratio: Floats
    secant_stiffness: Floats
    dissipation_exponent: Floats
    stick_area: Floats | None

    def columns(self) -> dict[str, Floats]:
        """Arrays by name, without the one that is not known."""
        named = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: array for name, array in named.items() if array is not None}

    @classmethod
    def of(cls, joint: Interface, amplitude: Floats) -> AmplitudeCurve:
        """Evaluate a joint.

        Parameters
        ----------
        joint : Interface
            A joint at one normal load.
        amplitude : ndarray
            Displacement amplitudes [m], one-dimensional.

        Returns
        -------
        AmplitudeCurve
            All quantities at these amplitudes.

        Raises
        ------
        InputError
            If the normal law has no answer at an amplitude.
        """
        force = np.asarray(joint.backbone(amplitude))
        known = joint.contact_area is not None
        return cls(
            amplitude=amplitude,
            force_amplitude=force,
            force_ratio=force / joint.force_limit,
            dissipated_energy=np.asarray(joint.dissipated_energy(amplitude)),
            energy_ratio=np.asarray(joint.energy_ratio(amplitude)),
            loss_factor=np.asarray(joint.loss_factor(amplitude)),
            damping_ratio=np.asarray(joint.damping_ratio(amplitude)),
            secant_stiffness=np.asarray(joint.secant_stiffness(amplitude)),
            dissipation_exponent=np.asarray(joint.dissipation_exponent(amplitude)),
            stick_area=np.asarray(joint.stick_area(amplitude)) if known else None,
        )


@dataclass(frozen=True)
class Limits:
    """What the dissipated energy E tends to: c a^3 at small amplitudes a, 4 mu N (a - b) at large.

    `cubic_coefficient` c [J/m^3] and `linear_offset` b [m]; None where the joint has no such limit.
    """

    cubic_coefficient: float | None
    linear_offset: float | None


@dataclass(frozen=True, eq=False)
class Result:
    """Result of :meth:`microslip.Study.run`; index 0 runs over normal loads, 1 over amplitudes.

    Parameters
    ----------
    study : Study
        What was computed.
    joints : tuple of Interface
        One for each normal load.
    loops : tuple of tuple of Loop
        For each load, one for each amplitude of the study.
    rows : tuple of AmplitudeCurve
        For each load, the cyclic quantities at the amplitudes of the loops.
    curves : tuple of AmplitudeCurve
        For each load, the same over the whole range of amplitudes.
    limits : tuple of Limits
        For each load, the asymptotes of the dissipated energy.
    summary : dict
        What `summary.json` holds: numbers in SI units, with a table of their units.
    """

    study: Study
    joints: tuple[Interface, ...]
    loops: tuple[tuple[Loop, ...], ...]
    rows: tuple[AmplitudeCurve, ...]
    curves: tuple[AmplitudeCurve, ...]
    limits: tuple[Limits, ...]
    summary: dict[str, Any]

    def save(
        self, folder: str | Path, overwrite: bool = False, progress: Progress | None = None
    ) -> tuple[Path, ...]:
        """Write tables, figures and summary into a new folder, whole or not at all.

        Parameters
        ----------
        folder : str or pathlib.Path
            The folder to make.
        overwrite : bool
            Whether an earlier result in its place may be replaced; nothing else ever is.
        progress : callable, optional
            Called now and then with the share that is done, 0 … 1.

        Returns
        -------
        tuple of pathlib.Path
            The files written.

        Raises
        ------
        StudyError
            If the folder exists, is not an earlier result or cannot be written.
        """
        from microslip.study.folder import staged
        from microslip.study.output import write

        with staged(Path(folder), overwrite) as stage:
            write(self, stage, progress)
        return tuple(Path(folder) / name for name in self.summary["files"])
