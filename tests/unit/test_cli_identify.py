"""The command that identifies a joint: what it takes, prints, writes and refuses."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import STUDY, fails, run

import microslip as ms
from microslip.cli.records import calibration_of, known_of, rig_stiffness_of

JOINT = ms.Interface.examples()[0]
RIG = 5e8


@pytest.fixture(scope="module", name="records")
def _records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("records")
    for seed, (name, load) in enumerate((("light", 500.0), ("heavy", 2000.0))):
        rig = ms.VirtualTribometer(
            JOINT.at(normal_load=load), rig_stiffness=RIG, noise=0.003, sample_rate=2560, seed=seed
        )
        rig.record(amplitude=6e-6, frequency=10.0, cycles=6).to_csv(folder / f"{name}.csv")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return folder


@pytest.fixture(name="folder", autouse=True)
def _folder(records: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for path in records.iterdir():
        (tmp_path / path.name).write_bytes(path.read_bytes())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def summary(*words: str) -> dict[str, Any]:
    outcome = run("identify", *words, "--json")
    assert outcome.exit_code == 0, outcome.output
    found: dict[str, Any] = json.loads(outcome.stdout)
    return found


# -- what comes out --------------------------------------------------------------------------------


def test_command(folder: Path) -> None:
    words = ("identify", "light.csv", "heavy.csv", "--study", "study.toml", "-o", "out")
    outcome = run(*words, "--summits", "inf")
    assert outcome.exit_code == 0, outcome.output
    assert outcome.stdout.splitlines()[1] == "interface: 4 of 4 parameters identified (converged)"
    for text in ("friction coefficient μ", "spread of the heights σ", "Reduced χ²", "Correlations"):
        assert text in outcome.stdout
    assert "--contact-area" in outcome.stdout  # how density and radius would come apart
    assert outcome.stdout.endswith("11 files in out\n")
    names = sorted(path.name for path in (folder / "out").iterdir())
    assert names == [
        "campaign.csv", "evolution.svg", "fretting-map.svg", "friction-log.svg", "intervals.svg",
        "joint.toml", "loops.svg", "profiles.svg", "report.html", "residuals.csv", "summary.json",
    ]  # fmt: skip
    written = json.loads((folder / "out/summary.json").read_text("utf-8"))
    assert sorted(written["files"]) == names
    assert written["kind"] == "microslip-identification"
    truth = {
        "friction_coefficient": JOINT.friction_coefficient,
        "slip_scale": JOINT.slip_per_indentation * JOINT.surface.heights.std,
        "rig_stiffness": RIG,
    }
    for name, value in truth.items():
        one = written["identification"]["parameters"][name]
        # Half a width beyond the interval: 95 % is not 100 %.
        room = 0.5 * (one["high"] - one["low"])
        assert one["low"] - room < value < one["high"] + room, name
    _predict_takes(folder / "out")


def _predict_takes(out: Path) -> None:
    """The study is one for predict as it is, with the materials of the one that was given."""
    text = (out / "joint.toml").read_text("utf-8")
    assert tomllib.loads(text)["not_identified"] == ["surface.radius"]
    assert "density * sqrt(radius)" in text
    assert "not identified" in text
    study = tomllib.loads(text)
    assert study["material"] == tomllib.loads(STUDY)["material"]
    assert study["joint"]["normal_load"] == ["500 N", "2 kN"]
    outcome = run(
        "predict",
        "out/joint.toml",
        "--json",
        "--set",
        'output.formats=["csv"]',
        "--set",
        "output.report=false",
    )
    assert outcome.exit_code == 0, outcome.output
    limits = [joint["force_limit"] for joint in json.loads(outcome.stdout)["joints"]]
    assert limits == pytest.approx([275.0, 1100.0], rel=2e-3)


@pytest.mark.slow
def test_what_tightening_and_pressure_made_of_the_surface_is_left_out(folder: Path) -> None:
    """Both change the law under the fit, so a fit is of the surface as it was made, and says so."""
    changed = 'tightening_load = "4 kN"\npressure = { kind = "cone", outer = "7 mm" }\n'
    text = STUDY.replace("friction_coefficient", f"{changed}friction_coefficient", 1)
    (folder / "tightened.toml").write_text(text, encoding="utf-8")
    words = ("light.csv", "heavy.csv", "--held-back", "0", "--study")
    plain, tightened = (summary(*words, name) for name in ("study.toml", "tightened.toml"))
    fits = (told["identification"] for told in (plain, tightened))
    assert len({json.dumps(fit["parameters"], sort_keys=True) for fit in fits}) == 1
    note = tightened["identification"]["notes"][-1]
    assert note.startswith("joint.tightening_load and joint.pressure of the study: left out")
    assert "left out" not in " ".join(plain["identification"]["notes"])


def test_without_a_study_and_without_a_folder(folder: Path) -> None:
    before = sorted(folder.iterdir())
    outcome = run("identify", "light.csv", "heavy.csv")
    assert outcome.exit_code == 0, outcome.output
    assert "name a study" in outcome.stdout.lower()
    assert "spread of the heights σ" not in outcome.stdout
    assert sorted(folder.iterdir()) == before


def test_laws_are_compared() -> None:
    found = summary("heavy.csv", "--law", "interface", "--law", "jenkins")
    assert found["comparison"]["best"] == "interface"
    assert [law["law"] for law in found["comparison"]["laws"]] == ["interface", "jenkins"]
    assert [other["law"] for other in found["others"]] == ["jenkins"]
    outcome = run("identify", "heavy.csv", "--law", "jenkins", "--law", "interface")
    assert "Laws compared" in outcome.stdout
    assert outcome.stdout.splitlines()[1].startswith("jenkins: ")


# -- what it is told -------------------------------------------------------------------------------


def test_values_are_fixed_bounded_and_known() -> None:
    found = summary(
        "heavy.csv", "light.csv", "--fix", "slip_scale=0.343 um", "--rig-stiffness", "500±10 N/um",
        "--bound", "friction_coefficient=0.3..0.8", "--held-back", "0", "--confidence", "0.9",
    )["identification"]  # fmt: skip
    assert found["confidence"] == 0.9
    assert found["held_back"] is None
    one = found["parameters"]["slip_scale"]
    assert (one["value"], one["verdict"]) == (0.343e-6, "fixed")
    assert found["parameters"]["rig_stiffness"]["value"] == pytest.approx(5e8, rel=0.01)


def test_loads_of_records() -> None:
    for name in ("light", "heavy"):
        path = Path(f"{name}.csv")
        record = ms.Record.read(path)
        ms.Record(record.displacement, record.force, sample_rate=2560).to_csv(path, overwrite=True)
    found = summary("light.csv", "heavy.csv", "--normal-load", "500 N", "--normal-load", "2 kN")
    loads = [record["normal_load"] for record in found["identification"]["records"]]
    assert loads == [500.0, 2000.0]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("free", "free"),
        ("rigid", None),
        ("200 N/um", 2e8),
        ("200±5 N/um", (2e8, 5e6)),
        ("200 N/um ± 5", (2e8, 5e6)),
        ("200 N/um +/- 5e6 N/m", (2e8, 5e6)),
    ],
)
def test_rig_stiffness(text: str, value: Any) -> None:
    got = rig_stiffness_of(text)
    if value is None or value == "free":
        assert got == value
    else:
        np.testing.assert_allclose(got, value, rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "factors", "error"),
    [
        ("force=1±0.01", (), 0.01),
        ("force=200±2 N/V", ("force=200 N/V",), 0.01),
        ("force=12.5 N/V +- 2 %", ("force=12.5 N/V",), 0.02),
        ("force=12.5 N/V", ("force=12.5 N/V",), None),
    ],
)
def test_calibration(text: str, factors: tuple[str, ...], error: float | None) -> None:
    """A factor of one changes no number; its deviation is a share of it."""
    found, errors = calibration_of((text,))
    assert found == factors
    assert errors == ({} if error is None else {"force": pytest.approx(error)})


def test_known() -> None:
    """A value, its deviation, and a unit once or twice."""
    given = ("radius=1±0.1 mm", "density=100 1/mm^2 +- 5", "force_limit at 500 N=275 N±1 N")
    got = known_of(given, ("interface",))
    np.testing.assert_allclose(got["radius"], (1e-3, 1e-4))
    np.testing.assert_allclose(got["density"], (1e8, 5e6))
    np.testing.assert_allclose(got["force_limit at 500 N"], (275.0, 1.0))
    found = summary(
        "light.csv", "heavy.csv", "--study", "study.toml", "--known", "radius=1±0.1 mm",
        "--held-back", "0",
    )["identification"]  # fmt: skip
    assert found["parameters"]["radius"]["value"] == pytest.approx(1e-3, rel=0.02)
    assert found["derived"]["density"]["low"] < 1e8 < found["derived"]["density"]["high"]


@pytest.mark.slow
def test_rigs_that_differ_are_reported(folder: Path) -> None:
    rig = ms.VirtualTribometer(
        JOINT.at(normal_load=2000.0), rig_stiffness=2e8, noise=0.003, sample_rate=2560, seed=3
    )
    rig.record(amplitude=6e-6, frequency=10.0, cycles=6).to_csv("soft.csv")
    outcome = run("identify", "light.csv", "soft.csv", "--study", "study.toml", "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    assert "(records differ: rigs)" in outcome.stdout.splitlines()[1]
    assert "0 of 4 parameters identified" in outcome.stdout


@pytest.mark.slow
def test_what_was_given_and_the_loops_disagree(folder: Path) -> None:
    """It is in the summary, on the terminal and on the page, with its deviations."""
    words = ("identify", "light.csv", "heavy.csv", "--rig-stiffness", "400±1 N/um", "-o", "out")
    outcome = run(*words, "--study", "study.toml", "--held-back", "0")
    assert outcome.exit_code == 0, outcome.output
    page = (folder / "out/report.html").read_text("utf-8")
    for text in (outcome.stdout, page):
        assert "Given values" in text
        assert "disagrees" in text
        assert "iven values and the loops disagree: " in text
    text = (folder / "out/joint.toml").read_text("utf-8").replace("\n# ", " ")
    assert "given values and the loops disagree: rig_stiffness was given as 400 MN/m" in text
    assert "IN DOUBT: " in text
    (given,) = json.loads((folder / "out/summary.json").read_text("utf-8"))["identification"][
        "given"
    ]
    assert (given["value"], given["uncertainty"]) == (4e8, 1e6)
    assert given["residual"] > 3.0
    assert not given["agrees"]
    assert given["without"] == pytest.approx(RIG, rel=0.02)


def test_a_turned_force_is_reported_with_its_option() -> None:
    record = ms.Record.read("heavy.csv")
    ms.Record(record.displacement, -record.force, normal_load=2000.0, sample_rate=2560).to_csv(
        "turned.csv"
    )
    message = fails("identify", "turned.csv")
    assert "the loops run the wrong way round (energy -" in message
    assert "(reading with sign=-1 reverses it)" in message


# -- what it refuses -------------------------------------------------------------------------------

WRONG = {
    ("--fix", "slip_scal=1 um"): '--fix: no parameter "slip_scal"; did you mean "slip_scale"?',
    ("--fix", "slip_scale"): "--fix wants WHAT=..., such as force=..., got",
    ("--fix", "friction_coefficient=1 N"): "--fix: friction_coefficient is a plain number",
    ("--bound", "slip_scale=2..1 um"): "LOW below HIGH",
    ("--rig-stiffness", "stiff"): '--rig-stiffness: wanted a stiffness such as "200 N/um"',
    ("--contact-area", "6 mm^2"): "--contact-area wants an area, its uncertainty and the load",
    ("--known", "radius=1 mm"): '--known wants radius=VALUE±DEVIATION, got "1 mm"',
    ("--normal-load", "1 N", "--normal-load", "2 N", "--normal-load", "3 N"):
        "--normal-load wants one for all records or one for each of the 2 records, got 3",
    ("--rig", "a"): "--rig wants a label for each of the 2 records, got 1",
    ("--contact-area", "1000 mm^2, 1 mm^2, 2 kN", "--study", "study.toml"):
        "--contact-area must not be above the apparent area",
    ("--confidence", "2"): "confidence must be between 0 and 1, got 2",
}  # fmt: skip


@pytest.mark.parametrize("words", WRONG, ids=" ".join)
def test_command_refuses(words: tuple[str, ...]) -> None:
    assert WRONG[words] in fails("identify", "light.csv", "heavy.csv", "-o", "out", *words)


def test_a_fit_that_does_not_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    """No numbers without asking for them, and no file."""
    from microslip.identification import fit

    for limit in ("_MOST_STEPS", "_MOST_EVALUATIONS"):
        monkeypatch.setattr(fit, limit, 1)
    words = ("identify", "light.csv", "heavy.csv", "-o", "out")
    message = fails(*words)
    assert message.startswith("error: interface: not converged: ")
    assert message.endswith("(--accept-unconverged shows it all the same)")
    outcome = run(*words, "--accept-unconverged")
    assert outcome.exit_code == 0, outcome.output
    assert outcome.stdout.splitlines()[1].startswith("interface: ")
    assert "(not converged)" in outcome.stdout.splitlines()[1]


def test_nothing_is_replaced_unasked(folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out/mine.txt").write_text("mine", encoding="utf-8")
    assert "out: exists; replace it" in fails("identify", "heavy.csv", "-o", "out")
    assert "it is no identification" in fails("identify", "heavy.csv", "-o", "out", "--overwrite")
    assert (folder / "out/mine.txt").read_text("utf-8") == "mine"


# -- the study as a model of measure ---------------------------------------------------------------


def test_measure_takes_thresholds_from_a_study() -> None:
    outcome = run("measure", "heavy.csv", "--model", "study.toml", "--json")
    assert outcome.exit_code == 0, outcome.output
    thresholds = json.loads(outcome.stdout)["records"][0]["thresholds"]
    load = float(np.mean(ms.Record.read("heavy.csv").normal_load))
    wanted = ms.measure(ms.Record.read("heavy.csv"), model=JOINT.at(normal_load=load)).thresholds
    assert thresholds["source"] == wanted.source
    assert thresholds["gross"] == pytest.approx(wanted.gross, rel=1e-6)


# -- a real record ---------------------------------------------------------------------------------

REAL = Path(__file__).parents[3] / "shared/data/reciprocating/test_data_2.txt"


@pytest.mark.slow
@pytest.mark.skipif(not REAL.exists(), reason="the record in ../shared/data is not here")
def test_real_record(folder: Path) -> None:
    """Friction and rig come out in doubt, the separation does not, and the page says why."""
    laws = ("--law", "interface", "--law", "segalman")
    outcome = run("identify", str(REAL), "--flip-sign", *laws, "-o", "out")
    assert outcome.exit_code == 0, outcome.output
    summary = json.loads((folder / "out/summary.json").read_text("utf-8"))
    rig = summary["identification"]["parameters"]["rig_stiffness"]
    assert 4e4 < rig["low"] < rig["high"] < 5e4
    other = summary["comparison"]["rigs"]["rig_stiffness"]["segalman"]
    assert other["low"] < rig["low"]
    # Segalman's model leaves it open, or nearly so.
    assert other["high"] is None or other["high"] > 100.0 * rig["high"]
    page = (folder / "out/report.html").read_text("utf-8")
    assert "separation h = d/σ at 5 N, not identified" in page
    assert "To determine it:" in page
    assert "the best fit of a law does not prove the law" in page
    for text in (page, outcome.stdout.replace("\n", " ")):
        assert (
            "found as a mean over drifting cycles, so it describes no single state of the joint"
            in text
        )
        assert "The stiffness of the rig over the laws: " in text


# -- campaigns and delays --------------------------------------------------------------------------


def test_campaign_beside_the_joint(folder: Path) -> None:
    """Worn volumes and runs of a folder: wear and comparison stand beside the joint."""
    for label, name in (("a", "light.csv"), ("b", "heavy.csv")):
        (folder / "rigs" / label).mkdir(parents=True)
        (folder / name).rename(folder / "rigs" / label / name)
    found = summary("rigs", "--worn-volume", "0.01 mm^3", "--worn-volume", "0.02 mm^3")
    campaign = found["campaign"]
    assert [row["run"] for row in campaign["table"]] == ["a", "b"]
    assert campaign["wear"]["unit"] == "m^3/J"
    assert campaign["wear"]["value"] > 0.0
    assert len(campaign["fretting_map"]) == 2


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--delay", "3 mm"), "--delay: wanted a time"),
        (("--delay", "1 ms", "--free-delay"), "contradict each other"),
        (("--worn-volume", "1 mm^3"), "one for each of the 2 records"),
    ],
)
def test_bad_delays_and_volumes(folder: Path, words: tuple[str, ...], says: str) -> None:
    outcome = run("identify", "light.csv", "heavy.csv", *words)
    assert outcome.exit_code == 2
    assert says in " ".join(outcome.stderr.split())


def test_a_delay_that_is_given() -> None:
    """A force taken for late that is not late is answered worse."""
    words = ("heavy.csv", "--held-back", "0", "--rig-stiffness", "free")
    late, timely = (summary(*words, "--delay", delay) for delay in ("2 ms", "0 s"))
    first, second = (found["identification"]["reduced_chi_squared"] for found in (late, timely))
    assert first > 3.0 * second
