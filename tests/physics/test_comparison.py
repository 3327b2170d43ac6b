"""The Extended Greenwood Model beside Coulomb, Iwan, Segalman and one asperity: section 4.3, 4.5.

What the chapter says of them, measured; and how the model turns into each of them.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import is_curved, law_params, reach_of
from scipy.optimize import brentq, least_squares
from sliders import stops
from usual import PAIR

import microslip as ms

MU, STD, AREA = 0.55, 5e-7, 2e-4
CURVED = pytest.mark.parametrize("law", law_params(which=is_curved))
INTERFACES = pytest.mark.parametrize(
    "law", law_params(which=lambda law: isinstance(law, ms.Interface))
)


def surface(density: float = 1e8) -> ms.GreenwoodWilliamson:
    return ms.GreenwoodWilliamson(PAIR, ms.Gaussian(STD), radius=1e-3, density=density, area=AREA)


def worked() -> ms.Interface:
    return ms.Interface(surface(), MU, normal_load=2000.0)


def ball() -> ms.Asperity:
    return ms.Asperity(PAIR, radius=5e-3, friction_coefficient=MU, normal_load=10.0)


def even(stiffness: float, limit: float, cells: int) -> ms.Iwan:
    """Iwan's own choice, cells whose yield displacements are spread evenly from 0."""
    yields = (np.arange(cells) + 0.5) / cells * 2 * limit / stiffness
    return ms.Iwan(np.full(cells, stiffness / cells), stiffness / cells * yields)


# -- every joint is an Iwan model ------------------------------------------------------------------


def displacements(law: ms.BackboneLaw, cells: ms.Iwan) -> np.ndarray:
    """Everywhere, and at the corners of the cells' polygon, where it is farthest from a tangent."""
    anywhere = reach_of(law) * np.geomspace(1e-6, 1e5, 301)
    return np.concatenate(([0.0], anywhere, cells.sliders().yield_displacements))


def constant_of(law: ms.BackboneLaw) -> float:
    """(integral of sqrt(-T0''))^2/8 over the force limit, where the density is smooth."""
    u = reach_of(law) * np.geomspace(1e-6, 1e8, 4001)
    root = np.sqrt(np.nan_to_num(law.sliders().density(u), posinf=0.0))
    return float(np.trapezoid(root, u)) ** 2 / (8.0 * law.force_limit)


@CURVED
def test_cells_converge_to_the_backbone_at_second_order(law):
    """Infinite densities (given summits), endless ones and last sliders included."""
    counts, errors = (16, 32, 64, 128, 256, 512), []
    for count in counts:
        cells = law.to_iwan(count)
        assert cells.cell_count <= count
        assert cells.force_limit == pytest.approx(law.force_limit, rel=1e-13, abs=0)
        # Light loads hang on the last place of the separation.
        assert cells.tangential_stiffness == pytest.approx(
            law.tangential_stiffness, rel=1e-12, abs=0
        )
        u = displacements(law, cells)
        off = (cells.backbone(u) - law.backbone(u)) / law.force_limit
        assert off.min() > -1e-13, "tangents never lie below"
        errors.append(off.max())
    order = np.log2(errors[0] / errors[-1]) / np.log2(counts[-1] / counts[0])
    assert 1.9 < order < 2.1
    # The same constant throughout, (integral of sqrt(-T0''))^2/8, but for where knots fall between
    # summits, or a cell contains a step of the density (drawn faces: by a factor of up to 2).
    scaled = np.array(errors) * np.array(counts) ** 2
    steps = 2.0 if isinstance(getattr(law, "surface", None), ms.DrawnFace) else 1.05
    assert scaled.max() < max(0.68, steps * constant_of(law))
    assert scaled.max() / scaled.min() < 2.2


def test_constant_of_the_convergence():
    """Of an exponential (sqrt: 2) and a parabola (sqrt 2): 4/8 and 2/8 over the square."""
    exponential = ms.GreenwoodWilliamson(PAIR, ms.Exponential(8e-7), 1e-4, 2e9, 5e-4)
    joint = ms.Interface(exponential, 0.3, separation=1e-6)
    parabola = ms.SegalmanIwan(100.0, 1e7, 0.0, 0.0)
    for law, constant in ((joint, 0.5), (parabola, 0.25)):
        for count in (10, 40, 160):
            cells = law.to_iwan(count)
            u = displacements(law, cells)
            off = cells.backbone(u) - law.backbone(u)
            wanted = constant / count**2 * law.force_limit
            assert off.max() == pytest.approx(wanted, rel=0.02, abs=0)


