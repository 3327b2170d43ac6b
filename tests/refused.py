"""What is said of files that cannot be read, where they are by themselves in an empty folder."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import microslip as ms


def refused_file(read: Callable[..., Any], name: str, content: str | bytes, **keywords: Any) -> str:
    """The message of a file that is refused, and stays as it is."""
    data, here = content if isinstance(content, bytes) else content.encode(), Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            Path(name).write_bytes(data)
            with pytest.raises(ms.InputError) as caught:
                read(name, **keywords)
            assert Path(name).read_bytes() == data
        finally:
            os.chdir(here)
    return str(caught.value)
