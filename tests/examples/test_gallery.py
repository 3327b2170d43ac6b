"""The scripts of the gallery: each runs, prints these numbers, and draws its picture.

Numbers are held to one unit of their last digit, which another platform may round otherwise, the
words between them exactly.
"""

from __future__ import annotations

import ast
import re
import runpy
from decimal import Decimal
from pathlib import Path

import matplotlib
import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))
_SECONDS = {"14", "16", "18", "19", "22"}
"""Numbers of scripts that take seconds and run with the slow tests."""
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

PRINTED = {
    "01_first_joint": """
5700 summits touch, on 2.79% of the area
stiffness at rest 5.697 GN/m
gross slip at 1.100 kN
±0.15 µm: 42.41 µJ a cycle, loss factor 0.1440, damping ratio 0.0720
±0.4 µm: 525.3 µJ a cycle, loss factor 0.4125, damping ratio 0.2062
±1 µm: 2945 µJ a cycle, loss factor 0.8525, damping ratio 0.4262
density * radius * std: 0.05 (ok)
real over apparent area: 0.0279 (watch)
contact radius over summit spacing: 0.177 (ok)
contacts: 5.7e+03 (ok)
plasticity index: 0.841 (watch)
""",
    "02_many_loads": """
 500 N:   2081 contacts, 1.80 GN/m, gross slip at 275 N
1000 N:   3504 contacts, 3.24 GN/m, gross slip at 550 N
2000 N:   5700 contacts, 5.70 GN/m, gross slip at 1100 N
5000 N:  10041 contacts, 11.48 GN/m, gross slip at 2750 N
loose: 9.061e-05 J at 0.3 µm, 2.677e-05 J at 200 N
tight: 4.740e-04 J at 0.3 µm, 1.319e-07 J at 200 N
""",
    "03_any_history": """
turns: 0.0 1099.2 -1099.2 1022.6 -583.7 1099.2 N
at 0.5 µm: 1087.806 N without the detour, 1087.806 N after it
1000000 samples, 6202 turns
work put in: 0.492 J; largest force: 0.9979 of the limit
""",
    "04_force_control": """
peak force 1000 N of 1100 N
peak displacement 0.3809 µm
left when the force is gone: 0.1115 µm
forth and back: equal
force must be below the force limit 1100 N in magnitude (at the limit slip is unlimited), got 1100 N
""",
    "05_damping": """
small: E = 1.5659e+16 J/m³ δ³, at 0.1 nm it is 0.99987 of that
large: E = 4μN (δ - 0.3309 µm)
at 1 µm: loss factor 0.85247, damping ratio 0.42623
at 1 mm: loss factor 1.27282; in the limit 1.27324
exponent from 1 nm to 10 µm: 2.999 2.986 2.849 2.480 1.489 1.034
""",
    "06_iwan_view": """
slip limit of the ball: 1.3420 µm
 5 cells: backbone off by 1.7e-02 of the limit
10 cells: backbone off by 4.2e-03 of the limit
20 cells: backbone off by 1.1e-03 of the limit
40 cells: backbone off by 2.7e-04 of the limit
stiffness at rest 1.000000 of the joint's
energy at 0.6 µm  1.0012 of it
""",
    "07_time_integration": """
8494 Hz while everything sticks
2.94 iterations a step
farthest 0.2637 µm, rests near 0.0685 µm
52 open reversals are all that the joint remembers
""",
    "08_own_heights": """
Gaussian        5700 contacts, 5.70 GN/m, loss factor at 0.3 µm 0.3047
exponential     2607 contacts, 3.21 GN/m, loss factor at 0.3 µm 0.1834
worn (SciPy)    8400 contacts, 7.80 GN/m, loss factor at 0.3 µm 0.4312
given summits   5870 contacts, 5.82 GN/m, loss factor at 0.3 µm 0.3112
5617 contacts, 5.69 GN/m
""",
    "09_oscillator": """
16.99 kHz while the joint sticks, 14.71 kHz when it slides
 30 nm: 16.860 kHz, damping ratio 0.00820, of the interface alone 0.01340
100 nm: 16.584 kHz, damping ratio 0.01495, of the interface alone 0.04670
300 nm: 15.979 kHz, damping ratio 0.02819, of the interface alone 0.15235
envelope off by 0.4% at most
energy kept to 4e-08
""",
    "10_sweep": """
dissipated_energy (200, 200) loss_factor (200, 200) force_amplitude (200, 200)
pushed with ±400 N: 316 µJ at 750 N, 1.14 µJ at 5 kN
moved by ±0.3 µm: loss factor 0.470 at 100 N, 0.179 at 10 kN
""",
    "11_other_laws": """
Segalman's: chi -0.143, beta 0.000, energies 14.0% off
rough joint 1.545e-08 1.357e-05 2.945e-03 J at 10 nm, 0.1 and 1 µm
Jenkins     0.000e+00 0.000e+00 3.550e-03 J at 10 nm, 0.1 and 1 µm
Segalman    1.501e-08 1.080e-05 3.203e-03 J at 10 nm, 0.1 and 1 µm
Coulomb     4.400e-05 4.400e-04 4.400e-03 J at 10 nm, 0.1 and 1 µm
""",
    "12_one_asperity": """
contact radius 98.94 µm, slip limit 1.3420 µm
pushed:   3.5555 N, sticks within 0.7071
released: 55.93 nm remain, slips back outside 0.8780
  0.000 to 0.707: stick
  0.707 to 0.878: stuck
  0.878 to 1.000: slip
""",
    "13_from_a_scan": """
rms height 200.0 nm, Nayak's alpha 25.04
at a cut-off of 5 µm: 4735 summits/mm^2, radius 121 µm, std 195 nm
no cut-off: 1052 summits of 85 µm; 39412 touch, ζ = 0.358 at 0.2 µm
cut-off 10 µm: 314 summits of 221 µm; 23473 touch, ζ = 0.355 at 0.2 µm
cut-off 20 µm: 98 summits of 503 µm; 14847 touch, ζ = 0.352 at 0.2 µm
""",
    "14_identify": """
2000 N: 7.0 to 7.7 mJ a cycle at 2 µm
1000 N: 3.7 to 3.8 mJ a cycle at 2 µm
500 N: 1.9 to 1.9 mJ a cycle at 2 µm
the loops obey Masing's rules within noise
friction_coefficient: identified
slip_scale: identified
standardised_separation: identified
std: identified
joint and rig in series: rig above 458 N/µm
friction_coefficient: identified
slip_scale: not determined
""",
    "15_varying_load": """
constant load: 92.8 µJ a cycle
in step: 85.4 µJ a cycle, 0.920 of that
45° ahead: 136.7 µJ a cycle, 1.474 of that
90° ahead: 141.8 µJ a cycle, 1.529 of that
600 N at 2 kN: 141.4 nm
±10%: 162.0 nm after a cycle, then 0.0 nm more
±20%: 191.8 nm after a cycle, then 0.0 nm more
±40%: 353.3 nm after a cycle, then 0.0 nm more
""",
    "16_structure": """
sticking 1862 and 6087 Hz, sliding 1680 and 5923 Hz
mode 1: 1857.7 to 1682.3 Hz, damping up to 0.0301; the quick look is off by 5% at most
mode 2: 6076.3 to 5923.0 Hz, damping up to 0.0089; the quick look is off by 12% at most
energy kept to 3e-08
damping read from the ring-down: 0.97 to 1.00 of the mode's
""",
    "17_measured_face": """
hardness 1.68 GPa, 76 % of the contact is at it
4430 points touch, 6.8 % of the face
the stiffness of its four pieces scatters by 11 %
at  0° from x: 89.3 GN/m, normal over tangential stiffness 1.050
at 90° from x: 68.2 GN/m, normal over tangential stiffness 1.373
at half of the load: 49.8 GN/m
verdicts: ok ok ok ok
point by point     stiffness 1.00, energy of a cycle 1.000
summits one by one stiffness 0.45, energy of a cycle 0.221
Gaussian summits   stiffness 0.46, energy of a cycle 0.260
""",
    "18_several_laps": """
mode 1: 94.1 to 94.0 Hz, damping ratio up to 0.00091, 70% of the loss on the ground
mode 3: 403.0 to 395.3 Hz, damping ratio up to 0.00694, 28% of the loss on the ground
""",
    "19_shaker_table": """
   1 m/s²: 366 at 904.3 Hz, unstable points: 0
   5 m/s²: 196 at 901.0 Hz, unstable points: 0
  15 m/s²: 125 at 895.6 Hz, unstable points: 0
""",
    "20_random_vibration": """
0.01 (m/s²)²/Hz: 2391 Hz, damping ratio 0.0052, 73 m/s² rms, peaks of 375 m/s² in a minute
0.1 (m/s²)²/Hz: 2362 Hz, damping ratio 0.0118, 152 m/s² rms, peaks of 780 m/s² in a minute
1 (m/s²)²/Hz: 2286 Hz, damping ratio 0.0307, 295 m/s² rms, peaks of 1511 m/s² in a minute
""",
    "21_shock": """
  30 m/s²: 1.76 of the pulse at the tip, 0.35 rms later
 300 m/s²: 1.75 of the pulse at the tip, 0.57 rms later
3000 m/s²: 1.86 of the pulse at the tip, 0.26 rms later
""",
    "22_panel": """
linear: 112.9 Hz, -2.8% at 1.4 mm
with geometry: 112.9 Hz, -6.2% at 1.4 mm
""",
}


