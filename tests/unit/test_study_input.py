"""Studies: what is read from files, text and Python."""

from __future__ import annotations

import copy
import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from studies import AMPLITUDES, LOADS, MATERIAL, STUDY, edited

import microslip as ms
from microslip._core import units
from microslip._core.units import (
    AREA,
    DENSITY,
    FORCE,
    LENGTH,
    MASS,
    PRESSURE,
    STIFFNESS,
    QuantityError,
    interval_digits,
    to_si,
)
from microslip.contact.materials import metals
from microslip.study.toml_text import dump

LINE = f"amplitudes = {AMPLITUDES}"


# -- what is read ---------------------------------------------------------------------------


def test_quantities_are_si_floats_to_the_last_bit() -> None:
    study = ms.Study.from_toml(STUDY)
    assert study.material["al"].young_modulus == 69e9
    assert study.surface.heights.std == 5e-7
    assert study.surface.density == 1e8
    assert study.surface.area == 2e-4
    assert study.joint.normal_load == (500.0, 2000.0)
    assert study.excitation.amplitudes == (1e-7, 1e-6)
    with pytest.raises(Exception, match="frozen"):
        study.title = "another"


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("0.5 µm", LENGTH, 5e-7),  # micro sign
        ("0.5 μm", LENGTH, 5e-7),  # Greek letter
        ("0.5um", LENGTH, 5e-7),
        (".5e0 micron", LENGTH, 5e-7),
        ("1 in", LENGTH, 0.0254),
        ("2 cm²", AREA, 2e-4),
        ("100 /mm^2", DENSITY, 1e8),
        ("100 mm^-2", DENSITY, 1e8),
        ("100 mm⁻²", DENSITY, 1e8),
        ("1_000 N", FORCE, 1e3),
        ("1 lbf", FORCE, 4.4482216152605),
        ("69000 N/mm^2", PRESSURE, 69e9),
        ("1.5 kg", MASS, 1.5),
        ("20 g", MASS, 0.02),
        ("1 N/um", STIFFNESS, 1e6),
        ("3 kN/mm", STIFFNESS, 3e6),
    ],
)
def test_units_are_read(text: str, kind: object, value: float) -> None:
    assert to_si(text, kind, "") == value


@pytest.mark.parametrize(
    "text",
    [
        *("", " ", "1", "um", "1 m m", "1 2 m", "0x10 m", "nan m", "1 dB", "1 \x1b[31mum"),
        *("1e99999999999999999999 m", "1e400 m", "1e-400 m", "1 m**999999999"),
        "1 __import__('os')",
    ],
)
def test_odd_quantities_are_refused_on_one_line(text: str) -> None:
    with pytest.raises(QuantityError) as caught:
        to_si(text, LENGTH, "1 um")
    assert str(caught.value).isprintable()


# -- materials --------------------------------------------------------------------------------


def test_a_metal_of_the_table_needs_no_entry_and_says_its_sources() -> None:
    study = ms.Study.from_toml(edited((MATERIAL, ""), ('["al", "al"]', '["steel", "al2017"]')))
    assert list(study.material) == ["steel", "al2017"]
    for name, material in study.material.items():
        metal = metals()[name]
        for key in ("young_modulus", "poisson_ratio", "hardness"):
            assert getattr(material, key) == getattr(metal, key)
    steel, al = study.notes
    source = "EN 1993-1-1:2005, 3.2.6"
    assert steel == (
        "material.steel is taken from the table of metals: "
        f"young_modulus 210 GPa ({source}); poisson_ratio 0.3 ({source}); "
        f"hardness 1.03 GPa ({metals()['steel'].sources['hardness']})."
    )
    assert all(source in al for source in metals()["al2017"].sources.values())


def test_own_numbers_win_over_the_table() -> None:
    own = '[material.steel]\nyoung_modulus = "205 GPa"\n'
    study = ms.Study.from_toml(edited((MATERIAL, own), ('["al", "al"]', '["steel", "steel"]')))
    assert study.material["steel"].young_modulus == 205e9
    assert study.material["steel"].poisson_ratio == metals()["steel"].poisson_ratio
    assert "young_modulus" not in study.notes[0]
    assert "poisson_ratio 0.3 (" in study.notes[0]


# -- columns ----------------------------------------------------------------------------------

