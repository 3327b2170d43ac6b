"""Identification of a joint from tests of its structure: friction, bolts, form, modulus, loss."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, number, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import LockedArrays
from microslip._core.verdicts import Rule, Verdict
from microslip._core.wording import did_you_mean, quoted
from microslip.contact import NormalLaw
from microslip.structures.modal_curve import ModalCurve, judge_shift
from microslip.structures.modal_test import ModalTest
from microslip.structures.reduction_model import ReducedJoint
from microslip.structures.structure import Preload

_UNREACHED = 1e3  # standard errors
_DRAWS = 32  # of the parameters, for the bands of the fitted curves


class _Kind(NamedTuple):
    low: float
    high: float
    log: bool
    scatter: float = 0.0
    """Standard deviation about the initial guess when linear frequencies are matched; zero for
    parameters that do not affect them."""

    def coordinate(self, value: float) -> float:
        return math.log(value) if self.log else value

    def value(self, coordinate: float) -> float:
        return math.exp(min(coordinate, 700.0)) if self.log else float(coordinate)


FITTABLE = {
    "friction_coefficient": _Kind(0.01, 3.0, True),
    "tension": _Kind(0.05, 5.0, True, 0.3),
    "form": _Kind(-3.0, 3.0, False, 1.0),
    "young_modulus": _Kind(0.5, 2.0, True, 0.05),
    "base_damping_ratio": _Kind(1e-7, 0.1, True),
}
"""Parameters that can be fitted; tension, form and Young's modulus are factors on given values."""