@CURVED
def test_energies_of_cells_converge_at_second_order(law):
    """Too large at the knots, too small before a cell yields."""
    a = reach_of(law) * np.geomspace(0.3, 30, 60)
    wanted, errors = law.dissipated_energy(a), []
    for count in (16, 32, 64, 128, 256):
        errors.append(np.abs(law.to_iwan(count).dissipated_energy(a) / wanted - 1).max())
    assert 1.7 < np.log2(errors[0] / errors[-1]) / 4 < 2.5
    # Too small for the first cell, a cycle is free of loss, whatever the number of cells.
    cells = law.to_iwan(64)
    small = 0.999 * cells.sliders().yield_displacements.min()
    assert cells.dissipated_energy(small) == 0 < law.dissipated_energy(small)


@INTERFACES
def test_histories_of_cells(law):
    """Cells that know nothing of memory rules do what the joint does, to the error of the cells."""
    rng = np.random.default_rng(2)
    path = rng.normal(size=40) * reach_of(law)
    cells = law.to_iwan(200)
    yields, stiffnesses = cells.sliders().yield_displacements, cells.sliders().stiffnesses
    forces, _ = stops(path, stiffnesses, yields)
    # Twice the error of the backbone for each of the branches that are open.
    error = 1e-4 * law.force_limit
    np.testing.assert_allclose(forces, law.force(path), rtol=0, atol=error)
    np.testing.assert_allclose(forces, cells.force(path), rtol=0, atol=1e-13 * law.force_limit)


# -- how far four parameters go --------------------------------------------------------------------


def four_parameters(joint: ms.Interface, low: float, high: float) -> tuple[ms.SegalmanIwan, float]:
    """Segalman's law of the same limit and stiffness that fits ln E_d best, and the rms misfit."""
    a = np.geomspace(low, high, 61)

    def law(point: np.ndarray) -> ms.SegalmanIwan:
        return ms.SegalmanIwan(joint.force_limit, joint.tangential_stiffness, *point)

    def misfits(point: np.ndarray) -> np.ndarray:
        return np.log(law(point).dissipated_energy(a) / joint.dissipated_energy(a))

    best = least_squares(misfits, [-0.3, 0.1], bounds=([-0.99, 0.0], [5.0, 50.0]), xtol=1e-12)
    return law(best.x), float(np.sqrt(np.mean(best.fun**2)))


def test_four_parameters_cannot_follow_small_cycles():
    """Sliders of smooth heights are finite at 0: exponent 3. A fit has 3 + chi, and drifts off."""
    joint = worked()
    reach = joint.force_limit / joint.tangential_stiffness
    four, misfit = four_parameters(joint, 0.01 * reach, 10.0 * reach)
    assert four.chi == pytest.approx(-0.143, abs=5e-4)
    assert four.beta == pytest.approx(0.0, abs=1e-9)
    assert misfit == pytest.approx(0.140, abs=5e-4)
    a = 10.0 ** np.arange(-14.0, -9.0)
    ratio = four.dissipated_energy(a) / joint.dissipated_energy(a)
    assert np.all(ratio > 1.5)
    np.testing.assert_allclose(ratio[:-1] / ratio[1:], 10**-four.chi, rtol=0.02)
    assert joint.dissipation_exponent(a[0]) == pytest.approx(3, abs=1e-6)
    assert four.dissipation_exponent(a[0]) == pytest.approx(3 + four.chi, rel=1e-12, abs=0)
    # The exponent fitted is that of the range: a mean of what runs from 3 to 1.
    fits = [four_parameters(joint, low, 10 * low)[0] for low in (1e-10, 1e-9, 1e-8, 1e-7)]
    exponents = [3 + fit.chi for fit in fits]
    assert np.all(np.diff(exponents) < 0)
    assert exponents[0] > 2.9
    assert exponents[-1] < 2.75


