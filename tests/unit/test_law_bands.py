"""Laws in files, and their intervals in these files and through a prediction."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import microslip as ms
from microslip.friction import LAWS, LawBand, load_law, save_law
from microslip.friction.law_files import _by_name

LAW = ms.SegalmanIwan.examples()[0]
REACH = LAW.force_limit / LAW.tangential_stiffness
SHARES = {"force": 0.01, "dissipated_energy": 0.03, "damping_ratio": 0.02}


def exact(name: str, a: np.ndarray) -> np.ndarray:
    """A quantity of the law."""
    return np.asarray(getattr(LAW, "backbone" if name == "force" else name)(a))


def band(points: int = 40) -> LawBand:
    """Return intervals that lie some per cent about the law."""
    a = np.geomspace(0.1 * REACH, 3.0 * REACH, points)
    ends = {
        name: exact(name, a) * np.array([[1.0 - share], [1.0 + share]])
        for name, share in SHARES.items()
    }
    return LawBand(a, ends, 0.95)


def test_ends_are_interpolated_about_the_exact_value() -> None:
    a = REACH * np.array([0.05, 0.1, 0.37, 2.9, 3.1])
    found = band().of(LAW, a)
    for name, share in SHARES.items():
        assert np.isnan(found[name][:, [0, -1]]).all()
        low, high = found[name][:, 1:-1] / exact(name, a)[1:-1]
        # Between 40 amplitudes over a factor of 30 a constant share is kept to a few per mille.
        assert low == pytest.approx(1.0 - share, abs=0.01 * share)
        assert high == pytest.approx(1.0 + share, abs=0.01 * share)


def test_a_prediction_carries_the_band(tmp_path: Path) -> None:
    save_law(LAW, tmp_path / "law.json", band=band())
    text = f"""schema = 1
    [joint]
    law_file = "law.json"
    [excitation]
    amplitudes = ["{0.2 * REACH} m", "{20 * REACH} m"]
    """
    result = ms.Study.from_toml(text, folder=tmp_path).run()
    bands = result.summary["uncertainty"]["bands"]
    low, high = np.array(bands["dissipated_energy"]["quantiles"], dtype=float)[:, 0]
    energy = result.rows[0].dissipated_energy
    assert low[0] / energy[0] == pytest.approx(0.97, abs=1e-3)
    assert high[0] / energy[0] == pytest.approx(1.03, abs=1e-3)
    assert np.isnan(low[1])  # far beyond what was measured
    result.save(tmp_path / "out")
    table = (tmp_path / "out" / "bands.csv").read_text("utf-8").splitlines()
    assert len(table) == 1 + 2 * result.curves[0].amplitude.size
    assert "identified law" in (tmp_path / "out" / "report.html").read_text("utf-8")


EXAMPLES = [law for kind in LAWS for law in kind.examples()]


@pytest.mark.parametrize("law", EXAMPLES, ids=lambda law: type(law).__name__)
def test_a_law_of_numbers_comes_back_and_others_are_refused(
    law: ms.BackboneLaw, tmp_path: Path
) -> None:
    file = tmp_path / "law.json"
    if type(law) not in _by_name().values():
        with pytest.raises(ms.InputError, match="law must be one of coulomb, jenkins"):
            ms.friction.save_law(law, file)
        assert not file.exists()
        return
    ms.friction.save_law(law, file)
    again = ms.friction.load_law(file)
    assert type(again) is type(law)
    x = np.array([0.0, 1e-7, 3e-6, -2e-6, 1e-5])
    np.testing.assert_array_equal(again.force(x), law.force(x))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "microslip-result"}, 'is not a law file: "kind" must be "microslip-law"'),
        ({"version": 2}, "version must be 1, got 2"),
        ({"law": "bouc-wen"}, "law must be one of coulomb, jenkins, iwan, segalman, sliders, got"),
        ({"parameters": {"stiffness": 1.0}}, "parameters of jenkins must be stiffness, force_lim"),
        ({"parameters": {"stiffness": -1.0, "force_limit": 1.0}}, "stiffness must be above zero"),
        ({"units": {"stiffness": "N/mm", "force_limit": "N"}}, "units must be"),
    ],
)
def test_a_wrong_file_is_refused(change: dict[str, Any], message: str, tmp_path: Path) -> None:
    file = tmp_path / "law.json"
    ms.friction.save_law(ms.Jenkins(5e7, 100.0), file)
    content = json.loads(file.read_text("utf-8"))
    file.write_text(json.dumps(content | change), "utf-8")
    with pytest.raises(ms.InputError) as caught:
        ms.friction.load_law(file)
    assert str(caught.value).startswith(f"law.json: {message}")


def test_wrong_bands_are_refused(tmp_path: Path) -> None:
    save_law(LAW, tmp_path / "law.json", band=band(5))
    content = json.loads((tmp_path / "law.json").read_text("utf-8"))
    for change in ({"amplitude": [2e-6, 1e-6]}, {"force": [[1.0], [2.0]]}, {"confidence": 1.5},
                   {"force": "none"}, {"more": 1}):  # fmt: skip
        wrong = content | {"band": content["band"] | change}
        (tmp_path / "law.json").write_text(json.dumps(wrong), "utf-8")
        assert isinstance(load_law(tmp_path / "law.json"), ms.SegalmanIwan)
        text = 'schema = 1\njoint = { law_file = "law.json" }\n'
        with pytest.raises(ms.StudyError):
            ms.Study.from_toml(text, folder=tmp_path).run()
