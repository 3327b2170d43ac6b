"""Files of every format with bytes, words, numbers and parts of archives changed, cut, doubled."""

from __future__ import annotations

import io
import os
import pickle
import re
import struct
import tempfile
import warnings
import zipfile
import zlib
from pathlib import Path

from .campaign import Random, Tally
from .seeds import Seed, seeds

MEMORY, LONGEST = 2e9, 10.0
"""Bytes and seconds of computing that an input may take."""
WORDS = (0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 2**24, 2**30, 2**31 - 1, 2**31,
         2**32 - 1, 2**40, 2**62, 2**63, 2**64 - 1)  # fmt: skip
TOKENS = (
    b"nan", b"-inf", b"1e999", b"-1", b"0", b"", b'"', b"'''", b"\x00", b"\xff\xfe", b"[[", b"]]",
    b"{", b"}", b"=", b"\n", b"\r", b",", b";", b"\t", b"1" * 400, "µ".encode(), b"a.b.c",
    b"9999-12-31", b"true", b"\x1b[2J", b"<script>", b"=1+1", b"%s", b"../../etc", b"1e-320",
    b"a" * 5000, b"[" * 2000, "\u202e".encode(), b"#", b"mm", b"kN", b"GPa",
)  # fmt: skip

NUMBER = re.compile(rb"\d+(\.\d+)?(e-?\d+)?")
VALUES = (
    b"0", b"1", b"2", b"3", b"7", b"10", b"1e3", b"1e-3", b"0.3", b"1e9", b"1e-12", b"1e30",
    b"-1", b"-0.0", b"1e300", b"1e-300", b"nan", b"inf", b"99999999999999999999", b"1.5.2",
)  # fmt: skip


def mutated(rng: Random, content: bytes) -> bytes:
    """One to four changes of a file, half of them of a number in it."""
    for _ in range(int(rng.integers(1, 5))):
        size = len(content)
        at, length = int(rng.integers(size + 1)), int(rng.integers(1, 60))
        kind = rng.integers(12)
        if kind > 5:
            numbers = list(NUMBER.finditer(content))
            if numbers:
                found = numbers[rng.integers(len(numbers))]
                value = VALUES[rng.integers(len(VALUES))]
                content = content[: found.start()] + value + content[found.end() :]
        elif kind == 0 and size:
            at = min(at, size - 1)
            content = content[:at] + bytes([int(rng.integers(256))]) + content[at + 1 :]
        elif kind == 1:
            content = content[:at] + content[at + length :]
        elif kind == 2:
            content = content[: at + length] + content[at:]
        elif kind == 3:
            content = content[:at] + TOKENS[rng.integers(len(TOKENS))] + content[at:]
        elif kind == 4:
            content = content[:at]
        else:
            other = int(rng.integers(size + 1))
            content = content[:at] + content[other : other + length] + content[at:]
    return content


def with_words_changed(rng: Random, content: bytes) -> bytes:
    """One to three words of two to eight bytes changed, half of them where a file has its head."""
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 4))):
        size = int(rng.choice([2, 4, 8]))
        reach = len(changed) - size
        if reach <= 0:
            break
        at = int(rng.integers(min(reach, 400) if rng.integers(2) else reach))
        at -= at % size if rng.integers(2) else 0
        value = WORDS[rng.integers(len(WORDS))]
        if rng.integers(3) == 0:  # a count that is nearly right
            value = int.from_bytes(changed[at : at + size], "little") + int(rng.integers(-2, 3))
        word = (value % 256**size).to_bytes(size, "little" if rng.integers(4) else "big")
        changed[at : at + size] = word
    return bytes(changed)


def of_archive(rng: Random, content: bytes) -> bytes:
    """An entry of an archive changed, left out or doubled, packed again around the change."""
    packed = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(content)) as whole, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of entries that are there twice
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            names = whole.namelist()
            chosen, kind = names[rng.integers(len(names))], rng.integers(10)
            for entry in names:
                part = whole.read(entry)
                if entry != chosen:
                    archive.writestr(entry, part)
                elif kind > 0:
                    archive.writestr(entry, changed_bytes(rng, entry, part))
                    if kind == 1:
                        archive.writestr(entry, part)
    return packed.getvalue()