# The file, the entry besides its name, and the values in metres.
COLUMNS = [
    ("t [s],x [um]\n0,0.1\n1,-2\n", 'column = "x"', [1e-7, -2e-6]),
    ("t [s],x [um]\n0,0.1\n1,-2\n", 'column = "x [um]"', [1e-7, -2e-6]),
    ("x (mm);F (N)\n0,1;5\n-2;6\n", 'column = "x"', [1e-4, -2e-3]),
    ("x\tF\n0,1\t5\n-2\t6\n", 'column = "x", unit = "um"', [1e-7, -2e-6]),
    ("x\tF\n0.1\t5\n-2\t6\n", 'column = "x", unit = "um"', [1e-7, -2e-6]),
    ("x [um]\n1\n2\n", 'column = "x", unit = "micron"', [1e-6, 2e-6]),
    ("x (left)\n1\n2\n", 'column = "x", unit = "um"', [1e-6, 2e-6]),
    ("\ufeffx [µm]\r\n1e0\r\n2E-1\r\n", 'column = "x"', [1e-6, 2e-7]),
    ('"x, left [um]",y\n"1",2\n"3",4\n', 'column = "x, left"', [1e-6, 3e-6]),
    ('x [um],y\n"1,5",2\n"3,5",4\n', 'column = "x"', [1.5e-6, 3.5e-6]),
    ("x;y\num;N\n1;2\n3;4\n", 'column = "X"', [1e-6, 3e-6]),
    ("1 2\n3 4\n", 'column = "#2", unit = "um"', [2e-6, 4e-6]),
    ("# rig 7\n\nx [um];y;\n1;2;\n\n;;\n ;\n3;4;\n", 'column = "x"', [1e-6, 3e-6]),
    ("# rig 7\n# x [um], y\n1, 2\n3, 4\n", 'column = "x"', [1e-6, 3e-6]),
    ("y, x [in]\n0, 1\n0, \N{MINUS SIGN}.5\n", 'column = "x"', [0.0254, -0.0127]),
]


@pytest.mark.parametrize(("content", "entry", "values"), COLUMNS)
def test_a_column_is_read_with_its_unit(
    content: str, entry: str, values: list[float], tmp_path: Path
) -> None:
    (tmp_path / "x.csv").write_text(content, encoding="utf-8", newline="")
    text = edited((LINE, f'history = {{ file = "x.csv", {entry} }}'))
    (tmp_path / "joint.toml").write_text(text)
    history = ms.Study.load(tmp_path / "joint.toml").excitation.history
    assert history.values.tolist() == values
    assert history.quantity == "displacement"
    assert ms.Study.from_toml(text, folder=str(tmp_path)).excitation.history == history


# -- overrides --------------------------------------------------------------------------------


def test_overrides_replace_keys_and_keep_comments() -> None:
    text = edited(("[joint]", "# how it is held\n[joint]"), (LOADS, f"{LOADS}  # by a screw"))
    overrides = [
        'joint.normal_load=["1 kN", "3 kN"]',
        "surface.heights.std=0.7 um",
        "joint.friction_coefficient = 0.2",
        "title=Another joint",
    ]
    study = ms.Study.from_toml(text, overrides=overrides)
    assert study.joint.normal_load == (1000.0, 3000.0)
    assert study.joint.friction_coefficient == 0.2
    assert study.surface.heights.std == 7e-7
    assert study.title == "Another joint"
    assert "# how it is held\n[joint]" in study.text
    assert '["1 kN", "3 kN"]  # by a screw' in study.text
    assert study.text.startswith('schema = 1\ntitle = "Another joint"\n')
    assert study.notes[:2] == (
        'joint.normal_load was overridden: ["1 kN", "3 kN"].',
        "surface.heights.std was overridden: 0.7 um.",
    )
    again = ms.Study.from_toml(study.text)
    assert again.by_keys() == study.by_keys()


# -- in Python --------------------------------------------------------------------------------


@given(
    st.recursive(
        st.one_of(
            *(st.booleans(), st.integers(-(2**63), 2**63 - 1), st.dates(), st.text('aµ"\\\n\x7f ')),
            st.floats(allow_nan=False),
        ),
        lambda inner: st.one_of(
            st.lists(inner, max_size=3), st.dictionaries(st.text('ab."µ '), inner, max_size=3)
        ),
        max_leaves=12,
    ).filter(lambda value: isinstance(value, dict))
)
def test_what_is_dumped_is_read_back(data: Any) -> None:
    assert tomllib.loads(dump(data)) == data


def test_a_study_is_copied_and_pickled_whole() -> None:
    study = ms.Study.from_toml(STUDY, "joint.toml", overrides=["joint.normal_load=3 kN"])
    for other in (copy.deepcopy(study), pickle.loads(pickle.dumps(study)), study.copy()):
        assert other == study
        assert (other.name, other.text, other.notes) == (study.name, study.text, study.notes)


