"""Contact cards read by others' readers of their formats; `tools/try_hosts.sh` installs these."""

import pytest
from exported import JOINT

from microslip import export


def test_lsdyna_reads_its_keywords(tmp_path):
    dyna = pytest.importorskip(
        "ansys.dyna.core", reason="ansys-dyna-core is not installed; make hosts runs this"
    )
    card = export.write_card("ls-dyna", JOINT, tmp_path / "card.k", units="mm", density=2700.0)
    deck = dyna.Deck()
    deck.loads("*KEYWORD\n" + (tmp_path / "card.k").read_text() + "*END\n")
    (layer,) = deck.get_kwds_by_full_type("MAT", "COHESIVE_ELASTIC")
    assert layer.en * 1e9 == pytest.approx(card.normal_stiffness, rel=5e-5)
    assert layer.et * 1e9 == pytest.approx(card.layer.shear_modulus / 1e-3, rel=5e-5)
    assert layer.ro * 1e12 == pytest.approx(2700.0, rel=1e-4)
