"""Wrong studies: the one line that each of them gets, pinned as it is read."""
# ruff: noqa: E501 - each message stands on one line

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest
from studies import AMPLITUDES, CURVE, GAUSSIAN, LOADS, MATERIAL, STUDY, SURFACE, edited, says

import microslip as ms

LAWS = '"greenwood-williamson", "population", "sphere", "table" or "scan"'
LINE = f"amplitudes = {AMPLITUDES}"


def many(unit: str) -> str:
    """A list of 1001 different quantities."""
    return "[" + ", ".join(f'"{i} {unit}"' for i in range(1, 1002)) + "]"


# What is replaced in the study, by what, and the message that follows.
WRONG = [
    # TOML
    ('title = "A', "title = A", "line 2, column 9: not TOML: invalid value (text and quantities stand in quotes)"),
    ("[output]", "[output", "line 24, column 8: not TOML: expected ']' at the end of a table declaration"),
    ("[output]", "[joint]", "line 24, column 7: not TOML: cannot declare [joint] twice"),
    ("schema = 1", "schema = 1\nschema = 1", "line 2, column 11: not TOML: this key is given twice"),
    ('["csv"]', '["csv"', "line 25, column 17: not TOML: unclosed array"),
    ("0.33", "0." + 5000 * "3" + "e", 'line 6, column 5019: not TOML: quantities stand in quotes, such as "2 kN"'),
    ("0.33", "1" + 5000 * "0", "not a study: an integer of thousands of digits"),
    # keys
    ("schema = 1", "", "schema: missing; write for example schema = 1"),
    ("schema = 1", "schema = 2", "schema: wanted schema = 1, got 2"),
    ("schema = 1", "schema = true", "schema: wanted schema = 1, got true"),
    ('title = "A joint"', 'titel = "A joint"', 'titel: unknown key; did you mean "title"?'),
    ('title = "A joint"', "title = 3", "title: wanted one line of at most 200 characters, got 3"),
    ('title = "A joint"', 'title = "a\\nb"', 'title: wanted one line of at most 200 characters, got "a\\nb"'),
    ("[surface]", "[surfaces]", 'surfaces: unknown key; did you mean "surface"?'),
    ("[surface]", "[[surface]]", "surface: wanted a table [surface], got a list of 1"),
    ("[joint]", "[excitement]", 'excitement: unknown key; did you mean "excitation"? (and 1 more error)'),
    ("young_modulus", "youngs_modulus", 'material.al.youngs_modulus: unknown key; did you mean "young_modulus"?'),
    ('young_modulus = "69 GPa"', "", 'material.al.young_modulus: missing; write for example young_modulus = "69 GPa"'),
    ("young_modulus", "radius", 'material.al.young_modulus: missing; write for example young_modulus = "69 GPa" (and 1 more error)'),
    ("[material.al]", "[material]", 'material.young_modulus: wanted a table such as { young_modulus = "69 GPa", poisson_ratio = 0.33 }, got "69 GPa" (and 1 more error)'),
    ("friction_coefficient = 0.55", 'friction_coefficient = 0.55\nradius = "1 mm"', 'joint.radius: unknown key here; it belongs in [surface] with law = "greenwood-williamson"'),
    ("friction_coefficient = 0.55", "friction_coefficient = 0.55\ncolour = 1", "joint.colour: unknown key; the keys here are law, friction_coefficient, normal_load"),
    ("schema = 1", 'schema = 1\nhardness = "1 GPa"', "hardness: unknown key here; it belongs in [material.NAME]"),
    ("heights =", "hights =", 'surface.hights: unknown key; did you mean "heights"?'),
    ("std", "sdt", 'surface.heights.sdt: unknown key; did you mean "std"?'),
    (GAUSSIAN, '"0.5 um"', 'surface.heights: wanted a table such as { kind = "gaussian", std = "0.5 um" }, got "0.5 um"'),
    # laws and kinds
    ('law = "greenwood-williamson"', "", f"surface.law: missing; wanted {LAWS}"),
    ("law =", "lwa =", 'surface.lwa: unknown key; did you mean "law"?'),
    ('"greenwood-williamson"', '"greenwod"', f'surface.law: wanted {LAWS}, got "greenwod"; did you mean "greenwood-williamson"?'),
    ('"greenwood-williamson"', "7", f"surface.law: wanted {LAWS}, got 7"),
    ('"greenwood-williamson"', '"sphere"', 'surface.heights: unknown key here; it belongs in [surface] with law = "greenwood-williamson" (and 2 more errors)'),
    ('"greenwood-williamson"', '"population"', 'surface.heights.kind: wanted "values", got "gaussian" (and 2 more errors)'),
    ('"gaussian"', '"gauss"', 'surface.heights.kind: wanted "gaussian", "exponential", "values", "scipy" or "table", got "gauss"; did you mean "gaussian"?'),
    ("kind", "knd", 'surface.heights.knd: unknown key; did you mean "kind"?'),
    (GAUSSIAN, '{ kind = "values", values = [] }', 'surface.heights.values: wanted a list such as ["0.4 um", "0.7 um"], got an empty list'),
    # materials
    ('["al", "al"]', '["al", "all"]', 'surface.materials, item 2: wanted "al", the materials of this file, or a metal of the table (see "microslip materials"), got "all"; did you mean "al"?'),
    ('["al", "al"]', '["al"]', 'surface.materials: wanted the names of the two bodies such as ["steel", "steel"], got a list of 1'),
    ('["al", "al"]', '"al"', 'surface.materials: wanted the names of the two bodies such as ["steel", "steel"], got "al"'),
    ("poisson_ratio = 0.33", "rigid = true", "material.al.young_modulus: unknown key; a rigid material has no other"),
    ("poisson_ratio = 0.33", 'poisson_ratio = 0.3\nrigid = "no"', 'material.al.rigid: wanted true, got "no" (and 2 more errors)'),
    # plain numbers
    ("0.33", "0.7", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got 0.7"),
    ("0.33", "-1", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got -1"),
    ("0.33", "nan", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got nan"),
    ("0.33", '"0.33"', 'material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got "0.33"'),
    ("0.33", "true", "material.al.poisson_ratio: wanted a number above -1 and at most 0.5, got true"),
    ("0.55", "-0.55", "joint.friction_coefficient: wanted a positive number such as 0.55, got -0.55"),
    ("0.55", "0", "joint.friction_coefficient: wanted a positive number such as 0.55, got 0"),
    ("0.55", "inf", "joint.friction_coefficient: wanted a positive number such as 0.55, got inf"),
    # quantities
    ('"69 GPa"', '"69 um"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 um" (a length)'),
    ('"69 GPa"', "69e9", 'material.al.young_modulus: wanted a pressure such as "69 GPa", got 69000000000.0 (a number without a unit)'),
    ('"69 GPa"', '"69 gpa"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 gpa" (unknown unit "gpa"; did you mean "GPa"?)'),
    ('"69 GPa"', '"-69 GPa"', 'material.al.young_modulus: wanted a positive pressure such as "69 GPa", got "-69 GPa"'),
    ('"69 GPa"', '"inf GPa"', 'material.al.young_modulus: wanted a finite pressure such as "69 GPa", got "inf GPa"'),
    ('"69 GPa"', "1979-05-27", 'material.al.young_modulus: wanted a pressure such as "69 GPa", got the date or time 1979-05-27'),
    ('"0.5 um"', '"0.5 GPa"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5 GPa" (a pressure)'),
    ('"0.5 um"', '"0.5"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5" (no unit)'),
    ('"0.5 um"', '"um"', 'surface.heights.std: wanted a length such as "0.5 um", got "um" (no number)'),
    ('"0.5 um"', '"0,5 um"', 'surface.heights.std: wanted a length such as "0.5 um", got "0,5 um" (the decimal sign is the point, ".")'),
    ('"0.5 um"', '"0 um"', 'surface.heights.std: wanted a positive length such as "0.5 um", got "0 um"'),
    ('"1 mm"', '"1e50 mm"', 'surface.radius: wanted a length such as "1 mm", got "1e50 mm" (outside 1e-40 … 1e40)'),
    ('"1 mm"', '"1 mn"', 'surface.radius: wanted a length such as "1 mm", got "1 mn" (unknown unit "mn"; did you mean "mm"?)'),
    ('"100 1/mm^2"', '"7800 kg/m^3"', 'surface.density: wanted a number per area such as "100 1/mm^2", got "7800 kg/m^3" (a mass per volume)'),
    ('"100 1/mm^2"', '"0 1/mm^2"', 'surface.density: wanted a positive number per area such as "100 1/mm^2", got "0 1/mm^2"'),
    ('"2 cm^2"', '"2 cm2"', 'surface.area: wanted an area such as "2 cm^2", got "2 cm2" (unknown unit "cm2"; did you mean "cm^2"?)'),
    ('"2 cm^2"', '"2 cm"', 'surface.area: wanted an area such as "2 cm^2", got "2 cm" (a length)'),
    (LOADS, '"2 KN"', 'joint.normal_load: wanted a force such as "2 kN", got "2 KN" (unknown unit "KN"; did you mean "kN"?)'),
    (LOADS, '["500 N", 2000]', 'joint.normal_load, item 2: wanted a force such as "2 kN", got 2000 (a number without a unit)'),
    # lists
    (LOADS, "[]", 'joint.normal_load: wanted a list such as ["500 N", "2 kN"], got an empty list'),
    (LOADS, '["1 kN", "2 kN", "1000 N"]', "joint.normal_load: wanted values that differ, got the same one as items 1 and 3"),
    (LOADS, "{ from = 3 }", 'joint.normal_load: wanted a value such as "2 kN", { low = …, high = … }, { mean = …, cv = … } or { values = [ … ] }, got a table with "from"'),
    (AMPLITUDES, '["0.1 um", "0 um"]', 'excitation.amplitudes, item 2: wanted a positive length such as "1 um", got "0 um"'),
    (AMPLITUDES, '["0.1 um", ["1 um"]]', 'excitation.amplitudes, item 2: wanted a length such as "1 um", got a list of 1'),
    (AMPLITUDES, '"1 um"', 'excitation.amplitudes: wanted a list such as ["0.1 um", "1 um"], got "1 um"'),
    (AMPLITUDES, str(1001 * ["1 um"]), "excitation.amplitudes: wanted at most 1000 items, got 1001"),
    ('"100 um"', '"1 nm"', "excitation.curve.to: wanted more than `from` (1 nm), got 1 nm"),
    ('"1 nm"', '"1 m"', "excitation.curve.to: wanted more than `from` (1 m), got 100 µm"),
    ("points = 20", "points = 1", "excitation.curve.points: wanted a whole number from 2 to 1000000, such as 200, got 1"),
    ("points = 20", "points = 20.5", "excitation.curve.points: wanted a whole number from 2 to 1000000, such as 200, got 20.5"),
    ("points = 20", "points = 1_000_001", "excitation.curve.points: wanted a whole number from 2 to 1000000, such as 200, got 1000001"),
    ("points = 20", "points = 1_000_000", "excitation.curve.points: wanted at most 1000000 points in all, got 2000000 (loads times points)"),
    (CURVE, '["1 nm", "1 um"]', 'excitation.curve: wanted a table such as { from = "1 nm", to = "100 um" }, got a list of 2'),
    ('["csv"]', '["cvs"]', 'output.formats, item 1: wanted "netcdf", "csv", "svg", "png" or "pdf", got "cvs"; did you mean "csv"?'),
    ('["csv"]', "[]", 'output.formats: wanted a list such as ["netcdf", "csv", "svg"], got an empty list'),
    # more of TOML
    ("0.55", "0,55", 'line 17, column 25: not TOML: the decimal sign is the point, "."'),
    ("0.55", ".55", "line 17, column 24: not TOML: write a 0 before the point"),
    ('"1 mm"', "1 mm", 'line 12, column 12: not TOML: quantities stand in quotes, such as "2 kN"'),
    ('"1 mm"', '"1 mm', "line 12, column 15: not TOML: a text without its closing quote"),
    ('"1 mm"', "“1 mm”", 'line 12, column 10: not TOML: quotes are straight, as in "2 kN"'),
    ("[joint]", "[material.al]", "line 16, column 13: not TOML: cannot declare [material.al] twice"),
    ("[joint]", '[joint]\nnormal_load = "1 kN"', "line 19, column 32: not TOML: this key is given twice"),
    ("radius", 'radius = "2 mm"\nradius', "line 13, column 16: not TOML: this key is given twice"),
    ("[joint]", "joint:", "line 16, column 6: not TOML: expected '=' after a key in a key/value pair"),
    # more of keys
    ("[joint]", "[Joint]", 'Joint: unknown key; did you mean "joint"?'),
    ("[joint]", "[joint.contact]", "joint.friction_coefficient: missing; write for example friction_coefficient = 0.55 (and 1 more error)"),
    ("[output]", "[outputs]", 'outputs: unknown key; did you mean "output"?'),
    ("[output]", '[output]\nformat = ["csv"]', 'output.format: unknown key; did you mean "formats"?'),
    ("[output]", '[oscilator]\nmass = "2 kg"\n[output]', 'oscilator: unknown key; did you mean "oscillator"?'),
    ('title = "A joint"', 'title = ""', 'title: wanted one line of at most 200 characters, got ""'),
    ("schema = 1", 'schema = "1"', 'schema: wanted schema = 1, got "1"'),
    # more of quantities
    ('"69 GPa"', '"69 GP"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 GP" (of dimension length^-1 mass^1 time^-1; did you mean "GPa"?)'),
    ('"69 GPa"', '"69 kg/mm^2"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 kg/mm^2" (a mass per area)'),
    ('"69 GPa"', '"69 000 MPa"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69 000 MPa" (write the number without spaces)'),
    ('"69 GPa"', '"69.5.1 GPa"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69.5.1 GPa" (more than one decimal point)'),
    ('"69 GPa"', '""', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got ""'),
    ('"69 GPa"', "true", 'material.al.young_modulus: wanted a pressure such as "69 GPa", got true'),
    ('"69 GPa"', '"nan GPa"', 'material.al.young_modulus: wanted a finite pressure such as "69 GPa", got "nan GPa"'),
    ('"69 GPa"', '"69e9 pa"', 'material.al.young_modulus: wanted a pressure such as "69 GPa", got "69e9 pa" (a time; did you mean "Pa"?)'),
    ('"0.5 um"', '"0.5 un"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5 un" (unknown unit "un"; did you mean "um"?)'),
    ('"0.5 um"', '"0.5 mu"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5 mu" (a mass; did you mean "um"?)'),
    ('"0.5 um"', '"0.5 uM"', 'surface.heights.std: wanted a length such as "0.5 um", got "0.5 uM" (a concentration; did you mean "um"?)'),
    ('"0.5 um"', '"-0.5 um"', 'surface.heights.std: wanted a positive length such as "0.5 um", got "-0.5 um"'),
    ('"0.5 um"', "nan", 'surface.heights.std: wanted a length such as "0.5 um", got nan (a number without a unit)'),
    ('"1 mm"', '"1/2 mm"', 'surface.radius: wanted a length such as "1 mm", got "1/2 mm" (write the number as a decimal)'),
    ('"1 mm"', '"1 mm, 2 mm"', 'surface.radius: wanted a length such as "1 mm", got "1 mm, 2 mm" (more than one quantity)'),
    ('"1 mm"', '["1 mm", "2 mm"]', 'surface.radius: wanted a length such as "1 mm", got a list of 2'),
    ('"100 1/mm^2"', '"100 1/mm"', 'surface.density: wanted a number per area such as "100 1/mm^2", got "100 1/mm" (a number per length)'),
    ('"100 1/mm^2"', '"100"', 'surface.density: wanted a number per area such as "100 1/mm^2", got "100" (no unit)'),
    (LOADS, '"2 kn"', 'joint.normal_load: wanted a force such as "2 kN", got "2 kn" (a velocity; did you mean "kN"?)'),
    (LOADS, '"200 kg"', 'joint.normal_load: wanted a force such as "2 kN", got "200 kg" (a mass)'),
    (LOADS, '["500 N", "-2 kN"]', 'joint.normal_load, item 2: wanted a positive force such as "2 kN", got "-2 kN"'),
    (LOADS, '"500..2000 N"', 'joint.normal_load: wanted a force such as "2 kN", got "500..2000 N" (more than one decimal point)'),
    (LOADS, many("N"), "joint.normal_load: wanted at most 1000 items, got 1001"),
    # heights
    (GAUSSIAN, '{ kind = "weibull_min", c = 2 }', 'surface.heights.kind: wanted "gaussian", "exponential", "values", "scipy" or "table", got "weibull_min"; write kind = "scipy", distribution = "weibull_min"'),
    (GAUSSIAN, '{ kind = "values" }', 'surface.heights.values: missing; write for example values = ["0.4 um", "0.7 um"]'),
    (GAUSSIAN, '{ kind = "values", values = [1e-6] }', 'surface.heights.values, item 1: wanted a length such as "0.5 um", got 1e-06 (a number without a unit)'),
    (GAUSSIAN, '{ kind = "values", values = ["1 um"], file = "y.csv" }', "surface.heights.file: wanted values or a file, got both"),
    (GAUSSIAN, '{ kind = "values", values = ["1 um"], unit = "um" }', "surface.heights.unit: wanted only beside file, got values"),
    (GAUSSIAN, '{ kind = "values", file = "y.csv" }', 'surface.heights.column: missing; write for example column = "x"'),
    (GAUSSIAN, '{ kind = "values", column = "y" }', 'surface.heights.file: missing; write for example file = "record.csv"'),
    (GAUSSIAN, '{ kind = "values", fil = "y.csv", column = "y" }', 'surface.heights.fil: unknown key; did you mean "file"?'),
    (GAUSSIAN, '{ kind = "values", file = "y.csv", column = "y" }', "surface.heights: y.csv: no such file in the folder of the study"),
    (GAUSSIAN, '{ kind = "scipy", scale = "1 um" }', 'surface.heights.distribution: missing; write for example distribution = "weibull_min"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm" }', 'surface.heights.scale: missing; write for example scale = "1 um"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "weibul_min", scale = "1 um" }', 'surface.heights.distribution: wanted a continuous distribution of scipy.stats such as "weibull_min", got "weibul_min"; did you mean "weibull_min"?'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "gaussian", scale = "1 um" }', 'surface.heights.distribution: wanted a continuous distribution of scipy.stats such as "weibull_min", got "gaussian"; did you mean "norm"?'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "poisson", scale = "1 um" }', 'surface.heights.distribution: wanted a continuous distribution of scipy.stats such as "weibull_min", got "poisson" (a discrete one)'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "describe", scale = "1 um" }', 'surface.heights.distribution: wanted a continuous distribution of scipy.stats such as "weibull_min", got "describe"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = 3, scale = "1 um" }', 'surface.heights.distribution: wanted the name of a distribution such as "weibull_min", got 3'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "weibull_min", scale = "1 um" }', 'surface.heights.parameters.c: missing; "weibull_min" has the shape parameter "c"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "beta", parameters = { a = 2 }, scale = "1 um" }', 'surface.heights.parameters.b: missing; "beta" has the shape parameters "a" and "b"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm", parameters = { c = 2 }, scale = "1 um" }', 'surface.heights.parameters.c: unknown parameter; "norm" has no shape parameters'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "invgamma", parameters = { alpha = 2 }, scale = "1 um" }', 'surface.heights.parameters.alpha: unknown parameter; "invgamma" has the shape parameter "a"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm", parameters = { loc = 2 }, scale = "1 um" }', 'surface.heights.parameters.loc: wanted location = "1 um" beside distribution instead'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "weibull_min", parameters = { c = -2 }, scale = "1 um" }', "surface.heights.parameters: wanted values that scipy.stats.weibull_min takes, got c = -2 (out of their range)"),
    (GAUSSIAN, '{ kind = "scipy", distribution = "weibull_min", parameters = { c = "2" }, scale = "1 um" }', 'surface.heights.parameters.c: wanted a finite number, got "2"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "weibull_min", parameters = { c = nan }, scale = "1 um" }', "surface.heights.parameters.c: wanted a finite number, got nan"),
    (GAUSSIAN, '{ kind = "scipy", distribution = "weibull_min", parameters = 2, scale = "1 um" }', "surface.heights.parameters: wanted a table such as { c = 2.0 }, got 2"),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm", location = "1 N", scale = "1 um" }', 'surface.heights.location: wanted a length such as "0.5 um", got "1 N" (a force)'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm", scale = 1e-6 }', 'surface.heights.scale: wanted a length such as "0.5 um", got 1e-06 (a number without a unit)'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "norm", scale = "0 um" }', 'surface.heights.scale: wanted a positive length such as "0.5 um", got "0 um"'),
    (GAUSSIAN, '{ kind = "scipy", distribution = "cauchy", scale = "1 um" }', "surface.heights: wanted a finite moment of order 3/2 (the normal load), got a distribution whose tail falls like y^-1 (cauchy)"),
    (GAUSSIAN, '{ kind = "scipy", distribution = "t", parameters = { df = 1.2 }, scale = "1 um" }', "surface.heights: wanted a finite moment of order 3/2 (the normal load), got a distribution whose tail falls like y^-1.2 (t with df = 1.2)"),
    # materials
    (MATERIAL, "", 'surface.materials, item 1: wanted a metal of the table (see "microslip materials") or one described by [material.al], got "al"'),
    (MATERIAL, "[material.all]\n", 'material.all.young_modulus: missing; write for example young_modulus = "69 GPa" (and 1 more error)'),
    (MATERIAL, "[material.al]\nrigid = true\n", "surface.materials: wanted one body that deforms, got two rigid ones"),
    (MATERIAL, "[material.al]\nrigid = false\n", 'material.al.young_modulus: missing; write for example young_modulus = "69 GPa" (and 1 more error)'),
    (MATERIAL, "[material.stel]\npoisson_ratio = 0.3\n", 'material.stel.young_modulus: missing; write for example young_modulus = "69 GPa" (the table of metals has no "stel"; did you mean "steel"?)'),
    (MATERIAL, '[material]\nal = "69 GPa"\n', 'material.al: wanted a table such as { young_modulus = "69 GPa", poisson_ratio = 0.33 }, got "69 GPa"'),
    ('["al", "al"]', '["al", "steal"]', 'surface.materials, item 2: wanted "al", the materials of this file, or a metal of the table (see "microslip materials"), got "steal"; did you mean "steel"?'),
    ('["al", "al"]', '["al", "Steal"]', 'surface.materials, item 2: wanted "al", the materials of this file, or a metal of the table (see "microslip materials"), got "Steal"; did you mean "steel"?'),
    ('["al", "al"]', '["al", "434"]', 'surface.materials, item 2: wanted "al", the materials of this file, or a metal of the table (see "microslip materials"), got "434"; did you mean "steel-4340"?'),
    ('["al", "al"]', '["al", 3]', 'surface.materials, item 2: wanted the name of a body such as "steel", got 3'),
    ('["al", "al"]', '["al", "al", "al"]', 'surface.materials: wanted the names of the two bodies such as ["steel", "steel"], got a list of 3'),
    ("poisson_ratio = 0.33", 'poisson_ratio = 0.33\nhardness = "69 GPa"', "material.al.hardness: wanted less than Young's modulus 69 GPa, got 69 GPa"),
    ('"69 GPa"', '"69 MPa"\nhardness = "1.2 GPa"', "material.al.hardness: wanted less than Young's modulus 69 MPa, got 1.2 GPa"),
    ('"2 cm^2"', '"2 um^2"', "surface.density: wanted at least one summit on the area, got 0.0002 (density times area)"),
    # tables and populations
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["4 kN", "1 kN"]\n', "surface: separation and load must be of one length, at least three, got 3 and 2"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "2 um", "1 um"]\nload = ["4 kN", "1 kN", "0 N"]\n', "surface.separation: must rise, got 2e-06 then 1e-06 at index 2"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["4 kN", "4 kN", "0 N"]\n', "surface.load: must fall, got 4000 then 4000 at index 1"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["4 kN", "1 kN", "0.1 kN"]\n', 'surface.load: must end at zero, got 100 N at the last separation; add the point where contact ends or state tail = "exponential"'),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["4 kN", "1 kN", "-1 N"]\n', "surface.load: must not be negative, got -1 at the end"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["4 kN", "1 kN", "0 N"]\ntail = "exponential"\n', "surface.tail: wanted no tail, since the last load is zero"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["4 kN", "1 kN", "1 N"]\ntail = "exp"\n', 'surface.tail: wanted "exponential", got "exp"; did you mean "exponential"?'),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um"]\nload = ["4 kN", "0 N"]\n', "surface: separation and load must be of one length, at least three, got 2 and 2"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["1 kN", "0.3 kN", "0 N"]\n', "joint.normal_load, item 2: wanted at most the first load of the table, 1 kN, got 2 kN"),
    (SURFACE, 'law = "table"\nseparation = { file = "d.csv", colum = "d" }\nload = ["4 kN", "1 kN", "0 N"]\n', 'surface.separation.colum: unknown key; did you mean "column"?'),
    (SURFACE, 'law = "table"\nseparation = { file = "d.csv", column = "d" }\nload = ["4 kN", "1 kN", "0 N"]\n', "surface.separation: d.csv: no such file in the folder of the study"),
    (SURFACE, 'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = { file = "d.csv" }\n', 'surface.load.column: missing; write for example column = "x"'),
    (SURFACE, 'law = "table"\nseparation = ["0 um", 1, "2 um"]\nload = ["4 kN", "1 kN", "0 N"]\n', 'surface.separation, item 2: wanted a length such as "0.5 um", got 1 (a number without a unit)'),
    (SURFACE, 'law = "population"\nheights = { kind = "values", values = ["1 um", "2 um"] }\nradius = ["1 mm", "2 mm", "3 mm"]\n', "surface.radius: wanted one radius, or one for each of the 2 heights, got 3"),
    (SURFACE, 'law = "population"\nheights = { kind = "scipy", distribution = "norm", scale = "1 um" }\nradius = "1 mm"\n', 'surface.heights.kind: wanted "values", got "scipy"'),
    (SURFACE, 'law = "population"\nheights = { values = ["1 um"] }\nradius = "1 mm"\n', 'surface.heights.kind: missing; wanted "values"'),
    (SURFACE, 'law = "population"\nheights = ["1 um"]\nradius = "1 mm"\n', 'surface.heights: wanted a table such as { kind = "values", values = ["0.4 um", "0.7 um"] }, got a list of 1'),
    (SURFACE, 'law = "population"\nheights = { kind = "values", values = ["1 um"] }\nradius = "-1 mm"\n', 'surface.radius: wanted a positive length such as "1 mm", got "-1 mm"'),
    (SURFACE, 'law = "sphere"\n', 'surface.radius: missing; write for example radius = "5 mm"'),
    (SURFACE, 'law = "sphere"\nradius = { file = "r.csv", column = "r" }\n', 'surface.radius: wanted a length such as "5 mm", got a table'),
    # excitation
    (LINE, 'amplitudes = ["100 N"]', 'excitation.amplitudes, item 1: wanted a length such as "1 um", got "100 N" (a force)'),
    (LINE, "force_amplitudes = []", 'excitation.force_amplitudes: wanted a list such as ["50 N", "200 N"], got an empty list'),
    (LINE, 'force_amplitudes = "100 N"', 'excitation.force_amplitudes: wanted a list such as ["50 N", "200 N"], got "100 N"'),
    (LINE, 'force_amplitudes = ["100 um"]', 'excitation.force_amplitudes, item 1: wanted a force such as "100 N", got "100 um" (a length)'),
    (LINE, 'force_amplitudes = ["-100 N"]', 'excitation.force_amplitudes, item 1: wanted a positive force such as "100 N", got "-100 N"'),
    (LINE, 'force_amplitudes = ["100 N", "0.1 kN"]', "excitation.force_amplitudes: wanted values that differ, got the same one as items 1 and 2"),
    (LINE, 'force_amplitudes = ["100 N", "275 N"]', "excitation.force_amplitudes, item 2: wanted less than the force limit 275 N at the load 500 N, got 275 N"),
    (LINE, 'force_amplitudes = ["2 kN"]', "excitation.force_amplitudes, item 1: wanted less than the force limit 275 N at the load 500 N, got 2 kN"),
    (LINE, 'force_amplitude = ["100 N"]', 'excitation.force_amplitude: unknown key; did you mean "force_amplitudes"?'),
    (LINE, 'amplitudes = ["0.1 um", "1 um"]\nforce_amplitudes = ["100 N"]', "excitation.force_amplitudes: wanted amplitudes or force_amplitudes, got both; remove one"),
    (LINE, 'amplitudes = ["1 um", "1000 nm"]', "excitation.amplitudes: wanted values that differ, got the same one as items 1 and 2"),
    (LINE, f"force_amplitudes = {many('mN')}", "excitation.force_amplitudes: wanted at most 1000 items, got 1001"),
    (LINE, 'history = "x.csv"', 'excitation.history: wanted a table such as { file = "record.csv", column = "x" }, got "x.csv"'),
    (LINE, "history = {}", 'excitation.history.file: missing; write for example file = "record.csv" (and 1 more error)'),
    (LINE, 'history = { file = "x.csv" }', 'excitation.history.column: missing; write for example column = "x"'),
    (LINE, 'history = { file = "", column = "x" }', 'excitation.history.file: wanted the name of a CSV file such as "record.csv", got ""'),
    (LINE, 'history = { file = "x.csv", column = 2 }', 'excitation.history.column: wanted the name of a column such as "x", got 2'),
    (LINE, 'history = { file = "x.csv", colunm = "x" }', 'excitation.history.colunm: unknown key; did you mean "column"?'),
    (LINE, 'history = { file = "x.csv", column = "x", unit = "" }', 'excitation.history.unit: wanted a unit such as "um", got ""'),
    (LINE, 'history = { file = "x.csv", column = "x", quantity = "forces" }', 'excitation.history.quantity: wanted "displacement" or "force", got "forces"; did you mean "force"?'),
    (LINE, 'history = { file = "missing.csv", column = "x" }', "excitation.history: missing.csv: no such file in the folder of the study"),
    (LINE, 'history = { file = ".", column = "x" }', "excitation.history: .: wanted a CSV file, got a folder"),
    # oscillator and output
    ("[output]", '[oscillator]\nmass = "2 kg"\n[output]', 'oscillator.stiffness: missing; write for example stiffness = "1e6 N/m"'),
    ("[output]", '[oscillator]\nstiffness = "1e6 N/m"\n[output]', 'oscillator.mass: missing; write for example mass = "2 kg"'),
    ("[output]", '[oscillator]\nmass = "2 N"\nstiffness = "1e6 N/m"\n[output]', 'oscillator.mass: wanted a mass such as "2 kg", got "2 N" (a force)'),
    ("[output]", '[oscillator]\nmass = "0 kg"\nstiffness = "1e6 N/m"\n[output]', 'oscillator.mass: wanted a positive mass such as "2 kg", got "0 kg"'),
    ("[output]", '[oscillator]\nmass = "2 Kg"\nstiffness = "1e6 N/m"\n[output]', 'oscillator.mass: wanted a mass such as "2 kg", got "2 Kg" (unknown unit "Kg"; did you mean "kg"?)'),
    ("[output]", '[oscillator]\nmass = 2\nstiffness = "1e6 N/m"\n[output]', 'oscillator.mass: wanted a mass such as "2 kg", got 2 (a number without a unit)'),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N"\n[output]', 'oscillator.stiffness: wanted a stiffness such as "1e6 N/m", got "1e6 N" (a force)'),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "-1 N/um"\n[output]', 'oscillator.stiffness: wanted a stiffness of zero or more [N/m], got "-1 N/um"'),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N/mn"\n[output]', 'oscillator.stiffness: wanted a stiffness such as "1e6 N/m", got "1e6 N/mn" (unknown unit "N/mn"; did you mean "N/mm"?)'),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N/m"\nviscous_damping_ratio = 1\n[output]', "oscillator.viscous_damping_ratio: wanted a number from 0 to below 1 such as 0.01, got 1"),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N/m"\nviscous_damping_ratio = -0.01\n[output]', "oscillator.viscous_damping_ratio: wanted a number from 0 to below 1 such as 0.01, got -0.01"),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N/m"\nviscous_damping_ratio = nan\n[output]', "oscillator.viscous_damping_ratio: wanted a number from 0 to below 1 such as 0.01, got nan"),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N/m"\nviscous_damping_ratio = "1 %"\n[output]', 'oscillator.viscous_damping_ratio: wanted a number from 0 to below 1 such as 0.01, got "1 %"'),
    ("[output]", '[oscillator]\nmass = "2 kg"\nstiffness = "1e6 N/m"\ndamping_ratio = 0.01\n[output]', 'oscillator.damping_ratio: unknown key; did you mean "viscous_damping_ratio"?'),
    ("[output]", '[[oscillator]]\nmass = "2 kg"\n[output]', 'oscillator: wanted a table such as [oscillator] with mass = "2 kg" and stiffness = "1e6 N/m", got a list of 1'),
    ('["csv"]', '["netCDF"]', 'output.formats, item 1: wanted "netcdf", "csv", "svg", "png" or "pdf", got "netCDF"; did you mean "netcdf"?'),
    ('["csv"]', '["gif"]', 'output.formats, item 1: wanted "netcdf", "csv", "svg", "png" or "pdf", got "gif"'),
    ('["csv"]', '"csv"', 'output.formats: wanted a list such as ["netcdf", "csv", "svg"], got "csv"'),
    ('["csv"]', '["csv", "csv"]', "output.formats: wanted values that differ, got the same one as items 1 and 2"),
    ('["csv"]', '["csv", 3]', 'output.formats, item 2: wanted "netcdf", "csv", "svg", "png" or "pdf", got 3'),
    ('["csv"]', '["csv"]\nreport = "yes"', 'output.report: wanted true or false, got "yes"'),
    ('["csv"]', '["csv"]\nreport = 1', "output.report: wanted true or false, got 1"),
]  # fmt: skip


