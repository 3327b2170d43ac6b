"""Laws as Iwan's cells for a range of amplitudes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from cases import invertible_laws, reach_of

import microslip as ms

JOINT = ms.Interface.examples()[0]
REACH = reach_of(JOINT)


@invertible_laws
def test_stiffness_and_limit_are_exact_and_the_polygon_is_above(law: Any) -> None:
    reach = reach_of(law)
    cells = law.to_iwan(40, smallest_amplitude=1e-2 * reach, largest_amplitude=10.0 * reach)
    assert cells.force_limit == pytest.approx(law.force_limit, rel=1e-12)
    assert cells.tangential_stiffness == pytest.approx(law.tangential_stiffness, rel=1e-9)
    a = reach * np.geomspace(1e-3, 20.0, 200)
    assert (cells.backbone(a) >= law.backbone(a) * (1.0 - 1e-9)).all()
    assert cells.cell_count <= 40
    assert isinstance(cells, ms.Iwan)


def test_statements_of_the_fit_are_true() -> None:
    cells = JOINT.to_iwan(50, smallest_amplitude=3e-9, largest_amplitude=1e-5)
    fit = cells.fit
    assert fit is not None
    assert (fit.smallest_amplitude, fit.largest_amplitude) == pytest.approx((3e-9, 1e-5))
    a = np.geomspace(3e-9, 1e-5, 3000)
    energies = cells.dissipated_energy(a) / JOINT.dissipated_energy(a) - 1.0
    forces = cells.backbone(a) / JOINT.backbone(a) - 1.0
    for errors, told in ((energies, fit.energy_error), (forces, fit.backbone_error)):
        assert np.abs(errors).max() <= told <= 1.05 * np.abs(errors).max()
    assert abs(energies[0]) < 0.03
    assert JOINT.to_iwan(50).fit is None


SPHERE = ms.Interface(ms.SphereOnFlat(JOINT.surface.pair, radius=5e-3), 0.3, normal_load=10.0)


@pytest.mark.parametrize("share", [0.1, 0.3, 1.0, 3.0])
@pytest.mark.parametrize("law", [JOINT, SPHERE], ids=["rough", "sphere"])
def test_a_range_may_end_in_partial_slip(law: Any, share: float) -> None:
    """At its largest amplitude, too, errors fall with the square of the number of cells."""
    reach = law.force_limit / law.tangential_stiffness
    low, high = 0.01 * share * reach, share * reach
    a, worst = np.append(np.geomspace(low, high, 20_001)[:-1], high), []
    for count in (50, 200, 800):
        cells = law.to_iwan(count, smallest_amplitude=low, largest_amplitude=high)
        fit = cells.fit
        assert fit is not None
        errors = np.abs(cells.dissipated_energy(a) / law.dissipated_energy(a) - 1.0)
        assert errors.max() <= fit.energy_error
        assert np.abs(cells.backbone(a) / law.backbone(a) - 1.0).max() <= fit.backbone_error
        worst.append(max(fit.energy_error, fit.backbone_error))
        if count == 200:
            assert worst[-1] <= 1e-3
    assert np.log2(worst[0] / worst[1]) > 2.0 * 1.7, worst
    assert np.log2(worst[1] / worst[2]) > 2.0 * 1.7, worst


def test_small_cycles_are_met_where_even_cells_miss_them() -> None:
    a = 0.01 * REACH
    wanted = JOINT.dissipated_energy(a)
    cells = JOINT.to_iwan(50, smallest_amplitude=a)
    assert abs(cells.dissipated_energy(a) / wanted - 1.0) < 0.03
    shares = (np.arange(50) + 0.5) / 50  # of equal force
    even = ms.Iwan(
        JOINT.force_limit / 50 / JOINT.backbone_displacement(shares * JOINT.force_limit),
        np.full(50, JOINT.force_limit / 50),
    )
    assert even.dissipated_energy(a) == 0.0
