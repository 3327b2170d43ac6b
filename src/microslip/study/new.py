"""New studies: the demonstration of the package, and commented templates."""

from __future__ import annotations

import json
import math
import re
import shlex
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

from microslip._core.files import reason
from microslip._core.units import engineering
from microslip._core.wording import did_you_mean, quoted, shorten, show
from microslip.errors import StudyError

SCHEMA_FILE = "study.schema.json"
"""File in which editors find the JSON Schema of studies, if it lies beside them."""

# The largest load that a joint has carried: soft steel has yielded at its summits by then.
_TIGHTENED = {"greenwood-williamson": "2.2 kN", "population": "500 N"}

# Two loads, a force amplitude, three displacement amplitudes.
_NUMBERS = {
    "greenwood-williamson": ("500 N", "1.6 kN", "30 N", "5 nm", "50 nm", "0.5 um"),
    "population": ("50 N", "200 N", "5 N", "0.05 um", "0.2 um", "2 um"),
    "sphere": ("5 N", "20 N", "0.5 N", "20 nm", "0.1 um", "1 um"),
    "table": ("500 N", "2 kN", "30 N", "0.05 um", "0.2 um", "1 um"),
}

LAWS = tuple(_NUMBERS)
"""Surfaces that there is a study to begin with for."""

TEMPLATES = {
    "joint": "one joint: loops, energy and damping",
    "structure": "two bolted beams from their drawing: frequency and damping of modes, with bands",
    "mesh": "bolted parts of a mesh of yours (Gmsh, Abaqus, CalculiX)",
    "scan": "a joint of a scanned surface",
    "record": "a specimen whose records are to be identified",
    "batch": "one study and a table of changes, a row for each joint",
}
"""Studies to begin with, and what each is for."""

_NEXT = {
    "joint": ("check {study}", "predict {study}"),
    "structure": ("check {study}", "predict {study}"),
    "mesh": ("check {study}", "predict {study}"),
    "scan": ("surface face.csv", "check {study}", "predict {study}"),
    "record": ("measure run.csv", "identify run.csv --study {study}"),
    "batch": ("batch {table} --study {study}",),
}

_CHANGES = """name,joint.normal_load,joint.friction_coefficient
light,500 N,0.2
heavy,2 kN,0.2
rough,2 kN,0.4
"""


def template(
    law: str = "greenwood-williamson",
    name: str = "joint.toml",
    hint: str = "",
    *,
    tightened: bool = True,
    kind: str = "joint",
) -> str:
    """A commented study that runs as it is, for one of :data:`LAWS`.

    ``name`` is that of its file, for the title and the commands in its comments; ``hint`` a first
    line for editors, such as "#:schema study.schema.json"; without ``tightened`` it has not been.
    """
    if law not in LAWS:
        near = did_you_mean(law, LAWS) if isinstance(law, str) else ""
        raise StudyError(f"law: wanted {quoted(LAWS)}, got {show(law)}{near}")
    parts = _parts()
    keys = ("light", "heavy", "force", "small", "middle", "large")
    numbers = dict(zip(keys, _NUMBERS[law], strict=True))
    numbers["tightened"] = ""
    if tightened and (load := _TIGHTENED.get(law)):
        remark = "largest load it has carried: summits have yielded, by the hardness"
        numbers["tightened"] = f'tightening_load = "{load}"  # {remark}\n'
    tail = parts["records" if kind == "record" else "tail"].format(**numbers)
    return _aligned(_head(name, hint, kind) + parts["metals"] + parts[law] + tail)


def _aligned(text: str) -> str:
    """Remarks below each other."""
    return re.sub(r"(?m)^(.*\S)  # ", lambda line: f"{line[1]:<38}  # ", text)


def _next(kind: str, study: Path) -> list[str]:
    """Commands that come next."""
    names = {"study": command_line(study), "table": command_line(study.with_suffix(".csv"))}
    return [f"microslip {step.format(**names)}" for step in _NEXT[kind]]