# -- section 4.3: the number of asperities ---------------------------------------------------------

GROWTH = surface().load(0.0) / surface().load(STD * np.arange(5))


def growing() -> list[ms.Interface]:
    """One load, so many more asperities that the separation is 0, 1 ... 4 standard deviations."""
    load = surface().load(0.0)
    return [ms.Interface(surface(1e8 * factor), MU, normal_load=load) for factor in GROWTH]


def test_more_asperities_in_contact_are_stiffer():
    """Fig. 19.20 begins at one asperity, which carries the load like a sphere."""
    counts = (1, 2, 100, 500, 2000, 20_000)
    joints = [ms.Interface(surface(n / AREA), MU, normal_load=2000.0) for n in counts]
    touching = [joint.contact_count for joint in joints]
    np.testing.assert_allclose(touching[0], 1, rtol=1e-12)
    np.testing.assert_allclose(touching[-1], 5700, rtol=1e-4)
    stiffness = [joint.tangential_stiffness for joint in joints]
    assert stiffness[-1] / stiffness[0] == pytest.approx(271, abs=0.5)
    # n spheres of one height that share a load are n^(2/3) as stiff as one.
    assert stiffness[1] / stiffness[0] == pytest.approx(2 ** (2 / 3), rel=1e-4)
    ratio = [joint.energy_ratio(1e-6) for joint in joints]
    assert np.all(np.diff(ratio) > 0)
    np.testing.assert_allclose([ratio[0], ratio[-1]], [0.0011, 0.6695], atol=6e-5)


def test_more_asperities_than_touch_are_stiffer_but_slowly():
    """Stiffness x slip length/limit = 1.43 ... 4.53 for h = 0 ... 4."""
    joints = growing()
    np.testing.assert_allclose(GROWTH, [1, 5.7, 65, 1.6e3, 9.7e4], rtol=0.02)
    height = [joint.separation / STD for joint in joints]
    np.testing.assert_allclose(height, range(5), atol=1e-12)
    length = joints[0].slip_per_indentation * STD
    assert all(joint.force_limit == joints[0].force_limit for joint in joints)
    stiffness = [joint.tangential_stiffness * length / joint.force_limit for joint in joints]
    np.testing.assert_allclose(stiffness, [1.43, 2.06, 2.82, 3.65, 4.53], atol=0.006)
    contacts = [joint.contact_count for joint in joints]
    np.testing.assert_allclose(contacts, [10_000, 18_033, 29_431, 43_981, 61_360], rtol=1e-4)
    # A hundred thousand times as many asperities: six times as many touch.
    assert contacts[-1] / contacts[0] < 6.2


def test_towards_coulomb():
    """The energy ratio of Coulomb is 1; ten times the stiffness would take 1e199 asperities."""
    joints = growing()
    length = joints[0].slip_per_indentation * STD
    ratio = [joint.energy_ratio(length) for joint in joints]
    np.testing.assert_allclose(ratio, [0.217, 0.322, 0.424, 0.515, 0.589], atol=6e-4)
    assert np.all(np.diff(ratio) > 0)
    far = ms.Interface(surface(), MU, separation=30 * STD)
    assert far.energy_ratio(length) == pytest.approx(0.934, abs=6e-4)
    assert surface().load(0.0) / far.normal_load > 1e198
    # It is the displacement that makes it Coulomb's, at any number of asperities.
    for joint in joints:
        missing = 1 - joint.energy_ratio([1e2 * length, 1e4 * length])
        np.testing.assert_allclose(missing[0] / missing[1], 100, rtol=0.02)
        box = ms.Coulomb(joint.force_limit)
        path = 1e4 * length * np.array([0.4, 1.0, -0.7, 0.9])
        np.testing.assert_allclose(joint.force(path), box.force(path), rtol=1e-9)


