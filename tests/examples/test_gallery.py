"""Scripts of the gallery run, print, and draw figures whose axes have labels.

``make docs`` runs all of them and stops at an error; here run those that take less than a second.
"""

from __future__ import annotations

import ast
import runpy
from pathlib import Path

import matplotlib
import pytest

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))
LONG = {"05", "10", "11", "14", "16", "17", "18", "19", "21", "22"}


@pytest.mark.filterwarnings("ignore:FigureCanvasAgg is non-interactive")
@pytest.mark.parametrize(
    "script", [p for p in SCRIPTS if p.stem[:2] not in LONG], ids=lambda p: p.stem
)
def test_script(
    script: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(FOLDER)
    before = matplotlib.rcParams.copy()
    matplotlib.use("agg")
    from matplotlib import pyplot

    try:
        runpy.run_path(str(script), run_name="__main__")
        figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
        assert figures
        for figure in figures:
            figure.canvas.draw()
            for axes in figure.axes:
                assert axes.lines or axes.collections or axes.images
                if axes.get_label() == "<colorbar>":
                    assert axes.get_xlabel() or axes.get_ylabel()
                    continue
                assert axes.get_xlabel() or axes.get_shared_x_axes().get_siblings(axes) != [axes]
                assert axes.get_ylabel() or axes.get_shared_y_axes().get_siblings(axes) != [axes]
    finally:
        pyplot.close("all")
        matplotlib.rcParams.update(before)
    printed = capsys.readouterr().out
    assert printed.strip()
    assert "nan" not in printed


@pytest.mark.parametrize(
    "script", [p for p in SCRIPTS if p.stem[:2].isdigit()], ids=lambda p: p.stem
)
def test_a_notebook_holds_the_code_of_its_script(script: Path) -> None:
    """So a notebook runs where its script does, which the tests above run."""
    make = runpy.run_path(str(ROOT / "tools" / "make_notebooks.py"))["notebook"]
    text = script.read_text(encoding="utf-8")
    made = make(text)
    code = "\n".join("".join(c["source"]) for c in made["cells"] if c["cell_type"] == "code")
    body = ast.parse(text).body
    assert ast.dump(ast.Module(ast.parse(code).body, [])) == ast.dump(ast.Module(body[1:], []))
    assert made["cells"][0]["cell_type"] == "markdown"
    assert sum(c["cell_type"] == "markdown" for c in made["cells"]) >= 2
