"""Recipes of docs/hosts-*.md round the exported C: MATLAB's MEX, Octave, Julia; `make hosts`."""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from exported import COMPILER, JOINT, STRICT, needs_compiler

import microslip as ms
from microslip import export

DOCS = Path(__file__).parents[2] / "docs"
X = 4e-7 * np.sin(0.4 * np.arange(400)) * (1.0 + 0.3 * np.sin(0.07 * np.arange(400)))

STUB = """
/* What the gateway uses of MATLAB's mex.h: a matrix of columns. */
#include <stddef.h>
#include <stdlib.h>
typedef struct { size_t rows, columns; double *numbers; int kind; } mxArray;
enum { mxREAL };
extern const char *message;
static void mexErrMsgTxt(const char *text) { message = text; }
static int mxIsDouble(const mxArray *a) { return a->kind == 0; }
static int mxIsComplex(const mxArray *a) { return a->kind == 1; }
static size_t mxGetM(const mxArray *a) { return a->rows; }
static size_t mxGetN(const mxArray *a) { return a->columns; }
static double *mxGetPr(const mxArray *a) { return a->numbers; }
static mxArray *mxCreateDoubleMatrix(size_t rows, size_t columns, int kind)
{
    mxArray *a = malloc(sizeof *a);
    *a = (mxArray){rows, columns, malloc(rows * columns * sizeof(double)), kind};
    return a;
}
"""
CALLER = """
const char *message;
void mexFunction(int, mxArray *[], int, const mxArray *[]);
const char *call(double *x, double *force, size_t rows, size_t columns)
{
    mxArray given = {rows, columns, x, 0}, *result[1];
    const mxArray *arguments[] = {&given};
    message = NULL;
    mexFunction(1, result, 1, arguments);
    for (size_t i = 0; i < rows * columns; i++) force[i] = result[0]->numbers[i];
    return message;
}
"""


def recipe(language: str) -> str:
    page = DOCS / f"hosts-{'julia' if language == 'julia' else 'nlvib'}.md"
    return page.read_text(encoding="utf-8").split(f"```{language}\n")[1].split("```")[0]


def built(folder: Path, *sources: str) -> ctypes.CDLL:
    export.write("c", JOINT, folder / "joint.c")
    command = [str(COMPILER), *STRICT, "-shared", "-fPIC", "-o", "joint.so", "joint.c", *sources]
    done = subprocess.run([*command, "-lm"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(folder / "joint.so"))


@needs_compiler
def test_the_gateway_gives_forces_of_each_column(tmp_path: Path) -> None:
    """Compiled with a stand-in for MATLAB's header, warnings being errors."""
    (tmp_path / "mex.h").write_text(STUB)
    gateway = '#include "joint.h"\n' + recipe("c").replace('#include "joint.h"\n', "")
    (tmp_path / "joint_mex.c").write_text(gateway + CALLER)
    library = built(tmp_path, "joint_mex.c")
    library.call.restype = ctypes.c_char_p
    x = np.ascontiguousarray([X, 0.3 * X, X[::-1]])  # a row here is a column there
    force = np.empty_like(x)

    def call() -> bytes | None:
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in (x, force)]
        message: bytes | None = library.call(*pointers, ctypes.c_size_t(400), ctypes.c_size_t(3))
        return message

    assert call() is None
    exact = np.array([JOINT.force(row) for row in x])
    np.testing.assert_allclose(force, exact, rtol=0.0, atol=1e-11 * JOINT.force_limit)
    x[1, 7] = np.nan
    assert call() == b"a displacement is no number"


