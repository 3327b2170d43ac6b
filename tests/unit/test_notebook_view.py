"""What a notebook shows of laws, records and results."""

from __future__ import annotations

import base64
import re
from html import escape
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import microslip as ms
from microslip.friction.laws import LAWS

ROOT = Path(__file__).parents[2]
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


def test_whatever_draws_itself_is_shown() -> None:
    lacking = [
        name
        for name in ms.__all__
        if hasattr(getattr(ms, name), "plot") and not hasattr(getattr(ms, name), "_repr_html_")
    ]
    assert lacking == []
    joint = ms.Interface.examples()[0]
    loop = joint.loop(1e-6)
    assert loop._repr_html_().startswith("<pre>Loop(512 samples")
    bar = ms.Structure([[1.0]], [[4e5]]).attach(joint, directions=[1.0])
    motion = bar.integrate(None, np.linspace(0.0, 1e-3, 200), displacement=[1e-7])
    assert motion._repr_html_().startswith("<pre>Motion(")


def test_a_notebook_shows_the_table_of_a_prediction() -> None:
    result = ms.Study.load(ROOT / "examples" / "al2017.toml").run()
    shown = result._repr_html_()
    assert shown.startswith(f"<pre>{escape(repr(result))}\n\n{result.study.title}")
    assert "264 µJ" in shown
    assert shown.count("<img ") == 1
    assert len(shown) < 200_000
