"""Normal load law of a machined face that is specified by a drawing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cache, cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from microslip._core.checks import Floats, exact, plain, positive, show
from microslip._core.errors import InputError
from microslip._core.frozen import assign, lock
from microslip.contact import face_table as table
from microslip.contact.base import OVER_HARDNESS, NormalLaw, aluminium, check_pair
from microslip.contact.face_law import FaceErrors, FaceLaw, FirstLoading, checked_direction
from microslip.contact.finish import HIGHEST, STEEPEST, Finish, combined
from microslip.contact.materials import MaterialPair

STIFFNESS_ERROR = 0.18
"""Standard deviation of ln k_n against boundary elements [-], from `tests/faces`. For Gaussian
faces it is 0.05. The rest is the difference between kinds of machined faces of equal rms height and
slope, which also have other height distributions and textures. The skewness and kurtosis of the
heights, if they were known, would reduce it to 0.15 at best."""
SHAPE_FACTOR = 1.22
"""Median of ``shape_factor`` [-] for machined faces, whose small cycles dissipate more than those
of the Gaussian faces of the table."""
SHAPE_ERROR = 0.40
"""Standard deviation of ln(shape_factor) [-] for machined faces, see :meth:`DrawnFace.drawn`."""
_BREADTH_SPREAD = 0.1  # of ln(breadth), where it is not known
_LOADINGS = 40
_STEP = 0.02  # of logarithms, for slopes


@dataclass(frozen=True, eq=False, repr=False)
class DrawnFace(FaceLaw):
    """A rough face given by the rms height and slope of a drawing, tightened once to a pressure.

    The law is interpolated from a table of Gaussian faces that were solved by boundary elements
    with yielding; the table depends on three dimensionless groups (see Notes). Use it if there is
    no scan; :class:`microslip.MeasuredContact` solves a scan point by point.

    Parameters
    ----------
    pair : MaterialPair
        The two materials; the hardness of the softer one bounds the pressure.
    rms : float
        Root mean square height Rq of the gap [m]: for two rough faces the root of the sum of their
        squares, see :meth:`from_finish`.
    slope : float
        Root mean square slope Rdq of profiles of the gap [-]; across the lay, if there is one. It
        depends on the short-wave cut-off lambda_s, which must be stated.
    area : float
        Apparent area [m^2].
    tightening_pressure : float
        Largest mean pressure that the face has carried [Pa].
    plateau : float, optional
        Rms height Rpq of the plateau [m] of a honed face (ISO 21920-2), whose valleys carry no
        load. Then ``plateau`` replaces ``rms``, and ``slope * plateau/rms`` replaces ``slope``.
    breadth : float, optional
        Breadth Rq <q>/h' of the spectrum [-], from 0.6 to 0.95, with the mean wavenumber <q> and
        the rms gradient h'; by default 0.84. Below 0.73 the unloading curve for 0.73 is used.
    lay : float, optional
        Slope of profiles along the lay over that across it, in (0, 1]; 1 for an isotropic face. It
        determines how the ratio of normal to tangential stiffness depends on direction.
    direction : float, optional
        Direction of the motion [rad] from the normal to the lay; None: mean of all directions.
    spreads : mapping, optional
        Standard deviations of the logarithms of "rms", "slope", "hardness" and
        "tightening_pressure" [-], of uncertain inputs; see :meth:`drawn`.
    stiffness_factor, shape_factor : float
        Factors [-] by which the stiffness and the dissipation of small cycles are multiplied, to
        draw random faces or to fit a measured stiffness.

    Notes
    -----
    With the groups h = H/(E* h'), A = p/H and the breadth, where H is the hardness and p the
    tightening pressure, the stiffness k_n Rq/p and the shape of the unloading curve are taken from
    the table; k_n and k_t are the normal and tangential stiffness per area [N/m^3]. The contact is
    elastic below the tightening load, so that friction follows from the law as for any other
    surface (Ciavarella 1998, J. Appl. Mech. 65, 998). Yielding is an upper bound on the pressure
    (Almqvist et al. 2007, DOI 10.1016/j.triboint.2005.11.008).

    With a lay, k_n/k_t = a - (a - 1) c, with a = 2 lambda - 1, the stiffness ratio lambda of the
    pair, and c the slope in the direction of motion over the sum of the two slopes.
    """

    separations: Any = field(init=False, default=None)
    loads: Any = field(init=False, default=None)
    tail: Any = field(init=False, default="exponential")
    rms: float
    slope: float
    area: float
    tightening_pressure: float
    _: KW_ONLY
    plateau: float | None = None
    breadth: float | None = None
    lay: float | None = None
    direction: float | None = None
    spreads: Mapping[str, float] = field(default_factory=dict)
    stiffness_factor: float = 1.0
    shape_factor: float = 1.0

    def __post_init__(self) -> None:
        check_pair(self.pair)
        if self.pair.hardness is None:
            raise InputError(
                "`pair` must have a hardness [Pa], which limits the pressure; write "
                "Material(210e9, 0.3, hardness=2.4e9), and a very large one for an elastic face"
            )
        checked: dict[str, Any] = {
            name: positive(name, getattr(self, name), unit, example)
            for name, unit, example in (
                ("rms", "m", 4e-7),
                ("slope", "", 0.1),
                ("area", "m^2", 1e-4),
                ("tightening_pressure", "Pa", 1e8),
                ("stiffness_factor", "", 1.0),
                ("shape_factor", "", 1.0),
            )
        }
        for name, unit, least, most, example in (
            ("plateau", "m", 0.0, checked["rms"], 1e-7),
            ("breadth", "", table.BREADTH[0], table.BREADTH[2], 0.84),
            ("lay", "", 0.0, 1.0, 0.2),
        ):
            if getattr(self, name) is None:
                continue
            value = checked[name] = positive(name, getattr(self, name), unit, example)
            if not least <= value <= most:
                where = " of `rms`" if name == "plateau" else ""
                limit = f"most {most:g}{where}" if value > most else f"least {least:g}"
                raise InputError(f"`{name}` must be at {limit}, got {exact(value)}")
        given = dict(self.spreads or {})
        spread = {name: positive(f"spreads[{name!r}]", value) for name, value in given.items()}
        if unknown := set(spread) - set(_SPREAD):
            raise InputError(
                f"`spreads` must name some of {', '.join(_SPREAD)}, got {show(unknown.pop())}"
            )
        assign(self, spreads=MappingProxyType(spread), **checked)
        checked_direction(self, self.direction)
        self._check_range()
        numbers, form = self._numbers, self._shape
        length = self._rms / self._stiffness  # p/k
        self._set_curve(
            self.pair,
            float(numbers.separation[0]) * self._rms + form.distance * length,
            form.share,
            self._heaviest,
            1.0 / length,
        )

    def _check_range(self) -> None:
        if self.slope > STEEPEST:
            raise InputError(
                f"`slope` must be the tangent Rdq of profiles, at most {STEEPEST:g}, got "
                f"{exact(self.slope)}; a slope in degrees must be written as its tangent"
            )
        hardness, modulus = self.hardness, self.pair.composite_modulus
        if 0.1 * modulus < hardness < 10.0 * modulus:
            raise InputError(
                f"`hardness` must be at most a tenth of the modulus E*, {0.1 * modulus:.3g} Pa, "
                f"as that of all metals, got {exact(hardness)}; write 1e15 for an elastic face"
            )
        if self.rms > HIGHEST:
            raise InputError(
                f"`rms` must be at most {HIGHEST:g} m, more than any machined face has, got "
                f"{exact(self.rms)} m; check its unit, or remove form and waviness"
            )
        share = self.tightening_pressure / hardness
        most = table.TIGHTENED[1]
        if share > most * (1.0 + 1e-9):
            raise InputError(
                f"`tightening_pressure` must be at most {most:g} of the hardness "
                f"{hardness:.4g} Pa, the largest of the solved faces, got "
                f"{exact(self.tightening_pressure)} Pa; use a larger area or a harder material"
            )
        limit = table.PRESSURE_END * modulus * self.gradient
        if self.tightening_pressure > limit * (1.0 + 1e-9):
            raise InputError(
                f"`tightening_pressure` must be at most {limit:.4g} Pa, {table.PRESSURE_END:g} of "
                "E* times the rms gradient, beyond which nearly all of the face touches, got "
                f"{exact(self.tightening_pressure)} Pa; check `slope`, or lower the pressure"
            )

    @classmethod
    def from_finish(
        cls,
        pair: MaterialPair,
        *finishes: Finish,
        area: float,
        tightening_pressure: float,
        **options: Any,
    ) -> DrawnFace:
        """Return the law of a rough face on a smooth one, or of two rough faces.

        Parameters
        ----------
        pair : MaterialPair
            The two materials.
        *finishes : Finish
            Roughness of one or both faces, combined as roots of sums of squares.
        area : float
            Apparent area [m^2].
        tightening_pressure : float
            Largest mean pressure on the face so far [Pa].
        **options
            Further arguments of the class; given ``spreads`` replace those of the finishes.

        Raises
        ------
        InputError
            If there are not one or two finishes, or a number is out of range.
        """
        if not 1 <= len(finishes) <= 2 or not all(isinstance(f, Finish) for f in finishes):
            raise InputError(
                "one or two ms.Finish must be given, such as ms.Finish(ra=0.8e-6), got "
                f"{show(finishes)}"
            )
        rms, slope = finishes[0].rms, finishes[0].slope
        if len(finishes) == 2:
            rms, slope = combined(rms, finishes[1].rms), combined(slope, finishes[1].slope)
        known = {"rms": rms.spread, "slope": slope.spread}
        spreads = {name: spread for name, spread in known.items() if spread > 0.0}
        options["spreads"] = spreads | dict(options.get("spreads") or {})
        return cls(pair, rms.middle, slope.middle, area, tightening_pressure, **options)

    def along(self, direction: float | None) -> DrawnFace:
        """Return a copy for motion at an angle [rad] to the lay normal; None averages all."""
        return replace(self, direction=direction)

    def _patch(self, area: float, tightening: float) -> NormalLaw:
        pressure = tightening * self.tightening_pressure
        return replace(self, area=area, tightening_pressure=pressure)

    def _under(self, load: float) -> NormalLaw:
        if load <= self._heaviest * (1.0 + 1e-9):
            return self
        return replace(self, tightening_pressure=load / self.area)

    def _length_factors(self, shares: Floats) -> Floats:
        h, pi, breadth = self._groups
        found = table.continued(np.full(shares.size, h), pi * shares, breadth)
        return np.asarray(float(self._numbers.stiffness[0]) / found.stiffness)

    @property
    def hardness(self) -> float:
        """Hardness of the softer body [Pa]."""
        assert self.pair.hardness is not None
        return self.pair.hardness

    @property
    def gradient(self) -> float:
        """Rms gradient h' [-] of the part of the gap that carries load."""
        along = 1.0 if self.lay is None else self.lay
        return self.slope * math.hypot(1.0, along) * self._rms / self.rms

    @property
    def _rms(self) -> float:
        """Rms height [m] of the part of the gap that carries load."""
        return self.rms if self.plateau is None else self.plateau

    @property
    def _wave(self) -> float:
        """Wavelength [m] of the mean wavenumber of the spectrum."""
        return 2.0 * math.pi * self._rms / (self._groups[2] * self.gradient)

    @property
    def _tightening(self) -> float:
        return self.tightening_pressure

    @cached_property
    def _groups(self) -> tuple[float, float, float]:
        """Groups h = H/(E* h'), P = p/(E* h') and breadth, see :mod:`.face_table`."""
        stiff = self.pair.composite_modulus * self.gradient
        h = min(self.hardness / stiff, table.HARDNESS_RANGE[1])
        breadth = table.BREADTH[1] if self.breadth is None else self.breadth
        return h, self.tightening_pressure / stiff, breadth

    @cached_property
    def _numbers(self) -> table.NodeValues:
        h, pi, breadth = self._groups
        return table.continued(np.array([h]), np.array([pi]), breadth)

    @property
    def _stiffness(self) -> float:
        """Dimensionless unloading stiffness k_n Rq/p at the tightening pressure [-]."""
        return float(self._numbers.stiffness[0]) * self.stiffness_factor

    @cached_property
    def _shape(self) -> table.CurveShape:
        return table.shape(self._numbers.bends[0], self.shape_factor)

    @cached_property
    def slip_length(self) -> float:
        """Pressure over normal stiffness per area, p/k_n [m], at the tightening pressure.

        Multiplied by mu k_n/k_t it is mu p/k_t, the displacement at which a linear joint slips.
        """
        return self._rms / self._stiffness

    @cached_property
    def first_loading(self) -> FirstLoading:
        """First-loading curve from 0.1 % of the tightening pressure to that pressure."""
        h, pi, breadth = self._groups
        p = np.geomspace(1e-3, 1.0, _LOADINGS)
        found = table.continued(np.full(p.size, h), pi * p, breadth)
        pressure = self.tightening_pressure * p
        stiffness = self.stiffness_factor * found.loading * pressure * (self.area / self._rms)
        return FirstLoading(pressure, self._rms * found.separation, stiffness)

    @property
    def _slopes(self) -> tuple[float, float]:
        """Slopes of profiles across and along the lay over the sum of both [-]."""
        along = 1.0 if self.lay is None else self.lay
        return 1.0 / (1.0 + along), along / (1.0 + along)

    @cached_property
    def _tangential(self) -> Floats:
        a = 2.0 * self.pair.stiffness_ratio - 1.0
        return lock(np.diag([1.0 / (a - (a - 1.0) * c) for c in self._slopes]))

    def contact_area(self, separation: ArrayLike) -> Any:
        """Real contact area [m^2] at separations [m] of any shape.

        Like ``slope``, it depends on the short-wave cut-off.
        """
        loads = np.asarray(self.load(separation), dtype=float) / self._heaviest
        at = np.log(table.FRACTIONS[::-1])
        shares = self._numbers.contacts[0, ::-1]
        with np.errstate(divide="ignore"):
            x = np.log(np.minimum(loads, 1.0))
        # Below the lightest load of the table the area falls with the load.
        inside = np.interp(x, np.append(at, 0.0), np.append(shares, 0.0))
        inside = inside + np.minimum(x - at[0], 0.0)
        return plain(np.asarray(self.area * float(self._numbers.contact[0]) * np.exp(inside)))

    def scatter(self, size: float) -> float:
        """Return the standard deviation of ln k_n between square patches of one face [-].

        Parameters
        ----------
        size : float
            Side of a patch [m].
        """
        size = positive("size", size, "m", 5e-3)
        # Of Rq itself, and of k_n Rq/p; 2.1 is the roll-off over the mean wavelength (Hurst 0.7).
        share = max(self.tightening_pressure / self.hardness, 1e-4)
        across = 2.1 * self._wave / size
        # Waves are longer along the lay, but a patch has at least one row of them.
        along = min(across / (self.lay or 1.0), max(across, 1.0))
        return math.sqrt(across * along) * math.hypot(0.16, 0.045 * share**-0.42)

    @cached_property
    def sensitivities(self) -> dict[str, float]:
        """Derivatives d ln k_n/d ln x [-], by the name of the input x."""
        h, pi, breadth = self._groups
        up, down = math.exp(_STEP), math.exp(-_STEP)
        n = np.array([h * up, h * down, h, h])
        p = np.array([pi * up, pi * down, pi * up, pi * down])
        found = np.log(table.continued(n, p, breadth).stiffness)
        by_both = float(found[0] - found[1]) / (2.0 * _STEP)  # h and pi rise as E* h' falls
        by_pressure = float(found[2] - found[3]) / (2.0 * _STEP)
        return {
            "rms": -1.0,
            "slope": -by_both,
            "hardness": by_both - by_pressure,
            "young_modulus": -by_both,
            "tightening_pressure": 1.0 + by_pressure,
        }

    @cached_property
    def errors(self) -> FaceErrors:
        """Standard deviations of ln k_n [-] due to table, limited area and inputs."""
        slopes = self.sensitivities
        parts = [slopes[name] * spread for name, spread in self.spreads.items()]
        if self.breadth is None:
            h, pi, middle = self._groups
            ends = [
                float(np.log(table.continued(np.array([h]), np.array([pi]), b).stiffness[0]))
                for b in (middle * math.exp(-_BREADTH_SPREAD), middle * math.exp(_BREADTH_SPREAD))
            ]
            parts.append(0.5 * (ends[1] - ends[0]))
        realisation = self.scatter(math.sqrt(self.area))
        return FaceErrors(STIFFNESS_ERROR, realisation, math.hypot(*parts))

    def drawn(self, random: np.random.Generator) -> DrawnFace:
        """Draw a random face from the spreads of the inputs and the errors of the table.

        Parameters
        ----------
        random : numpy.random.Generator
            Source of random numbers.

        Returns
        -------
        DrawnFace
            A face without spreads. The inputs are drawn from independent log-normal distributions
            and clipped to the range of the table. The median of its shape factor is 1.22 times that
            of this face, as for machined faces.
        """
        scale = {
            name: math.exp(self.spreads.get(name, 0.0) * random.standard_normal())
            for name in _SPREAD
        }
        changes: dict[str, Any] = {
            name: getattr(self, name) * scale[name]
            for name in ("rms", "slope", "tightening_pressure")
        }
        if self.plateau is not None:
            changes["plateau"] = self.plateau * scale["rms"]
        changes["slope"] = min(changes["slope"], STEEPEST)
        hardness = self.hardness * scale["hardness"]
        if self.breadth is None:
            low, middle, high = table.BREADTH
            wanted = middle * math.exp(_BREADTH_SPREAD * random.standard_normal())
            changes["breadth"] = min(max(wanted, low), high)
        error = math.hypot(STIFFNESS_ERROR, self.scatter(math.sqrt(self.area)))
        changes["stiffness_factor"] = self.stiffness_factor * math.exp(
            error * random.standard_normal()
        )
        changes["shape_factor"] = (
            self.shape_factor * SHAPE_FACTOR * math.exp(SHAPE_ERROR * random.standard_normal())
        )
        gradient = self.gradient * changes["slope"] / self.slope
        changes["tightening_pressure"] = min(
            changes["tightening_pressure"],
            table.TIGHTENED[1] * hardness,
            table.PRESSURE_END * self.pair.composite_modulus * gradient,
        )
        if self.lay is None:
            changes["lay"] = math.exp(-abs(random.standard_normal()))
            # The gradient is known by its slope; only the shares of the directions are not.
            changes["slope"] *= math.sqrt(2.0) / math.hypot(1.0, changes["lay"])
        return replace(self, pair=self.pair.with_hardness(hardness), spreads={}, **changes)

    def _assumptions(self, separation: float | None) -> dict[str, float | None]:
        return {
            OVER_HARDNESS: self.tightening_pressure / self.hardness,
            "hardness over modulus and slope": self._groups[0],
        }

    def _standardised(self, separation: float) -> float | None:
        return separation / self._rms

    def __repr__(self) -> str:
        return (
            f"DrawnFace(rms={self.rms:g}, slope={self.slope:g}, area={self.area:g}, "
            f"tightening_pressure={self.tightening_pressure:g}, hardness={self.hardness:g}, "
            f"plateau={self.plateau}, breadth={self.breadth}, lay={self.lay}, "
            f"direction={self.direction})"
        )

    @classmethod
    @cache
    def examples(cls) -> tuple[NormalLaw, ...]:
        """Return a ground aluminium face, and a face with a lay and motion across it."""
        metal = aluminium().with_hardness(1.2e9)
        return (
            cls(metal, 4e-7, 0.1, 1e-4, 3e7),
            cls(metal, 1.6e-6, 0.2, 1e-4, 1e8, lay=0.3, direction=0.0),
        )


_SPREAD = ("rms", "slope", "hardness", "tightening_pressure")