@pytest.mark.parametrize("part", range(4))
def test_each_wrong_study_gets_its_own_line(part: int, tmp_path: Path) -> None:
    for old, new, message in WRONG[part::4]:
        with pytest.raises(ms.StudyError) as caught:
            ms.Study.from_toml(edited((old, new)), "joint.toml", folder=tmp_path)
        says(str(caught.value).removeprefix("joint.toml: "), message)


def test_the_first_of_several_errors_is_named_and_the_others_counted() -> None:
    text = edited(('"69 GPa"', '"69"'), ("0.33", "7"), ("std", "sdt"), ("0.55", "0"))
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text, "joint.toml")
    assert str(caught.value) == (
        'joint.toml: material.al.young_modulus: wanted a pressure such as "69 GPa", '
        'got "69" (no unit) (and 3 more errors)'
    )


def test_a_flood_of_keys_is_refused_at_once() -> None:
    keys = "".join(f"key_{i} = 1\n" for i in range(400_000))
    names = "".join(f"m{i} = {{ rigid = true }}\n" for i in range(50_000))
    begin = time.process_time()
    for text, start, end in (
        (f"{keys}{STUDY}", "key_0: unknown key; ", "(and 399999 more errors)"),
        (
            f"{edited((MATERIAL, ''))}\n[material]\n{names}",
            "material: wanted at most 1000 names",
            "50000",
        ),
    ):
        with pytest.raises(ms.StudyError) as caught:
            ms.Study.from_toml(text, "joint.toml")
        message = str(caught.value).removeprefix("joint.toml: ")
        assert (message.startswith(start), message.endswith(end)) == (True, True)
    assert time.process_time() - begin < 20.0  # without a limit on hints it is minutes


