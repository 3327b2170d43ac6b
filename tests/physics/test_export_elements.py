"""Exported elements whose load varies, or of two directions, and the user routines round them."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from exported import COMPILER, JOINT, STRICT, go, library_of, needs_compiler

import microslip as ms
from microslip import export

pytestmark = needs_compiler
_SLIDERS = 32
_PLANAR = ms.IsotropicJoint(JOINT, _SLIDERS)
_FIELD = ms.JointField(
    JOINT.surface, 0.55, areas=1.0, separations=JOINT.separation, surface_area=1.0
).two_directions(_SLIDERS)
_ELEMENTS = {
    "joint": {"depth": 512},
    "contact": {"element": "contact", "depth": 512},
    "planar": {"law": _PLANAR, "smallest_amplitude": 3e-8},
    "solid": {"law": _FIELD, "smallest_amplitude": 1e-7},
}


def history(samples: int, seed: int) -> np.ndarray:
    """Displacements in two directions, and openings: noise, a held stretch, parting."""
    rng = np.random.default_rng(seed)
    x = 3e-7 * rng.standard_normal((samples, 2)) * rng.choice([0.01, 0.3, 1.0], (samples, 1))
    d = 3e-7 * np.sin(np.arange(samples) / 11.3) + 1e-7 * rng.standard_normal(samples)
    d[samples // 2 : samples // 2 + 40] = 0.0
    d[samples // 3 : samples // 3 + 2] = 2e-5
    return np.column_stack((x, np.maximum(d, -3.8e-7)))


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    given = {name: dict(options) for name, options in _ELEMENTS.items()}
    return ctypes.CDLL(str(library_of(tmp_path_factory.mktemp("elements"), **given)))


def close(found, wanted, share):
    scale = np.abs(wanted).max()
    assert np.abs(found - wanted).max() <= share * scale


@pytest.mark.parametrize("samples", [600, pytest.param(20_000, marks=pytest.mark.slow)])
def test_each_element_is_its_state_in_python(library, samples):
    u = history(samples, samples)
    states = JOINT.start(), _PLANAR.start(energies=True), _FIELD.start(energies=True)
    wanted = {name: [] for name in ("contact", "planar", "solid")}
    for *x, d in u:
        trial = states[0].try_(x[0], separation=JOINT.separation + d)
        row = [trial.force, trial.normal_load], trial.tangent
        states[0].commit()
        energies = [states[0].dissipated_energy, states[0].stored_energy]
        wanted["contact"].append((*row, energies))
        row = states[1].try_(x)
        states[1].commit()
        energies = [states[1].dissipated_energy, states[1].stored_energy]
        wanted["planar"].append((*row, energies))
        answer = states[2].try_(x, separations=JOINT.separation + d)
        states[2].commit()
        energies = [states[2].dissipated_energy[0], states[2].stored_energy[0]]
        wanted["solid"].append(([*answer.force[0], answer.load[0]], answer.tangent[0], energies))
    columns = {"contact": [0, 2], "planar": [0, 1], "solid": [0, 1, 2]}
    for name, rows in wanted.items():
        force, tangent, told, limited = go(library, name, u[:, columns[name]])
        forces, tangents, energies = (np.array(part) for part in zip(*rows, strict=True))
        assert not limited
        close(force, forces, 1e-13)
        close(tangent, tangents, 1e-11)  # a share may be 1e-4 of its largest, and its panel's slope
        # By parts here, by quadrature of what is positive there.
        close(told[:, : energies.shape[1]], energies, 1e-12)


@pytest.mark.slow
def test_a_million_samples_of_a_contact_agree_to_rounding(library):
    u = history(1_000_000, 7)[:, [0, 2]]
    force, _, told, limited = go(library, "contact", u)
    separation = JOINT.separation + u[:, 1]
    wanted = JOINT.coupled_force(u[:, 0], separation=separation)
    assert not limited
    close(force[:, 0], wanted, 1e-13)
    close(force[:, 1], JOINT.surface.load(separation), 1e-13)
    state = JOINT.start()
    state.advance(u[:, 0], separation=separation)
    assert told[-1, 0] == pytest.approx(state.dissipated_energy, rel=1e-10)
    assert told[-1, 1] == pytest.approx(state.stored_energy, rel=1e-9)


@pytest.mark.slow
def test_work_is_stored_or_dissipated(library):
    """Along a fine path the work of the force is what both energies gain."""
    t = np.linspace(0.0, 9.0, 60_001)
    x = 4e-7 * np.sin(t) * np.exp(-0.1 * t)
    paths = {
        "joint": x[:, None],
        "contact": np.column_stack((x, 1e-7 * np.sin(2.3 * t))),
        "planar": np.column_stack((x, 3e-7 * np.sin(1.7 * t))),
        "solid": np.column_stack((x, 3e-7 * np.sin(1.7 * t), 1e-7 * np.sin(2.3 * t))),
    }
    for name, u in paths.items():
        force, _, told, _ = go(library, name, u)
        tangential = 2 if name in ("planar", "solid") else 1
        means = 0.5 * (force[1:, :tangential] + force[:-1, :tangential])
        work = np.append(0.0, np.cumsum((means * np.diff(u[:, :tangential], axis=0)).sum(axis=1)))
        assert np.abs(told[:, 0] + told[:, 1] - work).max() <= 1e-6 * work.max(), name  # trapezoids
        assert np.diff(told[:, 0]).min() >= 0.0, name
        assert told[:, 1].min() >= 0.0, name


@pytest.mark.parametrize("depth", [4, 10])
def test_a_full_memory_tells_a_bound_that_holds_and_heals(depth, tmp_path):
    product = library_of(tmp_path, contact={"element": "contact", "depth": depth})
    library = ctypes.CDLL(str(product))
    seen = 0.0
    for seed in range(6):
        u = history(2000, seed)[:, [0, 2]]
        if seed % 2:  # it fills, and comes back out
            u *= (0.98 ** (np.arange(2000) % 300))[:, None]
        u[-1] = 1e-5, 0.0
        force, _, told, limited = go(library, "contact", u)
        wanted = JOINT.coupled_force(u[:, 0], separation=JOINT.separation + u[:, 1])
        off = np.abs(force[:, 0] - wanted)
        assert np.all(off <= told[:, 2] + 1e-11 * JOINT.force_limit)
        assert off[-1] <= 1e-11 * JOINT.force_limit
        seen = max(seen, float(np.max(off) / told[-1, 2]) if limited else 0.0)
    assert seen > 0.02  # a bound that means something


def test_a_contact_is_refused_where_it_is_not_held(library, tmp_path):
    state = ctypes.create_string_buffer(1 << 16)
    near = (ctypes.c_double * 2)(0.0, -1e-4)
    assert library.contact_move(state, near, None, None) == -1
    assert library.contact_commit(state) == -1
    kinked = ms.AsperityPopulation(JOINT.surface.pair, heights=[0.0, 1e-7, 3e-7], radii=1e-3)
    cases = (
        (ms.Jenkins(1e8, 10.0), {"element": "contact"}, "need an Interface"),
        (ms.Interface(kinked, 0.3, normal_load=1.0), {"element": "contact"}, "has kinks"),
        (JOINT, {"element": "spatial"}, "element must be one of joint, contact"),
        (JOINT, {"element": "contact", "kind": "opensees"}, "element must be joint for opensees"),
    )
    for law, options, says in cases:
        with pytest.raises(ms.InputError, match=says):
            export.write(options.pop("kind", "c"), law, tmp_path / "a.c", **options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_sanitizers_find_nothing_in_any_element(tmp_path):
    flags = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")
    main = "#include <stdlib.h>\nstatic double u[60000], f[60000], k[180000], e[60000];\n"
    main += "int main(void)\n{\n"
    for name in ("joint", "contact", "planar", "solid"):
        main += f"""
    for (int i = 0; i < 20000; i++)
        for (int c = 0; c < {name}_COMPONENTS; c++)
            u[{name}_COMPONENTS * i + c] =
                (c < {name}_TANGENTIAL ? 1e-9 : 3e-10) * (rand() % 1001 - 500) / (1 + rand() % 300);
    if ({name}_go(u, f, k, e, 20000) < 0) return 1;