def test_one_asperity_is_an_iwan_model():
    """Fig. 19.21, put right: slider density like (1 - u/limit)^(-1/2), not more or fewer cells."""
    sphere = ball()
    limit = -sphere.slip_per_indentation * sphere.separation
    u = limit * np.array([0.0, 0.3, 0.9, 0.999])
    wanted = 0.75 * sphere.force_limit / limit**2 / np.sqrt(1 - u / limit)
    np.testing.assert_allclose(sphere.sliders().density(u), wanted, rtol=1e-12)
    # Evenly spread cells of the same stiffness and limit become a parabola, 2/27 away at most.
    x = np.linspace(0, 2 * limit, 200_001)
    off = [
        np.abs(even(sphere.tangential_stiffness, sphere.force_limit, n).backbone(x)
               - sphere.backbone(x)).max() / sphere.force_limit
        for n in (1, 2, 5, 20, 1000)
    ]  # fmt: skip
    np.testing.assert_allclose(off, [0.1924, 0.0625, 0.0720, 0.0739, 0.0741], atol=6e-5)
    assert off[-1] == pytest.approx(2 / 27, rel=1e-3, abs=0)
    # With its own sliders the cells become the asperity.
    own = [
        np.abs(sphere.to_iwan(n).backbone(x) - sphere.backbone(x)).max() / sphere.force_limit
        for n in (5, 20, 1000)
    ]
    np.testing.assert_allclose(own, [7.4e-3, 4.6e-4, 1.7e-7], rtol=0.02)
    # And a rough surface is as much of an Iwan model as the asperity is.
    joint = worked()
    y = np.linspace(0, 5e-6, 20_001)
    error = np.abs(joint.to_iwan(1000).backbone(y) - joint.backbone(y)).max()
    assert error < 5e-7 * joint.force_limit


def test_energies_of_the_models_at_the_slip_limit():
    """Coulomb 1, one cell 1/3, evenly many and the asperity 1/5: the ratio A at the limit."""
    sphere = ball()
    limit = -sphere.slip_per_indentation * sphere.separation
    assert ms.Coulomb(sphere.force_limit).energy_ratio(limit) == 1
    one, many = (even(sphere.tangential_stiffness, sphere.force_limit, n) for n in (1, 2000))
    assert one.energy_ratio(limit) == pytest.approx(1 / 3, rel=1e-12, abs=0)
    assert many.energy_ratio(limit) == pytest.approx(1 / 5, rel=1e-6, abs=0)
    assert sphere.energy_ratio(limit) == pytest.approx(1 / 5, rel=1e-12, abs=0)


# -- section 4.5: Figs. 19.23 and 19.24 ------------------------------------------------------------


@INTERFACES
def test_energy_is_parabolic_nowhere(law):
    """Fig. 19.23: the local exponent runs from 3 to 1 and passes 2."""
    a = reach_of(law) * np.geomspace(1e-6, 1e6, 241)
    exponent = law.dissipation_exponent(a)
    assert exponent[0] == pytest.approx(3, abs=3e-3)
    assert exponent[-1] == pytest.approx(1, abs=1e-5)
    near = a[np.abs(exponent - 2) < 0.1]
    # A finite set of summits may run through it again and again, but never stays.
    assert near.size == 0 or near.max() / near.min() < 3


def test_where_the_worked_joint_looks_parabolic():
    joint = worked()
    place = brentq(lambda a: joint.dissipation_exponent(a) - 2, 1e-8, 1e-5)
    assert place == pytest.approx(5.56e-7, abs=1e-9)
    np.testing.assert_allclose(
        joint.dissipation_exponent([1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4]),
        [2.999, 2.986, 2.849, 1.489, 1.034, 1.003],
        atol=6e-4,
    )


@INTERFACES
def test_loss_factor_saturates_at_coulombs(law):
    """Fig. 19.24: eta tends to 4/pi; what is missing goes like 1/amplitude."""
    a = reach_of(law) * np.array([1e2, 1e3, 1e4, 1e6])
    missing = 1 - law.loss_factor(a) * math.pi / 4
    assert np.all(missing > 0)
    assert missing[-1] < 1e-5
    np.testing.assert_allclose(missing * a, missing[-1] * a[-1], rtol=1e-6, atol=1e-9 * a[-1])
    eta = law.loss_factor(reach_of(law) * np.geomspace(1e-6, 1e6, 241))
    assert np.all(np.diff(eta) > 0), "it rises all the way"
    assert eta[0] < 1e-5
    assert ms.Coulomb(law.force_limit).loss_factor(1e-9) == pytest.approx(4 / math.pi)
