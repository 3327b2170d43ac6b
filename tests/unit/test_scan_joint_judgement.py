"""The joint of a scan under a load: requests that lack a part of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command import fails

from microslip.surfaces import random_surface

ARGUMENTS = ("surface", "worn.npy", "--unit", "um", "--pixel", "1 um", "--cutoff", "6 um")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--load", "5 N"), '--load requires --materials "steel" "steel"'),
        (("--materials", "steel", "steel"), '--materials requires --load "500 N"'),
        (("--amplitude", "1 um"), '--amplitude requires --materials "steel" "steel" and --load'),
        (("--materials", "steel", "cheese", "--load", "5 N"), "no metal is named 'cheese'"),
        (("--materials", "steel, steel", "--load", "5 N"), "--materials takes 2 values"),
        (("--materials", "steel", "--load", "5 N"), "--materials takes 2 values"),
        (("--load", "5 kg"), "--load: wanted a force"),
    ],
)
def test_a_joint_with_half_of_its_keys(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    scan = random_surface((96, 96), 1e-6, m0=1e-13, m2=1e-3, m4=4e7, seed=5)
    np.save("worn.npy", scan.heights * 1e6)
    assert message in fails(*ARGUMENTS, *options)