@needs_compiler
def test_the_calls_of_julia_have_the_types_of_the_library(tmp_path: Path) -> None:
    """Each ccall of the page, with the types that it names, in the order of its functions."""
    library = built(tmp_path)
    types = {
        "Cint": ctypes.c_int, "Cdouble": ctypes.c_double, "Ptr{UInt8}": ctypes.c_void_p,
        "Ref{Cdouble}": ctypes.POINTER(ctypes.c_double),
    }  # fmt: skip
    calls = re.findall(r"ccall\(\(:(\w+), lib\), (\w+), \(([^()]*)\)", recipe("julia"))
    assert [name for name, _, _ in calls] == [
        "joint_size", "joint_try", "joint_commit", "joint_dissipated"
    ]  # fmt: skip
    for name, result, arguments in calls:
        function = getattr(library, name)
        function.restype = types[result]
        function.argtypes = [types[kind.strip()] for kind in arguments.split(",") if kind.strip()]
    state = np.zeros(library.joint_size(), dtype=np.uint8)
    place = state.ctypes.data
    force, stiffness, found = ctypes.c_double(), ctypes.c_double(), []
    own = JOINT.start()
    for x in X:
        assert library.joint_try(place, x, ctypes.byref(force), ctypes.byref(stiffness)) >= 0
        library.joint_commit(place)
        found.append((force.value, stiffness.value))
        own.try_(x)
        own.commit()
    np.testing.assert_allclose(np.array(found)[:, 0], JOINT.force(X), rtol=0.0, atol=1e-8)
    assert library.joint_dissipated(place) == pytest.approx(own.dissipated_energy, rel=1e-9)
    assert library.joint_try(place, float("nan"), force, stiffness) < 0


BALANCE = r"""
M = diag([10, 5]); K = [3e9, -2e9; -2e9, 2.5e9]; D = diag([2e3, 1e3]);
H = 3; N = 256; Om = %.17g; n = 2; w = [0; 1];
W = kron(eye(H+1), w);
tau = (0:2*pi/N:2*pi-2*pi/N)'; tau = [tau; tau+2*pi];
H_iDFT = exp(1i*tau*(0:H));
Fex = zeros(n*(H+1), 1); Fex(n+1) = 300;
S = zeros(n*(H+1));
for h = 0:H
    at = h*n+(1:n); S(at, at) = K - (h*Om)^2*M + 1i*h*Om*D;
end
Q = zeros(n*(H+1), 1);
m = n*(H+1); dQ = [eye(m), 1i*eye(m)];
dQ(1:n, m+(1:n)) = 0;                      %% the mean is real
for k = 1:30
    qnl = real(H_iDFT*(W'*Q));
    switch 'microslip'
%s
    end
    Fc = fft(fnl(end-N+1:end))/N; dFc = fft(dfnl(end-N+1:end, :))/N;
    F = W*[real(Fc(1)); 2*Fc(2:H+1)]; dF = W*[real(dFc(1, :)); 2*dFc(2:H+1, :)];
    R = S*Q + F - Fex; J = S*dQ + dF;
    keep = [1:m, m+n+1:2*m];
    A = [real(J(:, keep)); imag(J(n+1:end, keep))];
    step = -A\[real(R); imag(R(n+1:end))];
    Q = Q + step(1:m) + 1i*[zeros(n, 1); step(m+1:end)];
end
printf("%%.17g\n", norm(R), abs(Q(n+1)), abs(Q(n+2)));
"""


@pytest.mark.slow
def test_nlvib_s_case_balances_two_masses_in_octave(tmp_path: Path) -> None:
    """The lines of the page in its alternation: complex harmonics, two periods from rest."""
    make, octave = shutil.which("mkoctfile"), shutil.which("octave-cli") or shutil.which("octave")
    if not make or not octave:
        pytest.skip("no Octave with mkoctfile")
    export.write("c", JOINT, tmp_path / "joint.c")
    (tmp_path / "joint_mex.c").write_text(recipe("c"))
    command = [make, "--mex", "joint_mex.c", "joint.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    masses, stiffness = np.diag([10.0, 5.0]), np.array([[3e9, -2e9], [-2e9, 2.5e9]])
    stuck = stiffness + np.diag([0.0, JOINT.tangential_stiffness])
    omega = 0.95 * np.sqrt(np.linalg.eigvals(np.linalg.solve(masses, stuck)).min())
    (tmp_path / "balance.m").write_text(BALANCE % (omega, recipe("matlab")))
    command = [octave, "--no-gui", "--norc", "--quiet", "balance.m"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    left, *motion = map(float, done.stdout.split())
    assert left < 1e-4 * 300.0
    structure = ms.Structure(masses, stiffness, np.diag([2e3, 1e3]))
    own = structure.attach(JOINT, directions=[0.0, 1.0]).forced_response(
        [300.0, 0.0], np.array([1.0, 1.001]) * omega / (2.0 * np.pi), harmonics=[0, 1, 2, 3]
    )
    exact = np.abs(own.displacement[own.requested][0, :, 1])
    np.testing.assert_allclose(motion, exact, rtol=4e-5)
    assert exact[1] > 5e-8, "well into slip"