def of_matlab(rng: Random, content: bytes) -> bytes:
    """A compressed variable of a MAT-file of version 5 changed, packed again around the change."""
    parts, at = [content[:128]], 128
    while at + 8 <= len(content):
        kind, size = struct.unpack_from("<II", content, at)
        element = content[at + 8 : at + 8 + size]
        if kind == 15 and rng.integers(2):
            element = zlib.compress(with_words_changed(rng, zlib.decompress(element)))
        parts.append(struct.pack("<II", kind, len(element)) + element)
        at += 8 + size
    return b"".join(parts)


TEXTS = (".toml", ".csv", ".json", ".xyz", ".pch", ".inp", ".vtk", ".xml", ".vtu")


def changed_bytes(rng: Random, name: str, content: bytes) -> bytes:
    """A text changed as one, and anything else by its words half of the time."""
    if name.endswith((*TEXTS, ".msh")) or rng.integers(2):
        return mutated(rng, content)
    return with_words_changed(rng, content)


def mutant_of(rng: Random, name: str, content: bytes) -> bytes:
    """A changed file, half of the time by what its format is made of."""
    if rng.integers(2):
        if name.endswith((".npz", ".x3p", ".xlsx")):
            return of_archive(rng, content)
        if content.startswith(b"MATLAB 5.0"):
            return of_matlab(rng, content)
    return changed_bytes(rng, name, content)


def placed(folder: Path, name: str, content: bytes) -> Path:
    """A file in a folder."""
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    return path


def attack_files(rng: Random, tally: Tally) -> None:
    """Twenty mutants of one of the seeds."""
    attack_seed(rng, tally, seeds()[rng.integers(len(seeds()))], 20)


def attack_seed(rng: Random, tally: Tally, seed: Seed, count: int) -> None:
    """Mutants of one file."""
    mutants = [mutant_of(rng, seed.name, seed.content) for _ in range(count)]
    if seed.parsed_apart or not hasattr(os, "fork"):
        _read_all(tally, seed, mutants)
    elif not _in_fork(tally, seed, mutants):
        for mutant in mutants:
            _in_fork(tally, seed, [mutant])


def _read_all(tally: Tally, seed: Seed, mutants: list[bytes]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = placed(Path(folder), seed.name, seed.content)
        for mutant in mutants:
            path.write_bytes(mutant)
            tally.attempt(f"{seed.name} {mutant[:40]!r}… of {len(mutant)}", lambda: seed.read(path))


def _in_fork(tally: Tally, seed: Seed, mutants: list[bytes]) -> bool:
    """Read files in a process of its own, whose death, memory and time are seen.

    Whether they are counted: several that went wrong are not, so that each can be tried alone.
    """
    reading, writing = os.pipe()
    if (fork := os.fork()) == 0:
        try:
            part = Tally()
            _read_all(part, seed, mutants)
            part.wrong = part.wrong[:20]
            os.write(writing, pickle.dumps(part))
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as pipe:
        said = pipe.read()
    _, status, usage = os.wait4(fork, 0)
    part = pickle.loads(said) if said else Tally(tried=len(mutants))
    label = f"{seed.name} {mutants[0][:40]!r}… of {len(mutants[0])}"
    if not said:
        part.wrong.append(f"{label}: its process ended with {os.waitstatus_to_exitcode(status)}")
    if usage.ru_maxrss * 1024 > MEMORY:
        part.wrong.append(f"{label}: took {usage.ru_maxrss / 1e6:.2f} GB")
    if part.slowest > LONGEST:
        part.wrong.append(f"{label}: took {part.slowest:.1f} s")
    if part.wrong and len(mutants) > 1:
        return False
    tally.add(part)
    return True
