"""Floor 9: what the package writes as arguments, in the spelling of a command: as its options."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

Rules = Sequence[tuple[str, str]]
"""Patterns of what the package writes, and the options that stand for it."""

_TABLE: Mapping[str, Rules] = {
    "identify": (
        (r"(?<![-\w])rig_stiffness must\b", "--rig-stiffness must"),
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
    """A message of the package as a command would say it."""
    for argument, option in _TABLE.get(command or "", ()):
        message = re.sub(argument, option, message)
    return message
