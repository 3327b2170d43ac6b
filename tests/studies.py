"""A study, and surfaces for it, shared by the tests."""

from __future__ import annotations

STUDY = """\
schema = 1
title = "A joint"

[material.al]
young_modulus = "69 GPa"
poisson_ratio = 0.33

[surface]
materials = ["al", "al"]
law = "greenwood-williamson"
heights = { kind = "gaussian", std = "0.5 um" }
radius = "1 mm"
density = "100 1/mm^2"
area = "2 cm^2"

[joint]
friction_coefficient = 0.55
normal_load = ["500 N", "2 kN"]

[excitation]
amplitudes = ["0.1 um", "1 um"]
curve = { from = "1 nm", to = "100 um", points = 20 }

[output]
formats = ["csv"]
"""
AMPLITUDES = '["0.1 um", "1 um"]'
CURVE = '{ from = "1 nm", to = "100 um", points = 20 }'
GAUSSIAN = '{ kind = "gaussian", std = "0.5 um" }'
LOADS = '["500 N", "2 kN"]'
MATERIAL = '[material.al]\nyoung_modulus = "69 GPa"\npoisson_ratio = 0.33\n'
SURFACE = STUDY[STUDY.index("law =") : STUDY.index("\n[joint]")]

_GIVEN = 'heights = { kind = "values", values = ["0 um", "0.2 um", "-0.3 um"] }\n'
_AROUND = 'radius = "1 mm"\ndensity = "100 1/mm^2"\narea = "2 cm^2"\n'
SURFACES = {
    "exponential": 'law = "greenwood-williamson"\n'
    'heights = { kind = "exponential", scale = "0.8 um" }\n' + _AROUND,
    "values": 'law = "greenwood-williamson"\n' + _GIVEN + _AROUND,
    "density": 'law = "greenwood-williamson"\nheights = { kind = "table", '
    'height = ["-1 um", "0 um", "1 um"], density = ["0 1/um", "2 1/um", "0 1/um"] }\n' + _AROUND,
    "population": 'law = "population"\nradius = ["1 mm", "2 mm", "1 mm"]\n' + _GIVEN,
    "sphere": 'law = "sphere"\nradius = "5 mm"\n',
    "table": 'law = "table"\nseparation = ["0 um", "0.5 um", "1 um"]\n'
    'load = ["2 kN", "0.5 kN", "0 N"]\n',
    "tail": 'law = "table"\nseparation = ["0 um", "0.5 um", "1 um"]\n'
    'load = ["2 kN", "0.9 kN", "0.5 kN"]\ntail = "exponential"\n',
}
"""Every law and kind of heights, to stand in place of :data:`SURFACE`."""


def edited(*edits: tuple[str, str]) -> str:
    """The study with texts replaced, each where it is first."""
    text = STUDY
    for old, new in edits:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    return text