def test_an_empty_study_is_told_how_to_begin(tmp_path: Path) -> None:
    for text in ("", "\n\n", "# only a comment"):
        (tmp_path / "joint.toml").write_text(text)
        assert message_of(tmp_path / "joint.toml") == (
            f"{tmp_path / 'joint.toml'}: wanted a study, got none; microslip new NAME.toml writes one"
        )


# What only the numbers tell. -----------------------------------------------------------------


def refused(**changes: Any) -> str:
    """The message of a study in Python, its `study: ` taken off."""
    surface = {"law": "sphere", "materials": ("steel", "al2017"), "radius": "5 mm"}
    joint = {"friction_coefficient": 0.2, "normal_load": ("1 N", "2 N")}
    with pytest.raises(ms.StudyError) as caught:
        ms.Study(**{"schema": 1, "surface": surface, "joint": joint, **changes})
    return str(caught.value).removeprefix("study: ")


TOO_MUCH = [
    ("amplitudes", [f"{i} nm" for i in range(1, 1001)], "excitation.amplitudes: wanted at most 2000 loops, got 3000 (loads times amplitudes)"),
    ("force_amplitudes", [f"{i} uN" for i in range(1, 1001)], "excitation.force_amplitudes: wanted at most 2000 loops, got 3000 (loads times amplitudes)"),
    ("curve", {"from": "1 nm", "to": "1 um", "points": 400_000}, "excitation.curve.points: wanted at most 1000000 points in all, got 1200000 (loads times points)"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value", "message"), TOO_MUCH)
def test_too_much_to_compute_is_counted(key: str, value: object, message: str) -> None:
    joint = {"friction_coefficient": 0.2, "normal_load": ["1 N", "2 N", "3 N"]}
    assert refused(joint=joint, excitation={key: value}) == message


def test_a_history_is_as_long_as_memory_bears(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "x.csv").write_text("x [um]\n" + 60 * "1\n-1\n")
    joint = {"friction_coefficient": 0.2, "normal_load": ["1 N", "2 N"]}
    excitation = {"history": {"file": str(tmp_path / "x.csv"), "column": "x"}}
    monkeypatch.setattr("microslip.study.sense.MAX_SAMPLES", 200)
    assert refused(joint=joint, excitation=excitation) == (
        "excitation.history: wanted at most 200 samples in all, got 240 (loads times rows)"
    )
    monkeypatch.setattr("microslip.study.columns.MAX_ROWS", 100)
    assert refused(joint=joint, excitation=excitation) == (
        f"excitation.history: {tmp_path / 'x.csv'}: wanted at most 100 rows, got more"
    )


IN_PYTHON = [
    ({"title": None}, "title: wanted one line of at most 200 characters, got None"),
    ({"schema": 2}, "schema: wanted schema = 1, got 2"),
    ({"titel": "x"}, 'titel: unknown key; did you mean "title"?'),
    ({"joint": None}, "joint: wanted a table such as { friction_coefficient = 0.55 }, got None"),
    ({"joint": {"friction_coefficient": 0.2, "normal_load": 3.0}}, 'joint.normal_load: wanted a force such as "2 kN", got 3.0 (a number without a unit)'),
    ({"joint": {"friction_coefficient": 0.2, "normal_load": ("1 N", b"2 N")}}, 'joint.normal_load, item 2: wanted a force such as "2 kN", got b\'2 N\''),
    ({"joint": {"friction_coefficient": 10**400, "normal_load": "1 N"}}, f"joint.friction_coefficient: wanted a number above zero such as 0.55, got 1{38 * '0'}…"),
    ({"joint": {"friction_coefficient": 10**5000, "normal_load": "1 N"}}, "joint.friction_coefficient: wanted a number above zero such as 0.55, got an integer of thousands of digits"),
    ({"material": 3}, 'material: wanted a table such as { mine = { young_modulus = "69 GPa", poisson_ratio = 0.33 } }, got 3'),
    ({"material": {"x": None}}, 'material.x: wanted a table such as { young_modulus = "69 GPa", poisson_ratio = 0.33 }, got None'),
    ({"surface": {"law": "sphere", "materials": ("steel", "wood"), "radius": "5 mm"}}, 'surface.materials, item 2: wanted a metal of the table (see "microslip materials") or one described by [material.wood], got "wood"'),
    ({"excitation": {"history": {"file": "no such.csv", "column": "x"}}}, "excitation.history: no such.csv: no such file"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), IN_PYTHON)
def test_a_wrong_study_in_python_gets_the_same_line(changes: Any, message: str) -> None:
    assert refused(**changes) == message


def test_keys_are_text() -> None:
    assert refused(joint={1: 2, "friction_coefficient": 0.2, "normal_load": "1 N"}).startswith(
        "joint"
    )
    assert refused(material={1: {"rigid": True}}).startswith("material")


def test_parts_are_text_in_python_too() -> None:
    joint = ms.Study.from_toml(STUDY).joint
    assert refused(joint=joint).startswith("joint: wanted a table")


# -- columns of files -----------------------------------------------------------------------

# The file, what the history says besides its name, and the message that follows.
COLUMNS = [
    ("", 'column = "x"', "wanted rows of numbers, got none"),
    ("# nothing\n\n", 'column = "x"', "wanted rows of numbers, got none"),
    ("x [um]\n", 'column = "x"', "wanted rows of numbers, got none"),
    ("x [um]\n1\n", 'column = "x"', "wanted at least two rows, got one"),
    ("0,1\n1,2\n", 'column = "x"', 'no column "x"; the columns have no names; they are "#1" and "#2"'),
    ("x [um],F [N]\n0,1\n1,2\n", 'column = "y"', 'no column "y"; the columns are "x [um]" and "F [N]"'),
    ("displacement [um],F [N]\n0,1\n1,2\n", 'column = "displcement"', 'no column "displcement"; did you mean "displacement"?'),
    ("x [um],x [mm]\n0,1\n1,2\n", 'column = "x"', '2 columns are called "x", "x [um]" and "x [mm]"; write "x [um]"'),
    ("x,F\n0,1\n1,2\n", 'column = "x"', 'column "x": no unit; write it in the header, such as "[um]", or unit = "um"'),
    ("x [N]\n0\n1\n", 'column = "x"', 'column "x [N]": wanted a unit such as "um", got "N" (a force)'),
    ("x (left)\n0\n1\n", 'column = "x"', 'column "x (left)": no unit; write it in the header, such as "[um]", or unit = "um"'),
    ("x [un]\n0\n1\n", 'column = "x"', 'column "x [un]": wanted a unit such as "um", got "un" (unknown unit "un"; did you mean "um"?)'),
    ("x\n0\n1\n", 'column = "x", unit = "N"', 'column "x": wanted a unit such as "um", got "N" (a force)'),
    ("x\n0\n1\n", 'column = "x", unit = "uM"', 'column "x": wanted a unit such as "um", got "uM" (a concentration; did you mean "um"?)'),
    ("x [um]\n0\n1\n", 'column = "x", unit = "mm"', 'column "x [um]": wanted unit = "um" as in the header, or no unit, got "mm"'),
    ("x [um]\n0\nabc\n", 'column = "x"', 'line 3, column "x [um]": wanted a number, got "abc"'),
    ("# rig 3\nx [um]\n0\n\n-\n", 'column = "x"', 'line 5, column "x [um]": wanted a number, got "-"'),
    ("x [um]\n0\nnan\n", 'column = "x"', 'line 3, column "x [um]": wanted a number, got "nan"'),
    ("x [um]\n0\ninf\n", 'column = "x"', 'line 3, column "x [um]": wanted a number, got "inf"'),
    ("x [um],F\n0,1\n,2\n", 'column = "x"', 'line 3, column "x [um]": wanted a number, got ""'),
    ("x,F\n0,1\num,2\n1,2\n2,3", 'column = "x", unit = "um"', 'line 3, column "x": wanted a number, got "um" (a unit stands in the header, "x [um]")'),
    ("x [um]\n0\n1e999\n", 'column = "x"', 'line 3, column "x [um]": wanted a number, got "1e999" (outside 1e-40 … 1e40)'),
    ("x [um];F\n0,5;1\n1,5;1\n1.5;2\n", 'column = "x"', 'line 4, column "x [um]": wanted a number, got "1.5" (the decimal sign of the lines above is ",")'),
    ("x [um];F\n1.234,5;1\n", 'column = "x"', 'line 2, column "x [um]": wanted a number, got "1.234,5" (write numbers without signs between thousands)'),
    ("x [um]\n1\n0x10\n", 'column = "x"', 'line 3, column "x [um]": wanted a number, got "0x10"'),
    ("x [um]\n1_000\n1\n", 'column = "x"', 'no column "x"; the columns are "1_000"'),
    ("x [um],F\n0,1\n2\n", 'column = "x"', 'line 3: wanted 2 cells as in line 2, got 1, "2"'),
    ("x [um],F\n0,1\n1,2\n2,3,4\n", 'column = "x"', "line 4: wanted 2 cells as in line 2, got 3"),
    ('x [um],F\n"0,1\n2,3\n', 'column = "x"', 'no column "x"; the columns have no names; they are "#1" and "#2"'),
    ("F [N]\n0\n275\n", 'column = "F", quantity = "force"', "wanted forces within ±275 N, the force limit at the load 500 N, got 275 N"),
    ("F [kN]\n0\n-0.4\n", 'column = "F", quantity = "force"', "wanted forces within ±275 N, the force limit at the load 500 N, got -400 N"),
    ("F [um]\n0\n1\n", 'column = "F", quantity = "force"', 'column "F [um]": wanted a unit such as "N", got "um" (a length)'),
]  # fmt: skip


@pytest.mark.parametrize(("content", "entry", "message"), COLUMNS)
def test_each_wrong_column_gets_its_own_line(
    content: str, entry: str, message: str, tmp_path: Path
) -> None:
    (tmp_path / "x.csv").write_text(content, encoding="utf-8")
    text = edited((LINE, f'history = {{ file = "x.csv", {entry} }}'))
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text, "joint.toml", folder=tmp_path)
    says(str(caught.value).removeprefix("joint.toml: "), f"excitation.history: x.csv: {message}")


BYTES = [
    (bytes(range(256)), "wanted rows of numbers, got none"),
    (b"PK\x03\x04" + bytes(range(99)), "wanted rows of numbers, got none"),
]  # fmt: skip


@pytest.mark.parametrize(("content", "message"), BYTES)
def test_a_column_of_a_file_that_is_no_text(content: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_bytes(content)
    text = edited((LINE, 'history = { file = "x.csv", column = "x" }'))
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text, "joint.toml", folder=tmp_path)
    says(str(caught.value).removeprefix("joint.toml: "), f"excitation.history: x.csv: {message}")


def test_a_missing_column_file_is_named_with_the_nearest_one(tmp_path: Path) -> None:
    (tmp_path / "record.csv").write_text("x [um]\n1\n2\n")
    text = edited((LINE, 'history = { file = "recrod.csv", column = "x" }'))
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text, "joint.toml", folder=tmp_path)
    assert str(caught.value) == (
        "joint.toml: excitation.history: recrod.csv: no such file in the folder of the study; "
        'did you mean "record.csv"?'
    )


