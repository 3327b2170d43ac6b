"""Floor 8: studies to begin with: one that comes with the package, and commented new ones."""

from __future__ import annotations

import json
import re
import shlex
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

from microslip._core.files import reason
from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.errors import StudyError

SCHEMA_FILE = "study.schema.json"
"""Where editors find the JSON Schema of studies, if somebody has put it beside them."""

_HEAD = """\
# A study for microslip, which runs as it is:
#
#   microslip check {command}     its units, joint and validity, and no files
#   microslip predict {command}   tables, figures and a report
#
# Each quantity stands in quotes with its unit: "0.5 um", "2 kN", "100 1/mm^2"; any unit will do.
# Whatever follows a # is a comment; take the # of a line away to use its key.

schema = 1  # version of this format
title = {title}

# `microslip materials` lists the metals that can be named as they are, such as "steel" or "al2017".
# Others, and numbers of your own, which win, stand here, each under a name of your choice:
# [material.mine]
# young_modulus = "110 GPa"
# poisson_ratio = 0.26
# hardness = "2 GPa"  # optional: changes no result, warns of plastic summits
"""

_SURFACES = {
    "greenwood-williamson": """
[surface]
law = "greenwood-williamson"  # many summits of one radius, their heights at random
materials = ["steel", "steel"]  # the two bodies
heights = { kind = "gaussian", std = "0.5 um" }  # of the summits; or one of these:
# heights = { kind = "exponential", scale = "0.5 um" }
# heights = { kind = "scipy", distribution = "gumbel_r", scale = "0.5 um" }
# heights = { kind = "values", file = "heights.csv", column = "y [um]" }
radius = "0.5 mm"  # of the summits
density = "200 1/mm^2"  # summits per apparent area
area = "4 cm^2"  # apparent area
# Or all of it from a scan of the surface: `microslip surface` writes such a block.
""",
    "population": """
[surface]
law = "population"  # given summits, one by one
materials = ["steel", "steel"]  # the two bodies
radius = "2 mm"  # of all summits, or a list of one for each of them

[surface.heights]  # of the summits; the highest ones touch first
kind = "values"
values = [
    "4.0 um", "3.7 um", "3.5 um", "3.1 um", "2.9 um", "2.8 um", "2.2 um", "1.9 um",
    "1.1 um", "0.6 um", "0.3 um", "-0.4 um",
]
# instead of values, a column of a CSV file:
# file = "heights.csv"
# column = "y [um]"
""",
    "sphere": """
[surface]
law = "sphere"  # one sphere on a flat
materials = ["tool-steel", "tool-steel"]  # the two bodies; soft steel yields under these loads
radius = "5 mm"  # of the sphere
""",
    "table": """
[surface]
law = "table"  # a measured or computed normal law
materials = ["steel", "steel"]  # the two bodies
separation = ["0 um", "0.2 um", "0.5 um", "0.9 um", "1.4 um"]  # rising
load = ["6 kN", "4 kN", "2 kN", "0.8 kN", "0.2 kN"]  # falling, ever more slowly
tail = "exponential"  # how it goes on; leave it out where the last load is "0 N"
# or columns of a CSV file:
# separation = { file = "normal.csv", column = "d [um]" }
# load = { file = "normal.csv", column = "N [kN]" }
""",
}

# The largest load that a joint has carried: soft steel has yielded at its summits by then.
_TIGHTENED = {"greenwood-williamson": "4 kN", "population": "500 N"}

# Loads, force amplitudes, stiffness of the oscillator; amplitudes, range of the curve.
_NUMBERS = {
    "greenwood-williamson": ("500 N", "2 kN", "30 N", "100 MN/m", "5 nm", "50 nm", "0.5 um"),
    "population": ("50 N", "200 N", "5 N", "5 MN/m", "0.05 um", "0.2 um", "2 um"),
    "sphere": ("5 N", "20 N", "0.5 N", "1 MN/m", "20 nm", "0.1 um", "1 um"),
    "table": ("500 N", "2 kN", "30 N", "100 MN/m", "0.05 um", "0.2 um", "1 um"),
}