def _parts() -> dict[str, str]:
    """Pieces of studies by their names."""
    pieces = re.split(r"(?m)^%% (\S+)\n", _text_of("new_study.template"))[1:]
    return dict(zip(pieces[::2], pieces[1::2], strict=True))


def _head(name: str, hint: str, kind: str) -> str:
    """The first lines of a study: how it is run, and its title."""
    stem = Path(name).stem
    title = stem if 0 < len(stem) <= 200 and stem.isprintable() else "A joint"
    # A basic string of TOML is written as one of JSON.
    title = json.dumps(title, ensure_ascii=False)
    steps = "\n".join(f"#   {step}" for step in _next(kind, Path(name)))
    text = _parts()["head"].format(steps=steps, meaning=TEMPLATES[kind], title=title)
    return f"{hint}\n{text}" if hint else text


def text_of_template(kind: str, law: str, name: str, hint: str, process: str | None = None) -> str:
    """The study of one of :data:`TEMPLATES`, in a file of that name; or of a machined face."""
    if process is not None:
        from microslip.scans.finish import PROCESSES, sampling_length

        leaves = PROCESSES[process]
        lengths = {"low": leaves.low, "high": leaves.high}
        lengths["section"] = sampling_length(math.sqrt(leaves.low * leaves.high))
        texts = {
            key: engineering(x, "m", 3, trim=True).replace("µ", "u") for key, x in lengths.items()
        }
        body = _parts()["process"].format(process=process, source=leaves.source, **texts)
    elif kind == "structure":
        text = demo_text(beam=True)
        text = text[text.index("schema = ") :]
        body = text[text.index("[material") :]
    elif kind in ("mesh", "scan"):
        body = _parts()[kind].format()
    else:
        return template(law, name, hint, kind=kind)
    return _aligned(f"{_head(name, hint, kind)}{body}")


def write(
    path: Path,
    law: str = "greenwood-williamson",
    kind: str = "joint",
    process: str | None = None,
) -> list[str]:
    """Write a commented study into a new file, whose name ends in `.toml`.

    A ``process`` of :data:`microslip.scans.finish.PROCESSES` makes it one of bolted plates with
    faces as that process leaves them. Returns the commands that come next. A batch has its table of
    changes beside it.
    """
    name = shorten(str(path), 200)
    if path.suffix != ".toml":  # which ".toml" has not
        example = shorten(f"{path.name.partition('.')[0] or 'joint'}.toml", 60)
        raise StudyError(f'{name}: wanted a name that ends in .toml, such as "{example}"')
    # Only a file beside the study: an editor must not ask the network for it.
    hint = f"#:schema {SCHEMA_FILE}" if (path.parent / SCHEMA_FILE).is_file() else ""
    texts = {path: text_of_template(kind, law, path.name, hint, process)}
    if kind == "batch":
        texts[path.with_suffix(".csv")] = _CHANGES
    written: list[Path] = []
    try:
        for file, text in texts.items():
            name = shorten(str(file), 200)
            with file.open("xb") as stream:
                written.append(file)
                stream.write(text.encode("utf-8"))
    except (OSError, ValueError) as error:
        for file in written:
            with suppress(OSError):
                file.unlink()
        if isinstance(error, FileExistsError):
            raise StudyError(f"{name}: exists, and is not replaced; name another file") from None
        raise StudyError(f"{name}: cannot be written: {reason(error)}") from None
    return _next(kind, path)


def demo_text(beam: bool = False) -> str:
    """A study that comes with the package: a milled aluminium joint, or a bolted beam."""
    name = "demo_beam.toml" if beam else "demo.toml"
    return _text_of(name)


def _text_of(name: str) -> str:
    return files("microslip.study").joinpath(name).read_text(encoding="utf-8")


def command_line(*words: str | Path) -> str:
    """Words as they are typed in a shell: on one line, quoted where it wants that, printable."""
    return shorten(" ".join(shlex.quote(str(word)) for word in words), 1000)
