"""The explorer: its closed form against Python's, its study, and the page in a real browser."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import run

import microslip as ms
from microslip.app.explorer.page import INPUTS, law_script, page

NODE = shutil.which("node")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
needs_node = pytest.mark.skipif(NODE is None, reason="Node is not installed")
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")


def in_node(code: str, given: Any) -> Any:
    """What a script says, in JSON, that follows the law of the page and reads ``given``."""
    head = "const given = JSON.parse(require('fs').readFileSync(0, 'utf8'));\n"
    program = law_script() + head + f"console.log(JSON.stringify({code}));"
    done = subprocess.run(
        [str(NODE), "-e", program], input=json.dumps(given), capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    return json.loads(done.stdout)


def joints(count: int) -> list[tuple[dict[str, Any], ms.Interface]]:
    """Joints from hardly touching to all but flat."""
    rng = np.random.default_rng(19)
    found = []
    for number in range(count):
        kind = "exponential" if number % 4 == 0 else "gaussian"
        choice = {
            **{f"e{n}": 10.0 ** rng.uniform(9.0, 11.7) for n in (1, 2)},
            **{f"nu{n}": rng.uniform(0.0, 0.5) for n in (1, 2)},
            "kind": kind,
            "std": 10.0 ** rng.uniform(-8.0, -5.0),
            "radius": 10.0 ** rng.uniform(-5.0, -2.0),
            "density": 10.0 ** rng.uniform(6.0, 12.0),
            "area": 10.0 ** rng.uniform(-6.0, -2.0),
            "mu": rng.uniform(0.05, 1.5),
        }
        bodies = (ms.Material(choice[f"e{n}"], choice[f"nu{n}"]) for n in (1, 2))
        heights = (ms.Gaussian if kind == "gaussian" else ms.Exponential)(choice["std"])
        surface = ms.GreenwoodWilliamson(
            ms.MaterialPair(*bodies), heights, choice["radius"], choice["density"], choice["area"]
        )
        h = rng.uniform(-12.0, 12.0) if kind == "gaussian" else rng.uniform(0.01, 20.0)
        choice["load"] = surface.load(h * choice["std"])
        joint = ms.Interface(surface, choice["mu"], normal_load=choice["load"])
        found.append((choice, joint))
    return found


@needs_node
def test_the_script_says_what_python_says() -> None:
    cases = joints(300)
    amplitudes = [
        (joint.force_limit / joint.tangential_stiffness * np.logspace(-5.0, 3.0, 9)).tolist()
        for _, joint in cases
    ]
    said = in_node(
        "given.map(([p, u]) => { const j = makeJoint(p); return {"
        "backbone: u.map(j.backbone), dissipated_energy: u.map(j.energy), "
        "loss_factor: u.map(j.lossFactor), tangential_stiffness: j.kt, contact_count: j.count, "
        "contact_area: j.area, loop: j.loop(u[4], 64)}; })",
        [(choice, u) for (choice, _), u in zip(cases, amplitudes, strict=True)],
    )
    worst = 0.0
    for (_, joint), u, answer in zip(cases, amplitudes, said, strict=True):
        for name in ("backbone", "dissipated_energy", "loss_factor"):
            own = getattr(joint, name)(u)
            worst = max(worst, float(abs(np.array(answer[name]) / own - 1.0).max()))
        for name in ("tangential_stiffness", "contact_count", "contact_area"):
            worst = max(worst, abs(answer[name] / getattr(joint, name) - 1.0))
        loop = joint.force([0.0, *answer["loop"]["x"]])[1:]
        assert abs(loop - answer["loop"]["y"]).max() < 1e-12 * joint.force_limit
    # Python's energies come from a table of 1e-12; everything else agrees to 2e-14.
    assert worst < 1e-12


@needs_node
@pytest.mark.parametrize("kind", ["gaussian", "exponential"])
def test_saved_files_hold_the_same_joint(kind: str, tmp_path: Path) -> None:
    choice, joint = joints(2)[kind == "gaussian"]
    choice |= {"amplitude": 1e-7, "m1": "", "m2": ""}
    (tmp_path / "study.toml").write_text(in_node("studyText(given)", choice))
    (predicted,) = ms.Study.load(tmp_path / "study.toml").run().joints
    assert predicted.tangential_stiffness == pytest.approx(joint.tangential_stiffness, rel=1e-14)
    assert predicted.force_limit == pytest.approx(joint.force_limit, rel=1e-14)


def test_the_page_needs_nothing_else() -> None:
    text = page()
    assert len(text) < 60_000
    # Addresses of other hosts would be a network; names of XML spaces are none.
    assert not re.findall(r"https?://(?!www\.w3\.org/)", text)
    assert "@script@" not in text
    assert {item["key"] for item in INPUTS} > {"std", "radius", "density", "area", "mu", "load"}


@pytest.mark.slow
@needs_browser
def test_dragging_redraws_and_the_address_remembers(tmp_path: Path) -> None:
    """As a person: a slider dragged, a reload, the study saved; nothing is fetched."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    file = tmp_path / "explorer.html"
    assert run("explore", "-o", file).exit_code == 0
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": 1300, "height": 950})
        wrong: list[str] = []
        asked: list[str] = []
        tab.on("pageerror", lambda error: wrong.append(str(error)))
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(file.as_uri())
        before = tab.inner_text("#answer")
        box = tab.locator("#amplitude-slide").bounding_box()
        height = box["y"] + box["height"] / 2
        tab.mouse.move(box["x"] + 0.5 * box["width"], height)
        tab.mouse.down()
        tab.mouse.move(box["x"] + 0.8 * box["width"], height, steps=6)
        tab.mouse.up()
        changed = "text => document.querySelector('#answer').innerText !== text"
        tab.wait_for_function(changed, arg=before)
        after, address = tab.inner_text("#answer"), tab.url
        tab.reload()
        assert (tab.inner_text("#answer"), tab.url) == (after, address)
        with tab.expect_download() as download:
            tab.click("#save")
        download.value.save_as(tmp_path / "study.toml")
        browser.close()
    assert not wrong
    assert all(url.startswith(("file:", "blob:")) for url in asked)
    (joint,) = ms.Study.load(tmp_path / "study.toml").run().joints
    assert f"{joint.loss_factor(float(address.split('amplitude=')[1].split('&')[0])):.3g}" in after