"""
    for depth in (4, 64):
        folder = tmp_path / str(depth)
        folder.mkdir()
        given = {name: dict(options) for name, options in _ELEMENTS.items()}
        given["joint"]["depth"] = given["contact"]["depth"] = depth
        product = library_of(folder, *flags, main=main + "    return 0;\n}\n", **given)
        done = subprocess.run([str(product)], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


# The calling sequences of Abaqus' manual, from Fortran: iterations, then the end of an increment.
ABAQUS = """
program drive
  implicit none
  integer, parameter :: n = {samples}, c = {components}, t = {tangential}, saved = {saved}
  integer, parameter :: dims = 3, ndofel = 6, nsvars = saved + c, nblock = 2
  double precision :: x(c, n), u(ndofel), rhs(ndofel, 1), k(ndofel, ndofel), energy(8), params(3)
  double precision :: svars(nsvars), start(nsvars), statev(saved), none(40), props(3), sse, spd
  double precision :: stress(c), ddsdde(c, c), stran(c), dstran(c), pnewdt, time(2)
  double precision :: vrhs(nblock, ndofel), mass(nblock, ndofel, ndofel), stable(nblock)
  double precision :: vsvars(nblock, nsvars), venergy(nblock, 12), vu(nblock, ndofel)
  integer :: lflags(5), jprops(c), i, j, jelem(nblock), jstep(4)
  character(len=80) :: cmname
  none = 0; svars = 0; statev = 0; vsvars = 0; energy = 0; time = 0; stran = 0; jstep = 0
  cmname = 'JOINT'
  jprops = [{jprops}]
  open (10, file='path.txt')
  read (10, *) x
  params = [-0.05d0, 0d0, 0d0]
  lflags = [1, 0, 1, 0, 0]
  do i = 1, n
    props = [2d0, {offset}, 3d0]
    u = 0
    do j = 1, c
      u(3 + jprops(j)) = x(j, i) + 1d-7
      u(jprops(j)) = 1d-7
      if (j > t) u(jprops(j)) = 1d-7 + {offset}
    end do
    start = svars
    do j = 1, 2 ! a trial elsewhere, then the end, both from the states before
      svars = start
      if (j == 1) u(3 + jprops(1)) = u(3 + jprops(1)) + 3d-7
      if (j == 2) u(3 + jprops(1)) = u(3 + jprops(1)) - 3d-7
      pnewdt = 1d0
      call uel(rhs, k, svars, energy, ndofel, 1, nsvars, props, 3, none, dims, 2, u, none, none, &
        none, 1, time, 1d0, 1, i, 1, params, 0, [0], none, none, 0, lflags, ndofel, none, 0, &
        pnewdt, jprops, c, 1d0)
    end do
    if (pnewdt < 1d0) error stop 'uel'
    props = [2d-4, 1d-3, 0d0]
    do j = 1, c ! the normal first
      dstran(merge(j + merge(1, 0, c > t), 1, j <= t)) = x(j, i) / props(2)
    end do
    dstran = dstran - stran
    call umat(stress, statev, ddsdde, sse, spd, none, none, none, none, none, stran, dstran, time, &
      1d0, none, none, none, none, cmname, 1, c - 1, c, saved, props, 2, none, none, pnewdt, 1d0, &
      none, none, 1, 1, 1, 1, jstep, i)
    if (pnewdt < 1d0) error stop 'umat'
    stran = stran + dstran
    props = [2d0, {offset}, 3d0]
    vu(1, :) = u
    vu(2, :) = 0.5d0 * u
    lflags(3) = 2
    mass = 0
    call vuel(nblock, vrhs, mass, stable, vsvars, nsvars, venergy, 2, ndofel, props, 3, jprops, &
      c, none, dims, vu, vu, vu, vu, 1, jelem, time, 1d0, 1d0, 1d0, 1, i, lflags, none, none, 0, &
      0, none)
    lflags(3) = 1
    call vuel(nblock, vrhs, mass, stable, vsvars, nsvars, venergy, 2, ndofel, props, 3, jprops, &
      c, none, dims, vu, vu, vu, vu, 1, jelem, time, 1d0, 1d0, 1d0, 1, i, lflags, none, none, 0, &
      0, none)
    print '(99es25.16)', (rhs(3 + jprops(j), 1), j = 1, c), (rhs(jprops(j), 1), j = 1, c), &
      (k(3 + jprops(1), 3 + jprops(j)), j = 1, c), energy(2), energy(4), stress, ddsdde(c, :), &
      sse, spd, (vrhs(1, 3 + jprops(j)), j = 1, c), venergy(1, 1), venergy(1, 3), mass(1, 1, 1), &
      stable(1)
  end do
