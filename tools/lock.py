"""Write requirements.lock: each package once, with its hashes and the groups that install it.

Run as ``make lock``, by which uv is found or fetched. A line "# for dev docs" stands before the
packages that these groups install; the Makefile picks the packages of a group by that line, and
pip or uv checks the hashes. All of it is one resolution, for every Python and platform.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements.lock"
HEAD = "# Written by `make lock`; read by the Makefile, which picks the packages of one group.\n"
# They bring CUDA and JAX: environments of their own (tools/try_hosts.sh).
HEAVY = {"torch", "jax"}

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = [f"--extra={name}" for name in PROJECT["optional-dependencies"] if name not in HEAVY]
GROUPS = {
    "run": ["pyproject.toml", "--group=build"],
    "dev": ["pyproject.toml", "--group=dev"],
    "test": ["pyproject.toml", "--group=dev", *EXTRAS],
    "docs": ["pyproject.toml", "--group=dev", "--group=docs"],
    "compiler": ["--group=compiler"],
}


def resolve(uv: str, *options: str) -> str:
    """Return the pinned requirements that uv finds for these options."""
    fixed = ["--universal", "--python-version=3.11", "--no-header", "--no-annotate", "--quiet"]
    fixed += ["--no-emit-index-url", "--no-emit-find-links"]
    command = [uv, "pip", "compile", *options, *fixed]
    return subprocess.run(
        command, cwd=ROOT, check=True, stdout=subprocess.PIPE, encoding="utf-8"
    ).stdout


def by_package(text: str) -> dict[str, str]:
    """Split requirements by package; a package may have several versions, each with markers."""
    found: dict[str, str] = {}
    for block in re.split(r"(?m)^(?=[A-Za-z0-9])", text):
        name = re.match(r"[\w.-]+", block)
        if name is not None:
            found[name[0]] = found.get(name[0], "") + block
    return found


def main(uv: str, *options: str) -> None:
    """Resolve all groups together, then find which packages each group takes."""
    every = list(dict.fromkeys(option for chosen in GROUPS.values() for option in chosen))
    # uv keeps the versions that the written file has, unless --upgrade is among the options.
    resolve(uv, *every, "--generate-hashes", f"--output-file={LOCK}", *options)
    pinned = by_package(LOCK.read_text(encoding="utf-8"))
    users: dict[str, list[str]] = {name: [] for name in pinned}
    for group, chosen in GROUPS.items():
        for name in by_package(resolve(uv, *chosen, f"--constraints={LOCK}")):
            users[name].append(group)
    parts = [f"# for {' '.join(users[name])}\n{text}" for name, text in pinned.items()]
    LOCK.write_text(HEAD + "".join(parts), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
