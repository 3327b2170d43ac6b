"""Exported C is the law: compiled, and run along histories beside `joint.force`."""

import ctypes
import shutil
import subprocess
from itertools import pairwise

import numpy as np
import pytest
from exported import COMPILER, JOINT, STRICT, compiled, needs_compiler, records, run

import microslip as ms
from microslip import export
from microslip.friction import LAWS

pytestmark = needs_compiler
_SCALE = 3e-7  # m, of the joint


@pytest.mark.slow
def test_a_million_samples_of_each_history_agree_to_rounding(tmp_path):
    library = compiled([JOINT], tmp_path, depth=4096)
    for name, x in records(_SCALE, 1_000_000).items():
        force, _, told, limited = run(library, 0, x)
        wanted = JOINT.force(x)
        # The same table by the same operations; compilers may fuse a product and a sum.
        assert np.abs(force - wanted).max() <= 1e-13 * np.abs(wanted).max(), name
        assert not limited, name
        assert told[-1] == 0.0, name


@pytest.mark.parametrize("every", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_laws_of_every_kind_are_held_with_their_stiffness(every, tmp_path):
    laws = [law for kind in LAWS for law in kind.examples()]
    laws = [law for law in laws if np.isfinite(law.tangential_stiffness)]
    if not every:
        laws = [laws[8], laws[13], ms.Iwan.examples()[1], ms.SegalmanIwan.examples()[2]]
    library = compiled(laws, tmp_path, depth=2048)
    for i, law in enumerate(laws):
        scale = law.force_limit / law.tangential_stiffness
        for name, x in records(scale, 2000, seed=i).items():
            force, stiffness, _, limited = run(library, i, x)
            wanted = law.force(x)
            assert not limited, law
            assert np.abs(force - wanted).max() <= 1e-13 * np.abs(wanted).max(), (law, name)
        u = np.append(np.geomspace(1e-3, 30.0, 40) * scale, 0.0)
        stiffness = run(library, i, u)[1][:-1]
        exact = law.backbone_stiffness(u[:-1])
        at_kink = np.isclose(u[:-1, None], law._kinks[None, :], rtol=1e-9, atol=0.0).any(axis=1)
        # Derivatives of panels of degree 11 lose up to its square over their values.
        off = np.abs(stiffness - exact)[~at_kink]
        assert off.max() <= 1e-10 * law.tangential_stiffness, law


@pytest.mark.parametrize("depth", [4, pytest.param(5, marks=pytest.mark.slow), 10])
def test_a_limited_depth_tells_a_bound_that_holds_and_heals(depth, tmp_path):
    library = compiled([JOINT], tmp_path, depth=depth)
    for seed in range(4):
        x = records(_SCALE, 20_000, seed)["walk"]
        force, _, told, limited = run(library, 0, x)
        off = np.abs(force - JOINT.force(x))
        assert np.all(off <= told + 1e-12 * JOINT.force_limit)
        if depth == 4:
            assert limited > 0
            assert off.max() > 0.1 * told[-1] > 0.0  # a bound that means something
        end = 3.0 * np.abs(x).max()  # beyond everything: all loops are closed
        force = run(library, 0, np.append(x, [end, -end]))[0]
        wanted = JOINT.force(np.append(x, [end, -end]))[-1]
        assert force[-1] == pytest.approx(wanted, rel=1e-13)


@pytest.mark.parametrize("depth", [4, pytest.param(10, marks=pytest.mark.slow), 256])
def test_a_free_decay_goes_on_for_ever(depth, tmp_path):
    """One reversal a half cycle opens inside the last: what is recent stays exact."""
    library = compiled([JOINT], tmp_path, depth=depth)
    t = np.arange(40_000)
    x = 2e-6 * np.exp(-t / 9000.0) * np.sin(t / 7.3)
    force, stiffness, told, limited = run(library, 0, x)
    wanted = JOINT.force(x)
    turns = 1800  # about as many half cycles
    assert np.abs(force - wanted).max() <= 1e-13 * turns * JOINT.force_limit
    assert not limited
    assert told[-1] == 0.0
    state = JOINT.start()
    state.advance(x[:-1])
    assert stiffness[-1] == pytest.approx(state.try_(x[-1])[1], rel=1e-9)


def test_what_comes_back_out_does_not_jump(tmp_path):
    """Between the samples of a fine path forces change by no more than the stiffness lets them."""
    library = compiled([JOINT], tmp_path, depth=4)
    rng = np.random.default_rng(4)
    decay = 2e-6 * 0.9 ** np.arange(40) * (-1.0) ** np.arange(40)
    corners = np.concatenate((decay, 4e-7 * rng.normal(size=60), [1.9e-6, -1.9e-6], decay))
    x = np.concatenate([np.linspace(a, b, 400) for a, b in pairwise(corners)])
    force, _, told, limited = run(library, 0, x)
    assert limited > 0
    steps = np.abs(np.diff(force)) - JOINT.tangential_stiffness * np.abs(np.diff(x))
    assert steps.max() <= 1e-9 * JOINT.force_limit
    assert np.all(np.abs(force - JOINT.force(x)) <= told + 1e-12 * JOINT.force_limit)


def test_states_are_saved_restored_and_refused(tmp_path):
    library = compiled([JOINT], tmp_path, depth=8)
    state, other = (ctypes.create_string_buffer(4096) for _ in range(2))
    force = ctypes.c_double()
    call = {name: getattr(library, f"joint0_{name}") for name in ("start", "try", "commit")}
    call["start"](state)
    for x in (3e-7, -1e-7, 2e-7):
        assert call["try"](state, ctypes.c_double(x), None, None) == 0
        assert call["commit"](state) == 0
    numbers = (ctypes.c_double * 50)()
    library.joint0_save(state, numbers)
    assert library.joint0_restore(other, numbers) == 0
    for each in (state, other):
        call["try"](each, ctypes.c_double(-4e-7), ctypes.byref(force), None)
        assert force.value == pytest.approx(JOINT.force([3e-7, -1e-7, 2e-7, -4e-7])[-1], rel=1e-13)
    assert call["try"](state, ctypes.c_double(float("nan")), None, None) == -1
    assert call["commit"](state) == -1
    for place, value in (
        (0, -9e-7),  # a displacement that its rows do not lead to
        (2, 1e4),  # more than mu N
        (3, 9.0),
        (3, 0.5),
        (4, -2.0),
        (5, -1.0),
        (10, float("inf")),
        (10, 1e-9),  # rows that do not nest
        (11, 1.5),  # more than slips
        (18, 1e4),
    ):
        wrong = (ctypes.c_double * 50)(*numbers)
        wrong[place] = value
        assert library.joint0_restore(other, wrong) == -1, (place, value)


FORTRAN = """
program drive
  use, intrinsic :: iso_c_binding
  use joint_history
  implicit none
  type(joint_state) :: s, t
  real(c_double) :: f, k, numbers(joint_saved), x(5) = [3d-7, -1d-7, 2d-7, -4d-7, 1d-7]
  integer :: i
  call joint_start(s)
  do i = 1, 5
    if (joint_try(s, x(i), f, k) /= 0 .or. joint_commit(s) /= 0) error stop
    call joint_save(s, numbers)
    if (joint_restore(t, numbers) /= 0) error stop
    call joint_copy(t, s)
    print '(es24.16)', f
  end do
end program
"""


@pytest.mark.skipif(shutil.which("gfortran") is None, reason="no gfortran")
def test_fortran_calls_it(tmp_path):
    export.write("c", JOINT, tmp_path / "joint.c", depth=16)
    (tmp_path / "drive.f90").write_text(FORTRAN)
    for command in (
        [COMPILER, *STRICT, "-c", "joint.c"],
        ["gfortran", "-Wall", "-Werror", "-o", "drive", "joint.f90", "drive.f90", "joint.o"],
    ):
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    done = subprocess.run(["./drive"], cwd=tmp_path, check=True, capture_output=True, text=True)
    wanted = JOINT.force([3e-7, -1e-7, 2e-7, -4e-7, 1e-7])
    np.testing.assert_allclose(np.array(done.stdout.split(), dtype=float), wanted, rtol=1e-13)


@pytest.mark.slow
def test_sanitizers_find_nothing(tmp_path):
    sphere = ms.Interface(ms.SphereOnFlat(JOINT.surface.pair, radius=5e-3), 0.3, normal_load=10.0)
    laws = [JOINT, sphere, ms.Iwan([1e8, 2e8], [10.0, 50.0])]
    flags = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g")
    for depth in (4, 64):
        folder = tmp_path / str(depth)
        folder.mkdir()
        source = ""
        for i, law in enumerate(laws):
            export.write("c", law, folder / f"law{i}.c", name=f"joint{i}", depth=depth)
            source += f'#include "law{i}.c"\n'
        source += "#include <stdlib.h>\n"
        calls = ""
        for i, law in enumerate(laws):
            scale = law.force_limit / law.tangential_stiffness
            calls += f"""
    {{
        static joint{i}_state s, t;
        static double kept[joint{i}_SAVED];
        joint{i}_start(&s);
        for (long n = 0; n < 300000; n++) {{
            double x = {scale!r} * (rand() % 1001 - 500) / (1 + rand() % 400), f, k;
            if (n % 1000 == 0) x = n % 2000 ? 1e99 : -1e308;
            joint{i}_try(&s, x, &f, &k);
            if (n % 5) joint{i}_commit(&s);
            joint{i}_save(&s, kept);
            if (joint{i}_restore(&t, kept) != 0) return 2;
            joint{i}_copy(&t, &s);
        }}
    }}"""
        (folder / "main.c").write_text(f"{source}\nint main(void)\n{{{calls}\n    return 0;\n}}\n")
        command = [str(COMPILER), *STRICT, *flags, "-o", "main", "main.c", "-lm"]
        subprocess.run(command, cwd=folder, check=True)
        done = subprocess.run(["./main"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
