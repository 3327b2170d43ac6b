"""Floor 8: many loads, amplitudes and coefficients of friction at once, as labelled arrays."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microslip._checks import LARGEST, SMALLEST, Floats, exact, floats, show
from microslip._frozen import lock
from microslip._netcdf import Variable
from microslip._netcdf import write as write_netcdf
from microslip._version import __version__
from microslip.errors import InputError
from microslip.friction import BackboneLaw, Interface
from microslip.normal.grids import inverse_on_grid, on_grid, separations

if TYPE_CHECKING:
    import xarray

Progress = Callable[[float], None]

_GRID = ("friction_coefficient", "normal_load", "amplitude")
_LOAD = ("normal_load",)
_BOTH = ("friction_coefficient", "normal_load")
_ABOUT: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "amplitude": ("m", "displacement amplitude", _GRID),
    "force_amplitude": ("N", "force amplitude", _GRID),
    "dissipated_energy": ("J", "energy dissipated in a closed cycle", _GRID),
    "energy_ratio": ("1", "energy ratio of the interface", _GRID),
    "loss_factor": ("1", "loss factor of the interface", _GRID),
    "damping_ratio": ("1", "equivalent viscous damping ratio of the interface", _GRID),
    "secant_stiffness": ("N/m", "secant stiffness", _GRID),
    "tangent_stiffness": ("N/m", "tangent stiffness of the first loading curve", _GRID),
    "dissipation_exponent": ("1", "local exponent of the energy over the amplitude", _GRID),
    "stick_area": ("m^2", "contact area that still sticks on first loading", _GRID),
    "separation": ("m", "separation of the mean planes", _LOAD),
    "normal_stiffness": ("N/m", "normal stiffness", _LOAD),
    "tangential_stiffness": ("N/m", "tangential stiffness at rest", _LOAD),
    "contact_count": ("1", "summits in contact", _LOAD),
    "contact_area": ("m^2", "real contact area", _LOAD),
    "force_limit": ("N", "force of gross slip", _BOTH),
    "slip_per_indentation": ("1", "slip limit of a contact over its indentation", _GRID[:1]),
}
_COORDINATES = {
    "friction_coefficient": ("1", "coefficient of friction"),
    "normal_load": ("N", "normal load"),
    "amplitude": ("m", "displacement amplitude"),
    "force_amplitude": ("N", "force amplitude"),
}
_DEFAULT = ("dissipated_energy", "loss_factor", "damping_ratio", "secant_stiffness")
_BLOCK = 20_000  # lines of a table at a time


@dataclass(frozen=True, eq=False)
class Sweep:
    """Arrays with names, dimensions and coordinates, as :func:`microslip.sweep` makes them.

    Parameters
    ----------
    coords : mapping of str to Variable
        Coordinates by name: along a dimension of that name, or one number.
    variables : mapping of str to Variable
        Results by name. A Variable is a tuple of ``dims``, ``values`` and ``attributes`` (units
        and what it is).
    attributes : mapping of str to str
        What was swept, and with which version.

    Raises
    ------
    InputError
        A name that is not there; a file that is.

    Notes
    -----
    What an interface says of itself, for many at once: ``loss_factor`` is (19.30), and none of the
    damping ratios is that of a mode, see :class:`microslip.Oscillator`.
    """

    coords: Mapping[str, Variable]
    variables: Mapping[str, Variable]
    attributes: Mapping[str, str]

    def __post_init__(self) -> None:
        for name in ("coords", "variables", "attributes"):
            object.__setattr__(self, name, MappingProxyType(dict(getattr(self, name))))
        for variable in (*self.coords.values(), *self.variables.values()):
            lock(variable.values)

    def __getstate__(self) -> dict[str, Any]:
        return {name: dict(getattr(self, name)) for name in ("coords", "variables", "attributes")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()

    @property
    def sizes(self) -> dict[str, int]:
        """Lengths of the dimensions by name, in their order."""
        return {
            name: variable.values.size for name, variable in self.coords.items() if variable.dims
        }

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, in the order that all arrays have them in."""
        return tuple(self.sizes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.sizes.values())

    def __getitem__(self, name: str) -> Any:
        """Values of a variable or a coordinate; a float where it has no dimension."""
        for group in (self.variables, self.coords):
            if isinstance(name, str) and name in group:
                values = group[name].values
                return float(values) if values.ndim == 0 else values
        known = ", ".join((*self.variables, *self.coords))
        raise InputError(f"name must be one of {known}, got {show(name)}")

    def __contains__(self, name: object) -> bool:
        return name in self.variables or name in self.coords

    def __iter__(self) -> Iterator[str]:
        return iter(self.variables)

    def __len__(self) -> int:
        return len(self.variables)

    def __repr__(self) -> str:
        lines = [f"Sweep({', '.join(f'{name}: {size}' for name, size in self.sizes.items())})"]
        width = max(len(name) for name in (*self.coords, *self.variables))
        for head, group in (("coordinates", self.coords), ("variables", self.variables)):
            lines.append(f"  {head}")
            for name, (dims, values, about) in group.items():
                low, high = _range(values)
                span = f"{low:g}" if low == high or values.ndim == 0 else f"{low:g} … {high:g}"
                over = f"({', '.join(dims)})" if dims else ""
                lines.append(f"    {name:<{width}}  {span} [{about['units']}] {over}".rstrip())
        return "\n".join(lines)

    def to_xarray(self) -> xarray.Dataset:
        """The same as an ``xarray.Dataset``.

        Raises
        ------
        InputError
            xarray is not installed.
        """
        try:
            import xarray
        except ImportError:
            raise InputError(
                'to_xarray needs xarray, which is not installed: pip install "microslip[xarray]"; '
                "to_netcdf(...) and to_csv(...) need nothing more"
            ) from None
        variables, coords = (
            {name: (v.dims, v.values, dict(v.attributes)) for name, v in group.items()}
            for group in (self.variables, self.coords)
        )
        return xarray.Dataset(variables, coords, attrs=dict(self.attributes))

    def to_netcdf(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write one netCDF-4 file, whole or not at all.

        Parameters
        ----------
        path : str or pathlib.Path
            The file to make.
        overwrite : bool, optional
            Whether a file in its place may be replaced.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        InputError
            The file is there already, or it cannot be written.
        """
        with _whole(path, overwrite) as stage:
            write_netcdf(stage, self.sizes, self.coords, self.variables, self.attributes)
        return Path(path)

    def to_csv(self, path: str | Path, overwrite: bool = False) -> Path:
        """Write one table, whole or not at all: a line a point, coordinates first, in SI units.

        Parameters and errors as :meth:`to_netcdf`; numbers read back bit for bit.
        """
        shape = self.shape
        columns = {}
        for name, (dims, values, about) in {**self.coords, **self.variables}.items():
            places = [slice(None) if dim in dims else None for dim in self.dims]
            whole = np.broadcast_to(values[tuple(places)] if self.dims else values, shape)
            unit = "-" if about["units"] == "1" else about["units"]
            columns[f"{name} [{unit}]"] = whole.reshape(-1)
        count = math.prod(shape)
        with (
            _whole(path, overwrite) as stage,
            stage.open("w", encoding="utf-8", newline="") as file,
        ):
            file.write(",".join(columns) + "\n")
            for start in range(0, count, _BLOCK):
                # repr is the shortest text that reads back as the same double.
                texts = [map(repr, c[start : start + _BLOCK].tolist()) for c in columns.values()]
                file.writelines(",".join(row) + "\n" for row in zip(*texts, strict=True))
        return Path(path)


def _range(values: NDArray[Any]) -> tuple[float, float]:
    known = values[np.isfinite(values)]
    return (float(known.min()), float(known.max())) if known.size else (math.nan, math.nan)


@contextmanager
def _whole(path: str | Path, overwrite: bool) -> Iterator[Path]:
    """A name beside the file to be, which takes its place when all has gone well."""
    target = Path(path)
    try:
        if target.is_dir() or (target.exists() and not overwrite):
            what = "is a folder" if target.is_dir() else "exists; replace it with overwrite=True"
            raise InputError(f"{target}: {what}")
        handle, name = tempfile.mkstemp(prefix=f".{target.name[:100]}.", dir=target.parent)
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{target}: cannot be written: {_reason(error)}") from None
    os.close(handle)
    stage = Path(name)
    try:
        stage.unlink()  # the writer makes it anew, with the permissions of a new file
        yield stage
        if overwrite:
            stage.replace(target)
        else:
            _claim(stage, target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {_reason(error)}") from error
    finally:
        stage.unlink(missing_ok=True)


def _claim(stage: Path, target: Path) -> None:
    """Give the file its name, unless somebody was quicker."""
    try:
        os.link(stage, target)
    except FileExistsError:
        raise InputError(f"{target}: exists; replace it with overwrite=True") from None
    except OSError:  # a file system without links
        if target.exists():
            raise InputError(f"{target}: exists; replace it with overwrite=True") from None
        stage.rename(target)


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()


# -- the sweep -------------------------------------------------------------------------------------


def sweep(
    joint: BackboneLaw,
    *,
    normal_load: ArrayLike | None = None,
    amplitude: ArrayLike | None = None,
    force_amplitude: ArrayLike | None = None,
    friction_coefficient: ArrayLike | None = None,
    quantities: Sequence[str] | None = None,
    progress: Progress | None = None,
) -> Sweep:
    """One joint at many loads, amplitudes and coefficients of friction, as labelled arrays.

    Parameters
    ----------
    joint : BackboneLaw
        An :class:`microslip.Interface`; any other law has amplitudes only.
    normal_load : array_like, optional
        Normal loads [N], above zero, one-dimensional; without them that of the joint.
    amplitude : array_like, optional
        Displacement amplitudes [m], not negative, one-dimensional.
    force_amplitude : array_like, optional
        Force amplitudes [N] instead, below the force limit at every load.
    friction_coefficient : array_like, optional
        Coefficients of friction [-], above zero, one-dimensional; without them that of the joint.
    quantities : sequence of str, optional
        What is wanted, by the names that an interface has it by: force_amplitude (or amplitude),
        dissipated_energy, energy_ratio, loss_factor, damping_ratio, secant_stiffness,
        tangent_stiffness, dissipation_exponent, stick_area; and, without amplitudes, separation,
        normal_stiffness, tangential_stiffness, contact_count, contact_area, force_limit,
        slip_per_indentation. Without it the other amplitude, dissipated_energy, loss_factor,
        damping_ratio and secant_stiffness.
    progress : callable, optional
        Called now and then with the share that is done, 0 … 1.

    Returns
    -------
    Sweep
        Each list is a dimension, in the order friction_coefficient, normal_load, amplitude; a
        number, or what was not given, is a coordinate without one.

    Raises
    ------
    InputError
        Both or neither of the amplitudes; values out of their range; a quantity that is unknown, or
        that the law does not know; loads that the surface cannot carry.

    Notes
    -----
    The same numbers as of one interface after the other, to rounding (1e-13), but not one after
    the other: separations are found together, and (19.29) is integrated for many loads at once, or
    tabulated along whichever of loads and amplitudes there is more of.
    """
    if not isinstance(joint, BackboneLaw):
        raise InputError(
            f"joint must be an Interface or another backbone law, got {show(joint)}; "
            "write sweep(joint, normal_load=[...], amplitude=[...])"
        )
    if (amplitude is None) == (force_amplitude is None):
        came = "neither" if amplitude is None else "both"
        raise InputError(
            "amplitude=[...] [m] or force_amplitude=[...] [N] must be given, one of them, "
            f"got {came}"
        )
    name, given = "amplitude", amplitude
    if given is None:
        name, given = "force_amplitude", force_amplitude
    along = _axis(name, given)
    if along.min() < 0.0:
        raise InputError(f"{name} must not be negative, got {along.min():g}")
    wanted = _wanted(quantities, name)
    if progress is not None and not callable(progress):
        raise InputError(f"progress must be a function of the share done, got {show(progress)}")
    axes = {name: np.abs(along)}  # -0.0 is 0.0 here
    if not isinstance(joint, Interface):
        for other, value in (
            ("friction_coefficient", friction_coefficient),
            ("normal_load", normal_load),
        ):
            if value is not None:
                raise InputError(
                    f"{other} has no meaning for {type(joint).__name__}, "
                    "only an Interface has one; sweep its amplitudes alone"
                )
        values = _of_law(joint, axes, wanted)
        if progress is not None:
            progress(1.0)
        return _labelled(joint, axes, values, name)
    friction = joint.friction_coefficient if friction_coefficient is None else friction_coefficient
    load = joint.normal_load if normal_load is None else normal_load
    axes = {
        "friction_coefficient": _positive_axis("friction_coefficient", friction, ""),
        "normal_load": _positive_axis("normal_load", load, " [N]"),
        **axes,
    }
    return _labelled(joint, axes, _Grid(joint, axes, name, progress).values(wanted), name)


def _axis(name: str, value: Any) -> Floats:
    array = floats(name, value)
    if array.ndim > 1:
        raise InputError(f"{name} must be a number or one-dimensional, got shape {array.shape}")
    return array.copy()


def _positive_axis(name: str, value: Any, unit: str) -> Floats:
    array = _axis(name, value)
    least, most = float(array.min()), float(array.max())
    if least <= 0.0:
        raise InputError(f"{name} must be above zero{unit}, got {exact(least)}")
    if not (least >= SMALLEST and most <= LARGEST):
        worst = most if most > LARGEST else least
        raise InputError(
            f"{name} must be between {SMALLEST:g} and {LARGEST:g}{unit}, got {exact(worst)}"
        )
    return array


def _wanted(quantities: Any, name: str) -> tuple[str, ...]:
    other = "force_amplitude" if name == "amplitude" else "amplitude"
    if quantities is None:
        return (other, *_DEFAULT)
    known = [quantity for quantity in _ABOUT if quantity != name]
    if isinstance(quantities, str) or not isinstance(quantities, Sequence) or not quantities:
        raise InputError(
            f"quantities must be a list of names, got {show(quantities)}; "
            'for example quantities=["dissipated_energy"]'
        )
    for quantity in quantities:
        if quantity == name:
            raise InputError(f"quantities must not name {name}: it is a coordinate already")
        if quantity not in known:
            raise InputError(f"quantities must be of {', '.join(known)}, got {show(quantity)}")
    if len(set(quantities)) < len(quantities):
        twice = next(q for q in quantities if list(quantities).count(q) > 1)
        raise InputError(f"quantities must name each once, got {twice} twice")
    return tuple(quantities)


def _labelled(
    joint: BackboneLaw, axes: Mapping[str, Floats], values: Mapping[str, Floats], along: str
) -> Sweep:
    coords = {}
    for name, axis in axes.items():
        units, text = _COORDINATES[name]
        dims: tuple[str, ...] = (name,) if axis.ndim else ()
        coords[name] = Variable(dims, axis, {"units": units, "long_name": text})
    variables = {}
    for name, array in values.items():
        units, text, grid = _ABOUT[name]
        over = [along if dim == "amplitude" else dim for dim in grid]
        dims = tuple(dim for dim in over if dim in axes and axes[dim].ndim)
        # Of an axis that was one number there is no dimension.
        shape = tuple(axes[dim].size for dim in dims)
        variables[name] = Variable(
            dims, np.ascontiguousarray(array).reshape(shape), {"units": units, "long_name": text}
        )
    about = {
        "Conventions": "CF-1.11",
        "title": "Sweep of a joint",
        "source": f"microslip {__version__}",
        "joint": repr(joint),
    }
    return Sweep(coords, variables, about)


def _of_law(
    joint: BackboneLaw, axes: Mapping[str, Floats], wanted: Sequence[str]
) -> dict[str, Floats]:
    """What a law without a load says of its amplitudes."""
    given = {name: axis.reshape(-1) for name, axis in axes.items()}
    a = joint._amplitudes(given.get("amplitude"), given.get("force_amplitude"))
    calls: dict[str, Callable[[], Any]] = {
        "amplitude": lambda: a,
        "force_amplitude": lambda: joint.backbone(a),
        "tangent_stiffness": lambda: joint.backbone_stiffness(a),
        "force_limit": lambda: joint.force_limit,
        "tangential_stiffness": lambda: joint.tangential_stiffness,
    }
    for name in (
        "dissipated_energy",
        "energy_ratio",
        "loss_factor",
        "damping_ratio",
        "secant_stiffness",
        "dissipation_exponent",
    ):
        calls[name] = partial(getattr(joint, name), a)
    for name in wanted:
        if name not in calls:
            raise InputError(
                f"quantities must be what {type(joint).__name__} knows, which has no {name}"
            )
    return {name: np.asarray(calls[name](), dtype=float) for name in wanted}


class _Grid:
    """An interface on the grid of coefficients, loads and amplitudes (i, j, k)."""

    def __init__(
        self, joint: Interface, axes: Mapping[str, Floats], name: str, progress: Progress | None
    ) -> None:
        self.surface = joint.surface
        self.friction = axes["friction_coefficient"].reshape(-1)
        self.load = axes["normal_load"].reshape(-1)
        self.given = axes[name].reshape(-1)
        self.by_force = name == "force_amplitude"
        if np.all(self.load == joint.normal_load):
            # Of a joint that was given by its separation that very one.
            self.separation = np.full(self.load.size, joint.separation)
        else:
            self.separation = separations(self.surface, self.load)
        self.kappa = self.friction * self.surface.pair.stiffness_ratio
        self.limit = self.friction[:, None] * self.load
        # As in an interface: with it the limit is met exactly.
        self.factor = self.limit / self.surface._derivative(self.separation, 0)
        self.done = 0
        self.passes = 1
        self.progress = progress

    def values(self, wanted: Sequence[str]) -> dict[str, Floats]:
        """All that is wanted, by name."""
        needed = set(wanted)
        ratios = needed & {"energy_ratio", "loss_factor", "damping_ratio"}
        backbone = bool(ratios or needed & {"force_amplitude", "secant_stiffness"})
        energy = bool(ratios or needed & {"dissipated_energy", "dissipation_exponent"})
        self.passes = (
            self.by_force
            + (backbone and not self.by_force)
            + energy
            + len(needed & {"dissipation_exponent", "tangent_stiffness"})
        ) or 1
        if self.by_force:
            self.amplitude = self._amplitudes()
            force = np.broadcast_to(self.given, self.amplitude.shape)
        else:
            shape = self.friction.size, self.load.size, self.given.size
            self.amplitude = np.broadcast_to(self.given, shape)
            if backbone:
                force = np.minimum(
                    self.factor[..., None] * self._sum("drop"), self.limit[..., None]
                )
        a = self.amplitude
        if energy:
            lost = 8.0 * (self.factor * self.kappa[:, None])[..., None] * self._sum("excess")
        result: dict[str, Floats] = {}
        for name in wanted:
            if name == "amplitude":
                result[name] = a
            elif name == "force_amplitude":
                result[name] = force
            elif name == "dissipated_energy":
                result[name] = lost
            elif name in ratios:
                box = 4.0 * a * force
                ratio = np.divide(lost, box, out=np.zeros(a.shape), where=box > 0.0)
                scale = {"energy_ratio": 1.0, "loss_factor": 4.0, "damping_ratio": 2.0}[name]
                result[name] = ratio if scale == 1.0 else scale / math.pi * ratio
            elif name == "secant_stiffness":
                rest = np.broadcast_to(self._held()[:, None], a.shape).copy()
                result[name] = np.divide(force, a, out=rest, where=a > 0.0)
            elif name == "dissipation_exponent":
                result[name] = self._exponent(lost)
            elif name == "tangent_stiffness":
                slope = (self.factor / self.kappa[:, None])[..., None]
                result[name] = slope * self._sum("fall")
            else:
                result[name] = self._scalar(name)
        if self.progress is not None:
            self.progress(1.0)
        return result

    def _scalar(self, name: str) -> Floats:
        if name == "separation":
            return self.separation
        if name == "normal_stiffness":
            return np.asarray(self.surface.stiffness(self.separation))
        if name == "tangential_stiffness":
            return self._held()
        if name == "force_limit":
            return self.limit
        if name == "slip_per_indentation":
            return self.kappa
        if name == "stick_area":
            steps = np.minimum(self.amplitude, 1e200) / self.kappa[:, None, None]
            return np.asarray(self.surface.contact_area(self.separation[:, None] + steps))
        return np.asarray(getattr(self.surface, name)(self.separation))

    def _held(self) -> Floats:
        return np.asarray(
            self.surface.stiffness(self.separation) / self.surface.pair.stiffness_ratio
        )

    def _report(self, share: float) -> None:
        if self.progress is not None:
            self.progress(min((self.done + share) / self.passes, 1.0))

    def _sum(self, kind: Any) -> Floats:
        """A sum of the normal law over the whole grid."""
        if self.by_force:
            steps = np.minimum(self.amplitude, 1e200) / self.kappa[:, None, None]
            rows = np.tile(self.separation, self.friction.size)
            flat = on_grid(self.surface, kind, rows, steps.reshape(rows.size, -1), self._report)
            result = flat.reshape(self.amplitude.shape)
        else:
            # All loads share the steps, those of every coefficient of friction side by side.
            steps = np.minimum(self.given, 1e200) / self.kappa[:, None]
            flat = on_grid(self.surface, kind, self.separation, steps.reshape(-1), self._report)
            result = np.moveaxis(flat.reshape(self.load.size, *steps.shape), 0, 1)
        self.done += 1
        return result

    def _amplitudes(self) -> Floats:
        """Displacement amplitudes that belong to the given forces."""
        i, j = np.unravel_index(int(np.argmin(self.limit)), self.limit.shape)
        most = float(self.given.max())
        if most >= self.limit[i, j]:
            raise InputError(
                f"force_amplitude must stay below the force limit at every load, and at "
                f"{exact(self.load[j])} N it is {self.limit[i, j]:.10g} N; got {most:.10g} N"
            )
        drops = self.given / self.factor[..., None]
        rows = np.tile(self.separation, self.friction.size)
        steps = inverse_on_grid(self.surface, drops.reshape(rows.size, -1), rows, self._report)
        self.done += 1
        return np.asarray(self.kappa[:, None, None] * steps.reshape(drops.shape))

    def _exponent(self, lost: Floats) -> Floats:
        slope = 8.0 * self.factor[..., None] * self._sum("excess_slope")
        nothing = np.full(lost.shape, np.nan)
        exponent = np.divide(self.amplitude * slope, lost, out=nothing, where=lost > 0.0)
        # Where the energy underflows the limit of small amplitudes holds, if there is one.
        bends = self.surface._derivative(self.separation, 2) > 0.0
        return np.where(np.isnan(exponent) & bends[:, None], 3.0, exponent)
