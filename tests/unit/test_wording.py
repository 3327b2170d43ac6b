"""What is said, to the letter: a table of expressions and of what each of them is refused with.

An expression is one of a module of tests, whose names it uses. ``MICROSLIP_WORDING=write`` writes
the table anew; what has changed in it is to be read before it is kept.
"""

from __future__ import annotations

import importlib.util
import json
import math
import os
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import refused
import studies

import microslip as ms

TESTS = Path(__file__).parents[1]
TABLE = TESTS / "wording.json"
WORDING: dict[str, dict[str, str]] = json.loads(TABLE.read_text(encoding="utf-8"))


def names_in(module: str) -> dict[str, Any]:
    """What expressions of a module of tests may name."""
    name = f"wording.{module}"
    specification = importlib.util.spec_from_file_location(name, TESTS / module)
    assert specification is not None
    assert specification.loader is not None
    sys.modules[name] = loaded = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(loaded)
    common = {"ms": ms, "np": np, "math": math, "Path": Path}
    return {**common, **vars(studies), **vars(refused), **vars(loaded)}


def told(expression: str, names: dict[str, Any]) -> str:
    """The text that an expression gives, or the message that it is refused with."""
    try:
        text = str(eval(expression, names))
    except ms.InputError as error:
        text = str(error)
    return re.sub(r"at 0x[0-9a-f]+", "at 0x…", text)


@pytest.mark.parametrize("module", WORDING)
def test_what_is_said(module: str) -> None:
    names = names_in(module)
    found = {expression: told(expression, names) for expression in WORDING[module]}
    if os.environ.get("MICROSLIP_WORDING") == "write":
        table = json.loads(TABLE.read_text(encoding="utf-8")) | {module: found}
        TABLE.write_text(json.dumps(table, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    assert found == WORDING[module]