def alike(got: str, wanted: str) -> bool:
    if NUMBER.sub("#", " ".join(got.split())) != NUMBER.sub("#", " ".join(wanted.split())):
        return False
    for one, other in zip(NUMBER.findall(got), NUMBER.findall(wanted), strict=True):
        unit = Decimal(1).scaleb(int(Decimal(other).as_tuple().exponent))
        if abs(Decimal(one) - Decimal(other)) > unit * Decimal("1.0001"):
            return False
    return True


@pytest.mark.parametrize(
    ("got", "wanted", "same"),
    [
        ("5701 summits", "5700 summits", True),
        ("5702 summits", "5700 summits", False),
        ("a 1.5659e-05 J", "a 1.5657e-05 J", False),
        ("a 1 J", "b 1 J", False),
        ("1 2", "1", False),
    ],
)
def test_numbers_are_compared_to_their_last_digit(got: str, wanted: str, same: bool) -> None:
    assert alike(got, wanted) is same


def test_every_script_has_its_numbers_here() -> None:
    assert [script.stem for script in SCRIPTS] == sorted(PRINTED)
    assert len(SCRIPTS) >= 6


@pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
@pytest.mark.parametrize(
    "script",
    [
        pytest.param(
            path, id=path.stem, marks=pytest.mark.slow if path.stem[:2] in _SECONDS else ()
        )
        for path in SCRIPTS
    ],
)
def test_script(
    script: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(FOLDER)
    before = matplotlib.rcParams.copy()
    matplotlib.use("agg")
    from matplotlib import pyplot

    try:
        runpy.run_path(str(script), run_name="__main__")
        figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
        assert figures
        for figure in figures:
            figure.canvas.draw()
            for axes in figure.axes:
                assert axes.lines or axes.collections or axes.images
                if axes.get_label() == "<colorbar>":
                    assert axes.get_xlabel() or axes.get_ylabel()
                    continue
                assert axes.get_xlabel() or axes.get_shared_x_axes().get_siblings(axes) != [axes]
                assert axes.get_ylabel() or axes.get_shared_y_axes().get_siblings(axes) != [axes]
    finally:
        pyplot.close("all")
        matplotlib.rcParams.update(before)
    got = capsys.readouterr().out.strip().splitlines()
    wanted = PRINTED[script.stem].strip().splitlines()
    assert len(got) == len(wanted), got
    for line, expected in zip(got, wanted, strict=True):
        assert alike(line, expected), f"{line!r}, not {expected!r}"


@pytest.mark.parametrize(
    "script", [p for p in SCRIPTS if p.stem[:2].isdigit()], ids=lambda p: p.stem
)
def test_a_notebook_holds_the_code_of_its_script(script: Path) -> None:
    """So a notebook runs where its script does, which the tests above run."""
    make = runpy.run_path(str(ROOT / "tools" / "make_notebooks.py"))["notebook"]
    text = script.read_text(encoding="utf-8")
    made = make(text)
    code = "\n".join("".join(c["source"]) for c in made["cells"] if c["cell_type"] == "code")
    body = ast.parse(text).body
    assert ast.dump(ast.Module(ast.parse(code).body, [])) == ast.dump(ast.Module(body[1:], []))
    assert made["cells"][0]["cell_type"] == "markdown"
    assert sum(c["cell_type"] == "markdown" for c in made["cells"]) >= 2
