"""Quantities with a unit at every public entrance: converted, or refused, but never stripped."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from attack.entrances import entrances

import microslip as ms

pint = pytest.importorskip("pint")
REGISTRY = pint.UnitRegistry()
JOINT = ms.Interface.examples()[0]

# Another unit for each argument of laws, joints, fields, states and records.
UNITS = {
    "um": ("displacement", "displacement_cycle", "displacements", "amplitude", "separation",
           "separations", "gaps", "rest", "radius", "std", "radii", "start", "coefficients"),
    "kN": ("force", "force_amplitude", "peak_force", "normal_load", "loads", "force_limit",
           "force_limits"),
    "N/um": ("stiffness", "stiffnesses"),
    "MPa": ("young_modulus", "pressures"),
    "mm^2": ("area", "areas", "surface_area"),
    "1/mm^2": ("density",),
}  # fmt: skip
SI = {"um": "m", "kN": "N", "N/um": "N/m", "MPa": "Pa", "mm^2": "m^2", "1/mm^2": "1/m^2"}
UNIT_OF = {name: unit for unit, names in UNITS.items() for name in names}
# Derivatives take changes per parameter, structures matrices and records in units of their own, and
# these two take densities of other kinds: they refuse quantities.
REFUSED = ("derivative", "Structure", "Preload", "ModalTest", "ForcedResponse", "ReducedJoint",
           "Pulse", "LapJoint", "BoltedBeam", "TabulatedHeights", "MeasuredContact",
           "Summits", "fixing_mass")  # fmt: skip


groups = pytest.mark.parametrize("group", ["joints", pytest.param("all", marks=pytest.mark.slow)])


def is_number(value: Any) -> bool:
    try:
        return np.asarray(value).dtype.kind in "iuf"
    except Exception:
        return False


def numeric_arguments(group: str) -> Iterator[Any]:
    for name, entrance in entrances().items():
        if group == "joints" and not name.startswith(("joint", "field", "Interface", "plane")):
            continue
        for key in entrance.numeric:
            if is_number(entrance.arguments[key]):
                yield name, key


def called(name: str, **changed: Any) -> Any:
    entrance = entrances()[name]
    with warnings.catch_warnings():
        warnings.simplefilter("error", pint.UnitStrippedWarning)
        return entrance.call(**{**entrance.arguments, **changed})


def quantity(name: str, key: str, unit: str) -> Any:
    value = np.asarray(entrances()[name].arguments[key])
    return REGISTRY.Quantity(float(value) if value.ndim == 0 else value, unit)


def numbers_of(result: Any) -> Any:
    """Return all numbers of a result in one array."""
    if isinstance(result, (float, np.ndarray)):
        return np.ravel(result)
    if isinstance(result, Mapping):
        result = tuple(result.values())
    parts = result if isinstance(result, tuple) else getattr(result, "__dict__", {}).values()
    own = (tuple, float, np.ndarray, Mapping)
    return np.concatenate([np.zeros(0), *(numbers_of(p) for p in parts if isinstance(p, own))])


@groups
def test_no_entrance_strips_a_unit(group: str) -> None:
    """Luminous intensity is the unit of no argument."""
    stripped, arguments = [], list(numeric_arguments(group))
    for name, key in arguments:
        try:
            called(name, **{key: quantity(name, key, "candela")})
        except ms.InputError:
            continue
        stripped.append((name, key))
    assert not stripped
    assert len(arguments) > (80 if group == "joints" else 500)


@groups
def test_entrances_of_joints_convert_units(group: str) -> None:
    done = 0
    for name, key in numeric_arguments(group):
        if key not in UNIT_OF or any(word in name for word in REFUSED):
            continue
        written = quantity(name, key, SI[UNIT_OF[key]]).to(UNIT_OF[key])
        plain = written.to(SI[UNIT_OF[key]]).magnitude
        called(name, **{key: plain})  # shared tables grow in the first call, by a last digit
        got, wanted = called(name, **{key: written}), called(name, **{key: plain})
        np.testing.assert_array_equal(numbers_of(got), numbers_of(wanted), f"{name}({key})")
        done += 1
    assert done > (50 if group == "joints" else 250)


def test_a_wrong_dimension_names_both_units() -> None:
    with pytest.raises(
        ms.InputError, match=r"^amplitude must be a quantity in m, got one in pascal"
    ):
        JOINT.dissipated_energy(REGISTRY.Quantity(1.0, "Pa"))
    with pytest.raises(ms.InputError, match=r"must be a plain number without a unit, got one in m"):
        ms.Interface(JOINT.surface, REGISTRY.Quantity(1.0, "m"), normal_load=1e3)


def test_records_take_units() -> None:
    um, kn = REGISTRY.Quantity([0.0, 1.0, 2.0], "um"), REGISTRY.Quantity([1.0, 2.0, 3.0], "kN")
    record = ms.Record(
        um, kn, REGISTRY.Quantity(2.0, "kN"), sample_rate=REGISTRY.Quantity(1.0, "kHz")
    )
    np.testing.assert_array_equal(record.displacement, [0.0, 1e-6, 2e-6])
    np.testing.assert_array_equal(record.force, [1e3, 2e3, 3e3])
    assert (record.normal_load, record.sample_rate) == (2e3, 1e3)
    with pytest.raises(ms.InputError, match="force must be a quantity in N, got one in micrometer"):
        ms.Record(um, um)


def test_lists_and_labelled_arrays_of_quantities() -> None:
    wanted = JOINT.force([1e-7, 2e-7])
    micro = [REGISTRY.Quantity(0.1, "um"), REGISTRY.Quantity(200.0, "nm")]
    np.testing.assert_allclose(JOINT.force(micro), wanted, rtol=1e-14)
    rows = np.array([[0.1], [0.2]])
    nested = [REGISTRY.Quantity(row, "um") for row in rows]  # NumPy alone would strip these
    np.testing.assert_allclose(JOINT.backbone(nested), JOINT.backbone(1e-6 * rows), rtol=1e-14)
    xarray = pytest.importorskip("xarray")
    labelled = xarray.DataArray(REGISTRY.Quantity([0.1, 0.2], "um"), dims="time")
    np.testing.assert_allclose(JOINT.force(labelled), wanted, rtol=1e-14)
    result = JOINT.force(xarray.DataArray([1e-7, 2e-7], dims="time", attrs={"units": "um"}))
    assert result.dims == ("time",)
    assert not result.attrs  # those of the displacement are not those of the force
    np.testing.assert_array_equal(result, wanted)


def test_labels_of_pandas_and_xarray_are_kept():
    pandas, xarray = pytest.importorskip("pandas"), pytest.importorskip("xarray")
    rows = np.array([[1e-7, 2e-7], [3e-7, 4e-7]])
    times = pandas.Index([0.1, 0.2], name="time")
    series = pandas.Series(rows[0], index=times, name="displacement")
    frame = pandas.DataFrame(rows, index=times, columns=["a", "b"])
    array = xarray.DataArray(rows, coords={"time": [0.1, 0.2]}, dims=("time", "node"))
    for name in ("backbone", "dissipated_energy", "loss_factor", "secant_stiffness"):
        method = getattr(JOINT, name)
        of_series, of_frame, of_array = method(series), method(frame), method(array)
        assert of_series.index.equals(times)
        assert of_series.name is None  # it is no displacement
        assert list(of_frame.columns) == ["a", "b"]
        assert of_array.dims == array.dims
        assert of_array.coords.equals(array.coords)
        np.testing.assert_array_equal(of_series, method(rows[0]))
        np.testing.assert_array_equal(of_frame, method(rows))
        np.testing.assert_array_equal(of_array, method(rows))
    assert JOINT.force(series).index.equals(times)
    loads = xarray.DataArray([10.0, 20.0], dims="bolt")
    separations = JOINT.surface.separation(loads)
    assert separations.dims == ("bolt",)
    assert JOINT.surface.stiffness(separations).dims == ("bolt",)


class Length:
    """A quantity as astropy makes it."""

    unit = "um"
    value = 0.3

    def to(self, unit: str) -> Any:
        if unit != "m":
            raise ValueError(unit)
        length = Length()
        length.value = 3e-7
        return length


def test_quantities_of_other_packages() -> None:
    assert JOINT.dissipated_energy(Length()) == JOINT.dissipated_energy(3e-7)
    with pytest.raises(ms.InputError, match="must be a quantity in N, got one in um"):
        JOINT.at(normal_load=Length())