end program
"""


@pytest.mark.skipif(shutil.which("gfortran") is None, reason="no gfortran")
@pytest.mark.parametrize(("element", "columns"), [("joint", [0]), ("contact", [0, 2]),
                                                  ("planar-contact", [0, 1, 2])])  # fmt: skip
def test_user_routines_are_called_as_abaqus_calls_them(element, columns, tmp_path, library):
    samples, c, t = 200, len(columns), 2 if element.startswith("planar") else 1
    law = _FIELD if t == 2 else JOINT
    export.write("abaqus-user", law, tmp_path / "joint.c", element=element, depth=64)
    u = history(samples, 3)[:, columns]
    np.savetxt(tmp_path / "path.txt", u)
    saved = 6 + 2 * _SLIDERS if t == 2 else 10 + 5 * 64
    (tmp_path / "drive.f90").write_text(
        ABAQUS.format(samples=samples, components=c, tangential=t, saved=saved,
                      jprops=", ".join(map(str, [2, 3, 1][:t] + [1][: c - t])),
                      offset="1d-6" if c > t else "0d0")
    )  # fmt: skip
    for command in (
        [COMPILER, *STRICT, "-c", "joint.c"],
        ["gfortran", "-fallow-argument-mismatch", "-o", "drive", "drive.f90", "joint.o"],
    ):
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    done = subprocess.run(["./drive"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    table = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
    cuts = np.cumsum([c, c, c, 1, 1, c, c, 1, 1, c, 1, 1, 1])
    (far, near, row, stored, lost, stress, last, sse, spd, vforce, vlost, vinner, mass, stable) = (
        np.split(table, cuts, axis=1)
    )
    name = {"joint": "joint", "contact": "contact", "planar-contact": "solid"}[element]
    force, tangent, told, _ = go(library, name, u)
    sign = np.array([1.0] * t + [-1.0] * (c - t))  # the load presses the nodes apart
    close(far, -2.0 * sign * force, 1e-9)
    np.testing.assert_array_equal(near, -far)
    close(row, 2.0 * tangent[:, 0], 1e-6)
    close(stored[:, 0], 2.0 * told[:, 1], 1e-9)
    close(lost[:, 0], 2.0 * told[:, 0], 1e-9)
    close(vforce, 2.0 * sign * force, 1e-9)
    close(vlost[:, 0], 2.0 * told[:, 0], 1e-9)
    close(vinner[:, 0], 2.0 * told[:, :2].sum(axis=1), 1e-9)
    assert np.all(mass == 1.5)
    assert np.all(stable > 0.0)
    place = [0] if c == 1 else [*range(1, t + 1), 0]
    close(stress[:, place], sign * force / 2e-4, 1e-9)
    close(last[:, place], (sign[:, None] * tangent)[:, place.index(c - 1)] * 1e-3 / 2e-4, 1e-6)
    close(sse[:, 0], told[:, 1] / (2e-4 * 1e-3), 1e-9)
    close(spd[:, 0], told[:, 0] / (2e-4 * 1e-3), 1e-9)