def test_wrong_radii_and_loads_in_a_file_are_placed(tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("r [mm],d [um],N [N]\n1,0,4e3\n-2,1,4e3\n3,2,0\n")
    for surface, message in (
        (
            'law = "population"\nheights = { kind = "values", values = ["0 um"] }\n'
            'radius = { file = "r.csv", column = "r" }\n',
            'surface.radius: r.csv: line 3, column "r [mm]": wanted a positive length, got "-2"',
        ),
        (
            'law = "table"\nseparation = { file = "r.csv", column = "d" }\n'
            'load = { file = "r.csv", column = "N" }\n',
            "surface.load: must fall, got 4000 then 4000 at index 1",
        ),
    ):
        with pytest.raises(ms.StudyError) as caught:
            ms.Study.from_toml(edited((SURFACE, surface)), "joint.toml", folder=tmp_path)
        assert str(caught.value) == f"joint.toml: {message}"


# -- overrides --------------------------------------------------------------------------------

OVERRIDES = [
    ("joint.normal_load", 'override "joint.normal_load": wanted KEY=VALUE such as joint.normal_load="3 kN"'),
    ("=3 kN", 'override "=3 kN": wanted a key such as joint.normal_load before "=", got ""'),
    ("joint.normal_load=", 'override "joint.normal_load=": no value; wanted KEY=VALUE such as joint.normal_load="3 kN"'),
    ("joint normal_load=3 kN", 'override "joint normal_load=3 kN": wanted a key such as joint.normal_load before "=", got "joint normal_load"'),
    ("--set joint.normal_load=3 kN", 'override "--set joint.normal_load=3 kN": wanted a key such as joint.normal_load before "=", got "--set joint.normal_load"'),
    ("joint.normal_load=[1 kN, 3 kN]", 'override "joint.normal_load=[1 kN, 3 kN]": its value is not TOML; in a shell put single quotes around all of it, joint.normal_load=["1 kN", "3 kN"]'),
    ('joint.normal_load="3 kN', 'override "joint.normal_load="3 kN": its value is not TOML; in a shell put single quotes around all of it, joint.normal_load=["1 kN", "3 kN"]'),
    ("joint.normal_load[0]=3 kN", 'override "joint.normal_load[0]=3 kN": no item of a list can be set; give all of the list, such as joint.normal_load=["1 kN", "3 kN"]'),
    ("joint.normal_load.0=3 kN", 'override "joint.normal_load.0=3 kN": no item of a list can be set; give all of the list, joint.normal_load=[…]'),
    ("title.text=x", 'override "title.text=x": title is "A joint" and has no keys; write title=VALUE'),
    ("surface.heights.std.value=1 um", 'override "surface.heights.std.value=1 um": surface.heights.std is "0.5 um" and has no keys; write surface.heights.std=VALUE'),
    ("joint.normal_lod=3 kN", 'joint.normal_lod (override "joint.normal_lod=3 kN"): unknown key; did you mean "normal_load"?'),
    ("joimt.normal_load=3 kN", 'joimt (override "joimt.normal_load=3 kN"): unknown key; did you mean "joint"?'),
    ("joint.normal_load=3000", 'joint.normal_load (override "joint.normal_load=3000"): wanted a force such as "2 kN", got 3000 (a number without a unit)'),
    ("joint.normal_load=3 um", 'joint.normal_load (override "joint.normal_load=3 um"): wanted a force such as "2 kN", got "3 um" (a length)'),
    ("joint.normal_load==3 kN", 'joint.normal_load (override "joint.normal_load==3 kN"): wanted a force such as "2 kN", got "=3 kN" (no number)'),
    ("joint=3 kN", 'joint (override "joint=3 kN"): wanted a table [joint], got "3 kN"'),
    ("schema=2", 'schema (override "schema=2"): wanted schema = 1, got 2'),
    ("surface.heights.std=1 un", 'surface.heights.std (override "surface.heights.std=1 un"): wanted a length such as "0.5 um", got "1 un" (unknown unit "un"; did you mean "um"?)'),
    ('surface.heights={kind = "gaussian"}', 'surface.heights.std (override "surface.heights={kind = "gaussian"}"): missing; write for example std = "0.5 um"'),
    ("surface.law=sphere", 'surface.heights (override "surface.law=sphere"): unknown key here; it belongs in [surface] with law = "greenwood-williamson" (and 2 more errors)'),
    ("material.iron.poisson_ratio=0.26", 'material.iron.young_modulus (override "material.iron.poisson_ratio=0.26"): missing; write for example young_modulus = "69 GPa" (the table of metals has no "iron"; did you mean "grey-iron"?)'),
    ("material.al.poisson_ratio=0,3", 'material.al.poisson_ratio (override "material.al.poisson_ratio=0,3"): wanted a number above -1 and at most 0.5, got "0,3"'),
    ("oscillator.mass=2 kg", 'oscillator.stiffness (override "oscillator.mass=2 kg"): missing; write for example stiffness = "1e6 N/m"'),
    ("output.formats=csv", 'output.formats (override "output.formats=csv"): wanted a list such as ["netcdf", "csv", "svg"], got "csv"'),
    ("output.report=no", 'output.report (override "output.report=no"): wanted true or false, got "no"'),
    ("excitation.amplitudes=[]", 'excitation.amplitudes (override "excitation.amplitudes=[]"): wanted a list such as ["0.1 um", "1 um"], got an empty list'),
    ('excitation.amplitudes=["1 um", "1 N"]', 'excitation.amplitudes, item 2 (override "excitation.amplitudes=["1 um", "1 N"]"): wanted a length such as "1 um", got "1 N" (a force)'),
    ('surface.materials=["al", "steal"]', 'surface.materials, item 2 (override "surface.materials=["al", "steal"]"): wanted "al", the materials of this file, or a metal of the table (see "microslip materials"), got "steal"; did you mean "steel"?'),
]  # fmt: skip


@pytest.mark.parametrize(("override", "message"), OVERRIDES)
def test_each_wrong_override_gets_its_own_line(override: str, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(STUDY, "joint.toml", overrides=[override])
    says(str(caught.value).removeprefix("joint.toml: "), message)


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        (
            "joint=3",
            'overrides: wanted a list such as [\'joint.normal_load="3 kN"\'], got "joint=3"',
        ),
        (3, "overrides: wanted a list such as ['joint.normal_load=\"3 kN\"'], got 3"),
        ([3], "override: wanted a text such as 'joint.normal_load=\"3 kN\"', got 3"),
    ],
)
def test_overrides_are_texts(overrides: Any, message: str) -> None:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(STUDY, "joint.toml", overrides=overrides)
    assert str(caught.value) == f"joint.toml: {message}"


