"""Studies to begin with: one that comes with the package, and commented new ones."""

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

# The largest load that a joint has carried: soft steel has yielded at its summits by then.
_TIGHTENED = {"greenwood-williamson": "4 kN", "population": "500 N"}

# Loads, force amplitudes, stiffness of the oscillator; amplitudes, range of the curve.
_NUMBERS = {
    "greenwood-williamson": ("500 N", "2 kN", "30 N", "100 MN/m", "5 nm", "50 nm", "0.5 um"),
    "population": ("50 N", "200 N", "5 N", "5 MN/m", "0.05 um", "0.2 um", "2 um"),
    "sphere": ("5 N", "20 N", "0.5 N", "1 MN/m", "20 nm", "0.1 um", "1 um"),
    "table": ("500 N", "2 kN", "30 N", "100 MN/m", "0.05 um", "0.2 um", "1 um"),
}

LAWS = tuple(_NUMBERS)
"""Surfaces that there is a study to begin with for."""


def template(
    law: str = "greenwood-williamson",
    name: str = "joint.toml",
    hint: str = "",
    *,
    tightened: bool = True,
) -> str:
    """A commented study that runs as it is, for one of :data:`LAWS`.

    ``name`` is that of its file, for the title and the commands in its comments; ``hint`` a first
    line for editors, such as "#:schema study.schema.json"; without ``tightened`` it has not been.
    """
    if law not in LAWS:
        near = did_you_mean(law, LAWS) if isinstance(law, str) else ""
        raise StudyError(f"law: wanted {quoted(LAWS)}, got {show(law)}{near}")
    pieces = re.split(r"(?m)^%% (\S+)\n", _text_of("new_study.template"))[1:]
    parts = dict(zip(pieces[::2], pieces[1::2], strict=True))
    keys = ("light", "heavy", "force", "spring", "small", "middle", "large")
    numbers = dict(zip(keys, _NUMBERS[law], strict=True))
    numbers["tightened"] = ""
    if tightened and (load := _TIGHTENED.get(law)):
        remark = "largest load it has carried: summits have yielded, by the hardness"
        numbers["tightened"] = f'tightening_load = "{load}"  # {remark}\n'
    stem = Path(name).stem
    title = stem if 0 < len(stem) <= 200 and stem.isprintable() else "A joint"
    # A basic string of TOML is written as one of JSON.
    head = parts["head"].format(
        command=command_line(name), title=json.dumps(title, ensure_ascii=False)
    )
    text = head + parts[law] + parts["tail"].format(**numbers)
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
    return _text_of(name)


def _text_of(name: str) -> str:
    return files("microslip.study").joinpath(name).read_text(encoding="utf-8")


def command_line(*words: str | Path) -> str:
    """Words as they are typed in a shell: on one line, quoted where it wants that, printable."""
    return shorten(" ".join(shlex.quote(str(word)) for word in words), 1000)
