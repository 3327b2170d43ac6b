"""New studies: the demo studies and commented templates."""

from __future__ import annotations

import json
import math
import os
import shlex
from importlib.resources import files
from pathlib import Path
from string import Template

from microslip._core.errors import StudyError
from microslip._core.files import reason
from microslip._core.units import engineering
from microslip._core.wording import shorten

SCHEMA_FILE = "study.schema.json"
"""File next to a study from which editors read the JSON Schema."""

TEMPLATES = {
    "joint": "one joint: loops, energy and damping",
    "population": "a joint of given summits",
    "sphere": "a joint of one sphere",
    "table": "a joint with a measured or computed normal law",
    "structure": "two bolted beams from their drawing: frequency and damping of modes, with bands",
    "mesh": "bolted parts of a mesh of yours (Gmsh, Abaqus, CalculiX)",
    "scan": "a joint of a scanned surface",
    "record": "a specimen whose records are to be identified",
    "batch": "one study and a table of changes, a row for each joint",
}
"""Templates by name, with their purpose."""

_CHANGES = """name,joint.normal_load,joint.friction_coefficient
light,500 N,0.2
heavy,2 kN,0.2
rough,2 kN,0.4
"""


def template(kind: str = "joint", name: str = "joint.toml", process: str | None = None) -> str:
    """Return a commented study that runs unchanged.

    ``kind`` is one of :data:`TEMPLATES`; instead, ``process`` selects faces machined by one of
    :data:`microslip.contact.finish.PROCESSES`. ``name`` is the file name, used for the title and in
    comments.
    """
    file, stem = Path(name), Path(name).stem
    title = stem if 0 < len(stem) <= 200 and stem.isprintable() else "A joint"
    words = {
        # A basic string of TOML is written as one of JSON.
        "title": json.dumps(title, ensure_ascii=False),
        "study": command_line(file),
        "table": command_line(file.with_suffix(".csv")),
    }
    if process is not None:
        from microslip.contact.finish import PROCESSES

        leaves = PROCESSES[process]
        words |= {"process": process, "source": leaves.source}
        middle = math.sqrt(leaves.low * leaves.high)
        for key, x in {"low": leaves.low, "high": leaves.high, "middle": middle}.items():
            words[key] = engineering(x, "m", 2, trim=True).replace("µ", "u")
        kind = "process"
    return Template(_text_of(f"templates/{kind}.toml")).substitute(words)


def write_template(path: Path, kind: str = "joint", process: str | None = None) -> list[str]:
    """Write a commented study into a new file with the suffix `.toml`; return the next commands.

    Arguments as in :func:`template`. The template "batch" also writes its table of changes.
    """
    name = shorten(str(path), 200)
    if path.suffix != ".toml":  # the suffix of a file named ".toml" is empty
        example = shorten(f"{path.name.partition('.')[0] or 'joint'}.toml", 60)
        raise StudyError(f'{name}: wanted a name that ends in .toml, such as "{example}"')
    # Refer to a local file only, so that editors need no network access.
    hint = f"#:schema {SCHEMA_FILE}\n" if (path.parent / SCHEMA_FILE).is_file() else ""
    study = template(kind, path.name, process)
    texts = {path: hint + study}
    if kind == "batch":
        texts[path.with_suffix(".csv")] = _CHANGES
    for file in texts:
        if os.path.lexists(file):
            name = shorten(str(file), 200)
            raise StudyError(f"{name}: exists and is not overwritten; give another name")
    try:
        for file, text in texts.items():
            with file.open("xb") as stream:
                stream.write(text.encode("utf-8"))
    except (OSError, ValueError) as error:
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from None
    # The comments contain commands with the bare file name; return them with the path.
    steps = [line[4:] for line in study.splitlines() if line.startswith("#   microslip ")]
    for file in texts:
        steps = [step.replace(command_line(file.name), command_line(file)) for step in steps]
    return steps


def demo_text(beam: bool = False) -> str:
    """Return the demo study: a milled aluminium joint, or a bolted beam."""
    name = "demo_beam.toml" if beam else "demo.toml"
    return _text_of(name)


def _text_of(name: str) -> str:
    return files("microslip.study").joinpath(name).read_text(encoding="utf-8")


def command_line(*words: str | Path) -> str:
    """Return words quoted for a shell, on one line."""
    return shorten(" ".join(shlex.quote(str(word)) for word in words), 1000)
