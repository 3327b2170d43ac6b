"""Floor 9: what the package writes as arguments, in the spelling of a command: as its options."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

Rules = Sequence[tuple[str, str]]
"""Patterns of what the package writes, and the options that stand for it."""

_TEXT = r"""["']([^"']+)["']"""

_READING: Rules = (
    (r"write time=False and sample_rate=", "write --sample-rate HZ"),
    (r", or time=False", ", or --sample-rate HZ in its place"),
    (rf"(?<![-\w])units=\{{{_TEXT}: {_TEXT}\}}", r'--unit \1="\2"'),
    (rf"(?<![-\w])calibration=\{{{_TEXT}: {_TEXT}\}}", r'--calibration \1="\2"'),
    (r"(?<![-\w])write (displacement|force|time)=\"", r'write --\1 "'),
    (r"(?<![-\w])write normal_load=\"", 'write --normal-load "'),
    (r"(?<![-\w])write commanded=\"[^\"]*\", or commanded=False", "rename one"),
    (r", or normal_load=False", ', or --normal-load "500 N"'),
    (r"(?<![-\w])units: (no column is read as)", r"--unit: \1"),
    (r"(?<![-\w])(calibration|zero): (no column is read as)", r"--\1: \2"),
    (r"; write (displacement|force|time)=$", r"; write --\1 COLUMN"),
    (r"; write normal_load=$", "; write --normal-load COLUMN"),
    (r"; write commanded=$", "; a command finds one by its name only"),
    (
        r"the longest stretch of numbers is rows=slice\((\d+), (\d+)\)",
        r"keep the longest stretch of numbers, from row \1 to before row \2, the first being 0, or "
        r"in Python write Record.read(path, rows=slice(\1, \2))",
    ),
    (r"(?<![-\w])time and sample_rate say the same", "--time and --sample-rate say the same"),
    (r"(?<![-\w])give sample_rate instead", "give --sample-rate instead"),
    (r"(?<![-\w])sample_rate must\b", "--sample-rate must"),
    (r"(?<![-\w])normal_load: (wanted|no column)", r"--normal-load: \1"),
    (r"(?<![-\w])sign=-1 when reading turns it", "--turn turns it"),
    (r"(?<![-\w])confidence must\b", "--confidence must"),
    (r"(?<![-\w])rig_stiffness must\b", "--rig-stiffness must"),
)

_TABLE: Mapping[str, Rules] = {
    "measure": (
        *_READING,
        (r"(?<![-\w])give rig_stiffness\b", "give --rig-stiffness"),
        (r"(?<![-\w])model must (have|be)\b", r"--model must \1"),
    ),
    "identify": (
        *_READING,
        (
            r"write Record\(\.\.\., normal_load=500\.0\), or take law='(\w+)'",
            r'write --normal-load "500 N", or take --law \1',
        ),
        (r"(?<![-\w])(?:write|give) rig_stiffness=None", "write --rig-stiffness rigid"),
        (r"(?<![-\w])fixed: write rig_stiffness=2e8", '--fix: write --rig-stiffness "2e8 N/m"'),
        (r"(?<![-\w])rig_stiffness has no place", "--rig-stiffness has no place"),
        (r"(?<![-\w])rigs=\[one label a record\]", "--rig LABEL once for each record"),
        (r"(?<![-\w])known: ", "--known: "),
        (r"(?<![-\w])give pair=\.\.\. and area=\.\.\., too", "give --study STUDY.toml, too"),
        (r"(?<![-\w])fixed ([\w ]+) must be within", r"--fix: \1 must be within"),
        (r"(?<![-\w])fixed: ", "--fix: "),
        (r"(?<![-\w])bounds: ", "--bound: "),
        (r"(?<![-\w])bounds=\{'(\w+)': \(lowest, highest\)\}", r"--bound \1=LOW..HIGH"),
        (r"(?<![-\w])start=\.\.\. or narrower bounds=\.\.\.", "a narrower --bound NAME=LOW..HIGH"),
        (r"(?<![-\w])start=\{\.\.\.\}", "--bound NAME=LOW..HIGH"),
        (r"(?<![-\w])contact_area needs law='interface'", "--contact-area needs --law interface"),
        (
            r"(?<![-\w])contact_area needs pair=ms\.MaterialPair\(\.\.\.\)",
            "--contact-area needs --study STUDY.toml, with the materials",
        ),
        (r"(?<![-\w])write pair=ms\.MaterialPair\(.*\)\)", "write --study STUDY.toml"),
        (r"(?<![-\w])contact_area must\b", "--contact-area must"),
        (r"(?<![-\w])held_back must\b", "--held-back must"),
        (r"(?<![-\w])write delay='free'", "write --free-delay"),
        (
            r"(?<![-\w])take cycles of one load, cycles=slice\(first, last\)",
            "take a record of one load, or in Python identify(records, cycles=slice(first, last))",
        ),
    ),
}


def as_options(command: str | None, message: str) -> str:
    """A message of the package as a command would say it.

    Parameters
    ----------
    command : str or None
        Name of the command; of one that has no table, nothing is changed.
    message : str
        What the package says.

    Returns
    -------
    str
        The same with options in place of arguments.
    """
    for argument, option in _TABLE.get(command or "", ()):
        message = re.sub(argument, option, message)
    return message