def test_absurdly_deep_keys_are_refused_at_once() -> None:
    deep = "a." * 100_000 + "a"
    for text in (f"{deep} = 1", f"[{deep}]", f"x = {{ {deep} = 1 }}", f"x.'a'.{deep} = 1"):
        with pytest.raises(ms.StudyError, match="not a study: a key of more than 200 levels"):
            ms.Study.from_toml(f"schema = 1\n{text}\n")
    with pytest.raises(ms.StudyError, match=r'override "a\.a.*: a key of more than 200 levels'):
        ms.Study.from_toml("schema = 1\n", overrides=[f"{deep}=1"])


@pytest.mark.parametrize(
    "law",
    [
        ms.Jenkins(stiffness=5e7, force_limit=100.0),
        ms.Coulomb(100.0),
        ms.Iwan([2e7, 3e7], [20.0, 80.0]),
        ms.SegalmanIwan(force_limit=100.0, stiffness=5e7, chi=-0.5, beta=1.0),
    ],
    ids=lambda law: type(law).__name__,
)
@pytest.mark.parametrize("excitation", ["", 'amplitudes = ["1 um", "5 um"]'], ids=["own", "given"])
def test_a_law_of_a_file_predicts_as_in_python(
    law: ms.BackboneLaw, excitation: str, tmp_path: Path
) -> None:
    """With every file that there is, drawn figures included, for rigid laws and discrete ones."""
    ms.friction.save_law(law, tmp_path / "law.json")
    text = f'schema = 1\n[joint]\nlaw_file = "law.json"\n[excitation]\n{excitation}\n'
    study = ms.Study.from_toml(text, folder=tmp_path)
    result = study.run()
    (joint,) = result.summary["joints"]
    a = [row["amplitude"] for row in joint["amplitudes"]]
    assert [row["dissipated_energy"] for row in joint["amplitudes"]] == list(
        law.dissipated_energy(a)
    )
    assert joint["normal_load"] is None
    assert result.save(tmp_path / "out")
    again = ms.Study.load(tmp_path / "out" / "study.toml")  # the path of the file still leads there
    assert again.joint.friction_law.force(3e-6) == law.force(3e-6)
    assert pickle.loads(pickle.dumps(study)) == study


def test_wrong_law_files_are_refused_at_their_key(tmp_path: Path) -> None:
    (tmp_path / "law.json").write_text("{}")
    for lines, message in (
        ('law_file = "none.json"', "joint.law_file: none.json: no such file in the folder of the"),
        ('law_file = "law.json"', "joint.law_file: law.json: is not a law file"),
        (
            'law_file = "law.json"\nnormal_load = "1 N"',
            "joint.normal_load: wanted no normal_load with",
        ),
        ('law = "jenkins"', "joint.law: removed in 0.3; leave it out for an interface, or write"),
    ):
        with pytest.raises(ms.StudyError, match=message):
            ms.Study.from_toml(f"schema = 1\n[joint]\n{lines}\n", folder=tmp_path)
    ms.friction.save_law(ms.Coulomb(100.0), tmp_path / "law.json", overwrite=True)
    text = edited(("[joint]", '[joint]\nlaw_file = "law.json"'))
    text = text.replace(f"normal_load = {LOADS}\n", "").replace("friction_coefficient = 0.55\n", "")
    with pytest.raises(ms.StudyError, match=r"wanted no \[surface\] with joint\.law_file"):
        ms.Study.from_toml(text, folder=tmp_path)


# -- units without pint ----------------------------------------------------------------------------


def test_common_units_are_what_pint_makes_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    texts = [
        f"{prefix}{base}{end}"
        for prefix in units._PREFIX
        for base in units._SIMPLE
        for end in ("", "^2", "/um", "/mm^2", "^3/s")
    ]
    quick = [units._simple(text) for text in texts]
    assert None not in quick
    monkeypatch.setattr(units, "_simple", lambda unit: None)
    assert quick == [units._parse.__wrapped__(text) for text in texts]


@pytest.mark.parametrize(
    ("low", "high", "value", "digits"),
    [(3.28e-7, 3.32e-7, 3.3e-7, 3), (0.5499, 0.5501, 0.55, 5), (1.0, 2.0, 1.5, 3),
     (1.0, math.inf, 2.0, 4), (None, 1.0, 0.5, 4), (-1.0, 1.0, 0.0, 4)],
)  # fmt: skip
def test_an_estimate_and_its_interval_have_the_same_digits(low, high, value, digits) -> None:
    assert interval_digits(low, high, value) == digits