# -- what only the physics sees ---------------------------------------------------------------


def test_what_the_physics_refuses_is_blamed_on_its_key() -> None:
    table = (
        'law = "table"\nseparation = ["0 um", "1 um", "2 um"]\nload = ["2 kN", "1.9 kN", "0 N"]\n'
    )
    with pytest.raises(ms.StudyError, match=r"^joint.toml: surface.load: must be convex"):
        ms.Study.from_toml(edited((SURFACE, table)), "joint.toml")


# -- the file itself ------------------------------------------------------------------------


def message_of(path: Path) -> str:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.load(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_missing_file_is_named_with_the_nearest_one(tmp_path: Path) -> None:
    (tmp_path / "joint.toml").write_text(STUDY)
    path = tmp_path / "jiont.toml"
    assert message_of(path) == f'{path}: no such file; did you mean "joint.toml"?'
    path = tmp_path / "x" / "joint.toml"
    assert message_of(path) == f"{path}: no such file"


def test_a_folder_is_no_study(tmp_path: Path) -> None:
    assert message_of(tmp_path) == f"{tmp_path}: wanted a study file, got a folder"


def test_a_file_that_is_not_utf8_is_located(tmp_path: Path) -> None:
    path = tmp_path / "joint.toml"
    path.write_bytes(STUDY.replace("A joint", "Füge").encode("latin-1"))
    assert message_of(path) == (
        f"{path}: line 2: not UTF-8 text (byte 0xfc); save the file as UTF-8"
    )


def test_an_unreadable_file_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    path = tmp_path / "joint.toml"
    path.write_text(STUDY)
    monkeypatch.setattr(Path, "open", refuse)
    assert message_of(path) == f"{path}: cannot be read: permission denied"


def test_odd_paths_and_sizes_are_reported(tmp_path: Path) -> None:
    assert "cannot be read" in message_of(tmp_path / ("x" * 300))
    assert "cannot be read" in message_of(Path("a\0b"))
    assert "nested too deeply" in message_of_text("a = " + 100_000 * "[")
    if Path("/dev/zero").exists():
        assert message_of(Path("/dev/zero")) == "/dev/zero: wanted a study of at most 64 MB"


def message_of_text(text: str) -> str:
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(text)
    return str(caught.value)


def test_a_distribution_that_scipy_cannot_compute_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(_: object) -> None:
        raise OverflowError("math range error")

    heights = '{ kind = "scipy", distribution = "t", parameters = { df = 3 }, scale = "1 um" }'
    monkeypatch.setattr("microslip.study.heights.Statistical", fail)
    with pytest.raises(ms.StudyError) as caught:
        ms.Study.from_toml(edited((GAUSSIAN, heights)), "joint.toml")
    assert str(caught.value) == (
        "joint.toml: surface.heights: SciPy fails for t with df = 3: math range error"
    )