MISFIT = Rule(
    "misfit over the errors of the test",
    1.5, 3.0,
    "The residual is no larger than the errors of the test.",
    "Root of chi-squared per degree of freedom; the intervals are widened by this factor.",
    "Check form, base damping and patches first: inputs that are not fitted must be right.",
    "there are no more values than parameters",
)  # fmt: skip
SEPARATED = Rule(
    "correlation of two parameters",
    0.95, 0.99,
    "The test separates the parameters.",
    "Largest absolute correlation; friction and tension change the damping in the same way.",
    "Give one of them, or add a mode, or larger amplitudes.",
    "there is one parameter",
)  # fmt: skip
SHARP = Rule(
    "width of an interval",
    1.0, 3.0,
    "The test determines each parameter.",
    "Half-width of the widest 90 % interval relative to its value.",
    "Give that parameter: this test does not determine it.",
)  # fmt: skip
INSIDE = Rule(
    "parameters at a bound",
    0.5, 0.5,
    "No parameter lies at a bound of its range.",
    "Number of parameters at the end of their range.",
    "The model cannot match the test with the given inputs.",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ModalIdentification(LockedArrays):
    """Joint identified from tests of a structure, the result of :func:`identify_modal`.

    Least squares of ln(frequency) and ln(damping ratio); intervals by its linearisation, after
    Seber and Wild, DOI 10.1002/0471725315.
    """

    values: Mapping[str, float]
    """Fitted parameters by name [-]; tension and modulus relative to the given ones."""
    intervals: Mapping[str, tuple[float, float]]
    """90 % intervals by name [-]."""
    correlation: Floats
    """Correlations of the parameters in the order of ``values`` [-]."""
    scatter: Floats
    """Standard deviations in the order of ``values`` [-]; of the logarithm except for the form."""
    misfit: float
    """Square root of chi square per degree of freedom [-]."""
    linear_frequencies: Floats
    """Frequency of each test measured at its smallest amplitude, and those with sticking joints
    before and after the fit, (tests, 3) [Hz]."""
    curves: tuple[ModalCurve, ...]
    """Curve of each test by harmonic balance, at the amplitudes of the test."""
    bands: tuple[Floats, ...]
    """90 % band of the curve of each test by the covariance of the parameters, (2, 2, amplitudes):
    frequency [Hz] and damping ratio [-], 5 and 95 % quantiles."""
    state: Preload
    """Identified joint."""
    joint: ReducedJoint
    """Reduced joint with the identified tension and form."""
    verdicts: tuple[Verdict, ...]
    """Verdicts on the fit and on the determination of the parameters."""


def identify_modal(
    joint: ReducedJoint,
    surface: NormalLaw | Callable[[float], NormalLaw],
    tests: ModalTest | Iterable[ModalTest],
    fit: Sequence[str] = ("friction_coefficient", "tension", "form"),
    *,
    friction_coefficient: float = 0.3,
    tension: float = 1.0,
    form: float = 1.0,
    young_modulus: float = 1.0,
    base_damping_ratio: float = 0.0,
    form_table: ArrayLike | Any = None,
) -> ModalIdentification:
    """Fit a joint's friction, bolt tension, form, modulus and base damping to tests of modes.

    Parameters
    ----------
    joint : ReducedJoint
        The structure, with the sensors of the tests, flat if ``form_table`` is given.
    surface : NormalLaw or callable
        Normal load law of the surface, or a function that returns it for a modulus relative to the
        given one [-].
    tests : ModalTest or iterable of ModalTest
        Tests of one or several modes.
    fit : sequence of str
        Parameters to fit: "friction_coefficient", "tension", "form", "young_modulus",
        "base_damping_ratio".
    friction_coefficient, tension, form, young_modulus, base_damping_ratio : float
        Initial guesses [-], or known values. ``form`` is the factor on ``form_table``; tension and
        modulus are relative to those of the joint.
    form_table : array_like or callable, optional
        Form for the factor 1 [m], see :meth:`ReducedJoint.with_form`; by default the gaps of the
        joint, of shape (patches,).

    Returns
    -------
    ModalIdentification
        Values, intervals, correlations and verdicts.

    Notes
    -----
    Form, tension and modulus are first adjusted so that the modes of sticking joints match the
    frequencies at the smallest amplitudes. A single mode separates form and modulus only by its
    slip; a higher mode, on which the form has less effect, separates them better. All parameters
    are then fitted to the curves of :meth:`Preload.modes` by harmonic balance
    (Szemplinska-Stupnicka 1979, DOI 10.1016/S0022-460X(79)80003-1).
    """
    if not isinstance(joint, ReducedJoint):
        raise InputError(f"`joint` must be a ReducedJoint, got {show(joint)}")
    modal_tests = [tests] if isinstance(tests, ModalTest) else list(tests)
    names = _checked(fit, modal_tests)
    unit_form = joint.patch_gaps if form_table is None else form_table
    if "form" in names and form_table is None and not joint.patch_gaps.any():
        raise InputError("form can be fitted only where the faces are not flat; give form_table")
    start = {
        "friction_coefficient": positive("friction_coefficient", friction_coefficient, "", 0.3),
        "tension": positive("tension", tension, "", 1.0),
        "form": number("form", form),
        "young_modulus": positive("young_modulus", young_modulus, "", 1.0),
        "base_damping_ratio": number("base_damping_ratio", base_damping_ratio),
    }
    for name in ("friction_coefficient", "tension", "form", "young_modulus"):
        low, high = FITTABLE[name][:2]
        if not min(0.1 * low, 10.0 * low) <= start[name] <= 10.0 * high:
            raise InputError(f"`{name}` must be about {low:g} to {high:g}, got {start[name]:g}")
    if "base_damping_ratio" in names and start["base_damping_ratio"] <= 0.0:
        start["base_damping_ratio"] = 0.1 * min(float(t.damping_ratio.min()) for t in modal_tests)
    return _Fit(joint, surface, modal_tests, names, start, unit_form).run()


def _checked(fit: Sequence[str], tests: list[ModalTest]) -> tuple[str, ...]:
    names = (fit,) if isinstance(fit, str) else tuple(fit)
    for name in names:
        if name not in FITTABLE:
            raise InputError(
                f"fit must be among {quoted(FITTABLE)}, got {show(name)}"
                f"{did_you_mean(str(name), FITTABLE)}"
            )
    if not names or len(set(names)) != len(names):
        raise InputError("fit must name each parameter once, and at least one")
    if not tests or not all(isinstance(test, ModalTest) for test in tests):
        raise InputError("tests must be of ms.ModalTest, one or more")
    count = sum(2 * len(test.amplitude) for test in tests)
    if count < len(names):
        raise InputError(f"{len(names)} parameters need as many values, the tests have {count}")
    return names


@dataclass
class _Fit:
    joint: ReducedJoint
    surface: NormalLaw | Callable[[float], NormalLaw]
    tests: list[ModalTest]
    names: tuple[str, ...]
    start: dict[str, float]
    form: Any

    def run(self) -> ModalIdentification:
        from scipy.optimize import least_squares

        reached = self._reached(self.start)  # says what is wrong with a mode or a sensor, too
        begin = self._by_linear_frequencies()
        if not self._reached(begin):
            begin = self.start
            if not reached:
                raise InputError(
                    "the model must reach the tests' amplitudes at the initial values of the fit; "
                    "give other initial values, or remove the largest amplitudes"
                )
        first, bounds = self._coordinates(self.names, begin)
        solved = least_squares(
            self._residuals, first, bounds=bounds, diff_step=2e-3, xtol=1e-8, ftol=1e-10,
            max_nfev=40,
        )  # fmt: skip
        at_bounds = int((np.abs(solved.active_mask) > 0).sum())
        return self._result(solved.x, solved.jac, solved.fun, at_bounds)

    def _reached(self, values: dict[str, float]) -> bool:
        return all(c.converged.all() for c in self._curves(self._state(values)[1], values))

    def _coordinates(
        self, names: Sequence[str], values: dict[str, float]
    ) -> tuple[Floats, tuple[Floats, Floats]]:
        kinds = [FITTABLE[name] for name in names]
        low, high = np.array([[k.coordinate(k.low), k.coordinate(k.high)] for k in kinds]).T
        given = [kind.coordinate(values[name]) for name, kind in zip(names, kinds, strict=True)]
        return np.clip(given, low, high), (low, high)

    def _by_linear_frequencies(self) -> dict[str, float]:
        from scipy.optimize import least_squares

        names = tuple(name for name in self.names if FITTABLE[name].scatter)
        if not names:
            return self.start
        first, bounds = self._coordinates(names, self.start)
        scatter = np.array([FITTABLE[name].scatter for name in names])
        errors = np.array([test.frequency_error for test in self.tests])

        def residuals(vector: Floats) -> Floats:
            frequencies = self._linear(self._values(vector, names))
            differences = np.log(frequencies / self._lowest) / errors
            return np.concatenate([differences, (vector - first) / scatter])

        solved = least_squares(residuals, first, bounds=bounds, diff_step=2e-3)
        return self._values(solved.x, names)

    @property
    def _lowest(self) -> Floats:
        return np.array([test.frequency[test.amplitude.argmin()] for test in self.tests])

    def _linear(self, values: dict[str, float]) -> Floats:
        squares = self._state(values)[1].model.squares
        return np.asarray(np.sqrt(squares[[t.mode for t in self.tests]]) / (2.0 * math.pi))

    def _values(self, vector: Floats, names: Sequence[str] = ()) -> dict[str, float]:
        pairs = zip(names or self.names, vector, strict=True)
        return self.start | {name: FITTABLE[name].value(v) for name, v in pairs}

    def _state(self, values: dict[str, float]) -> tuple[ReducedJoint, Preload]:
        modulus = values["young_modulus"]
        joint = self.joint.scaled(modulus).with_tension(self.joint.bolt_tension * values["tension"])
        if np.ndim(self.form) != 1 or np.any(self.form):
            joint = joint.with_form(self.form, values["form"])
        surface = self.surface if isinstance(self.surface, NormalLaw) else self.surface(modulus)
        return joint, joint.tightened(surface, values["friction_coefficient"])

    def _curves(self, state: Preload, values: dict[str, float]) -> list[ModalCurve]:
        return [
            state.modes(
                test.mode,
                test.amplitude,
                at=self.joint.sensor(test.sensor),
                damping_ratio=values["base_damping_ratio"],
            )
            for test in self.tests
        ]

    def _residuals(self, vector: Floats) -> Floats:
        values = self._values(vector)
        curves, parts = self._curves(self._state(values)[1], values), []
        for test, curve in zip(self.tests, curves, strict=True):
            errors = np.array([[test.frequency_error], [test.damping_error]])
            logs = np.log([curve.frequency, test.damping_of(curve)])
            parts.append(((logs - np.log([test.frequency, test.damping_ratio])) / errors).ravel())
        # A trial that does not reach a measured amplitude is penalised.
        return np.asarray(np.nan_to_num(np.concatenate(parts), nan=_UNREACHED))

    def _result(
        self, vector: Floats, jacobian: Floats, residuals: Floats, at_bounds: int
    ) -> ModalIdentification:
        free = len(residuals) - len(vector)
        misfit = math.sqrt(float(residuals @ residuals) / free) if free > 0 else math.nan
        widening = 1.0 if math.isnan(misfit) else max(misfit, 1.0) ** 2
        covariance = np.linalg.pinv(jacobian.T @ jacobian) * widening
        error = np.sqrt(np.diag(covariance))
        scale = np.where(error > 0.0, error, 1.0)
        correlation = covariance / scale[:, None] / scale
        values = self._values(vector)
        half = 1.6448536269514722 * error  # of the normal distribution, 5 to 95 %
        intervals = {}
        widths = []
        for name, v, h in zip(self.names, vector, half, strict=True):
            kind, size = FITTABLE[name], abs(values[name])
            low, high = intervals[name] = kind.value(v - h), kind.value(v + h)
            widths.append(0.5 * (high - low) / (size if kind.log else max(size, 0.1)))
        off_diagonal = (
            abs(correlation - np.diag(np.diag(correlation))).max() if len(vector) > 1 else None
        )
        verdicts = (
            MISFIT.judge(misfit),
            SEPARATED.judge(None if off_diagonal is None else float(off_diagonal)),
            SHARP.judge(max(widths)),
            INSIDE.judge(float(at_bounds)),
            *(
                judge_shift(test.name, test.amplitude, test.frequency, test.damping_ratio)
                for test in self.tests
            ),
        )
        joint, state = self._state(values)
        curves = tuple(self._curves(state, values))
        bands = self._bands(vector, np.asarray(covariance, dtype=float))
        fitted = {name: values[name] for name in self.names}
        linear = np.stack([self._lowest, self._linear(self.start), self._linear(values)], axis=1)
        return ModalIdentification(
            fitted, intervals, correlation, np.asarray(error), misfit, linear, curves, bands, state,
            joint, verdicts,
        )  # fmt: skip

    def _bands(self, vector: Floats, covariance: Floats) -> tuple[Floats, ...]:
        from scipy.special import ndtri
        from scipy.stats import qmc

        points = qmc.Sobol(len(vector), rng=np.random.default_rng(0)).random(_DRAWS)
        squares, axes = np.linalg.eigh(covariance)
        root = axes * np.sqrt(np.maximum(squares, 0.0))
        low, high = self._coordinates(self.names, self.start)[1]
        draws: list[list[Floats]] = [[] for _ in self.tests]
        for point in points:
            values = self._values(np.clip(vector + root @ ndtri(point), low, high))
            curves = self._curves(self._state(values)[1], values)
            for rows, test, curve in zip(draws, self.tests, curves, strict=True):
                rows.append(np.array([curve.frequency, test.damping_of(curve)]))
        return tuple(
            np.moveaxis(np.nanquantile(np.array(rows), (0.05, 0.95), axis=0), 0, 1)
            for rows in draws
        )
