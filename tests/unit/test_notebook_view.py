"""What a notebook shows of laws, records and results."""

from __future__ import annotations

import base64
import re
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import microslip as ms
from microslip.friction.laws import LAWS

T = np.arange(4000) / 1000.0
RECORD = ms.Record(
    time=T, displacement=1e-5 * np.sin(2 * np.pi * T), force=9.0 * np.sign(np.cos(2 * np.pi * T))
)


@pytest.mark.parametrize(
    "item",
    [*(kind.examples()[0] for kind in LAWS), RECORD, ms.measure(RECORD)],
    ids=lambda item: type(item).__name__,
)
def test_a_notebook_shows_the_text_and_a_figure(item: Any) -> None:
    shown = item._repr_html_()
    text, image = re.fullmatch(
        r'<pre>(.*)</pre><img src="data:image/svg\+xml;base64,(.*)" alt=".*">', shown, re.DOTALL
    ).groups()  # type: ignore[union-attr]
    assert text.startswith(type(item).__name__)
    assert ElementTree.fromstring(base64.b64decode(image)).tag.endswith("svg")
    assert len(shown) < 400_000