_TAIL = """
[joint]
friction_coefficient = 0.2
normal_load = ["{light}", "{heavy}"]  # one joint for each; or a single one, "{heavy}"
{tightened}
[excitation]  # all of it may be left out: the joint has a scale of its own
amplitudes = ["{small}", "{middle}", "{large}"]  # one loop each, at every load
# force_amplitudes = ["{force}"]  # instead of amplitudes
# load_variation = {{ share = 0.3, phase = "90 deg" }}  # the normal load breathes over each cycle
curve = {{ from = "1 nm", to = "10 um", points = 200 }}  # of the curves, evenly on a log axis
# history = {{ file = "record.csv", column = "x [um]" }}  # a motion of your own, from rest

# [oscillator]  # what the joint does to a mass on a spring
# mass = "2 kg"
# stiffness = "{spring}"  # of the spring beside the joint
# viscous_damping_ratio = 0.005  # of all but the joint

[output]
formats = ["netcdf", "csv", "svg"]  # "png" and "pdf" draw the figures so, too
report = true  # one page with everything, report.html
"""

LAWS = tuple(_SURFACES)
"""Surfaces that there is a study to begin with for."""


def template(law: str = "greenwood-williamson", name: str = "joint.toml", hint: str = "") -> str:
    """A commented study that runs as it is, for one of :data:`LAWS`.

    ``name`` is that of its file, for the title and the commands in its comments; ``hint`` a first
    line for editors, such as "#:schema study.schema.json".
    """
    if law not in _SURFACES:
        near = did_you_mean(law, LAWS) if isinstance(law, str) else ""
        raise StudyError(f"law: wanted {quoted(LAWS)}, got {show(law)}{near}")
    keys = ("light", "heavy", "force", "spring", "small", "middle", "large")
    numbers = dict(zip(keys, _NUMBERS[law], strict=True))
    numbers["tightened"] = ""
    if load := _TIGHTENED.get(law):
        remark = "largest load it has carried: summits have yielded, by the hardness"
        numbers["tightened"] = f'tightening_load = "{load}"  # {remark}\n'
    stem = Path(name).stem
    title = stem if 0 < len(stem) <= 200 and stem.isprintable() else "A joint"
    # A basic string of TOML is written as one of JSON.
    head = _HEAD.format(command=command_line(name), title=json.dumps(title, ensure_ascii=False))
    text = head + _SURFACES[law] + _TAIL.format(**numbers)
    # Remarks below each other.
    text = re.sub(r"(?m)^(.*\S)  # ", lambda line: f"{line[1]:<38}  # ", text)
    return f"{hint}\n{text}" if hint else text


def write(path: Path, law: str = "greenwood-williamson") -> None:
    """Write a commented study into a new file, whose name ends in `.toml`."""
    name = shorten(str(path), 200)
    if path.suffix != ".toml":  # which ".toml" has not
        example = shorten(f"{path.name.partition('.')[0] or 'joint'}.toml", 60)
        raise StudyError(f'{name}: wanted a name that ends in .toml, such as "{example}"')
    # Only a file beside the study: an editor must not ask the network for it.
    hint = f"#:schema {SCHEMA_FILE}" if (path.parent / SCHEMA_FILE).is_file() else ""
    text = template(law, path.name, hint).encode("utf-8")
    try:
        file = path.open("xb")
    except FileExistsError:
        raise StudyError(f"{name}: exists, and is not replaced; name another file") from None
    except (OSError, ValueError) as error:
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from None
    try:
        with file:
            file.write(text)
    except OSError as error:
        with suppress(OSError):
            path.unlink()
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from None


def demo_text(beam: bool = False) -> str:
    """A study that comes with the package: a milled aluminium joint, or a bolted beam."""
    name = "demo_beam.toml" if beam else "demo.toml"
    return files("microslip.study").joinpath(name).read_text(encoding="utf-8")


def command_line(*words: str | Path) -> str:
    """Words as they are typed in a shell: on one line, quoted where it wants that, printable."""
    return shorten(" ".join(shlex.quote(str(word)) for word in words), 1000)
