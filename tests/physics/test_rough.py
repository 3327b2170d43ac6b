"""The law of a rough face, against boundary elements made for this test."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import microslip as ms

POINTS = 192
MODULUS = 1e11  # E* [Pa]
SIDE = 1e-3
HURST, ROLL_OFF, SHORTEST = 0.8, SIDE / 4.0, SIDE / 32.0


class HalfSpace:
    """A periodic elastic half space whose pressure is between zero and a hardness, E* = 1."""

    def __init__(self, seed: int, slope: float = 1.0) -> None:
        q = np.hypot(np.fft.fftfreq(POINTS, 1.0 / POINTS)[:, None], np.arange(POINTS // 2 + 1))
        band = (q >= SIDE / ROLL_OFF) & (q <= SIDE / SHORTEST)
        amplitude = np.where(band, np.maximum(q, 1.0) ** (-1.0 - HURST), 0.0)
        noise = np.random.default_rng(seed).standard_normal((POINTS, POINTS))
        waves = amplitude * np.fft.rfft2(noise)
        pairs = np.full(q.shape, 2.0)
        pairs[:, [0, -1]] = 1.0
        steep = 2.0 * math.pi * math.sqrt((pairs * np.abs(q * waves) ** 2).sum()) / POINTS**2
        self.z = np.fft.irfft2(waves, s=(POINTS, POINTS)) * (slope / steep)  # in sides
        self.compliance = np.divide(1.0, math.pi * q, out=np.zeros_like(q), where=q > 0.0)
        self.rms = float(self.z.std())

    def bent(self, p: np.ndarray) -> np.ndarray:
        return np.fft.irfft2(self.compliance * np.fft.rfft2(p), s=p.shape)

    def pressed(self, d: float, p: np.ndarray, hardness: float, z: np.ndarray) -> np.ndarray:
        """Minimum of pKp/2 - p(z - d) between bounds, by projected conjugate gradients."""
        step = before = None
        p, size = np.clip(p, 0.0, hardness), 1.0
        for _ in range(2000):
            gap = self.bent(p) - z + d
            inside = (p > 0.0) & (p < hardness)
            wrong = ((p <= 0.0) & (gap < 0.0)) | ((p >= hardness) & (gap > 0.0))
            free, off = np.where(inside, gap, 0.0), np.where(wrong, gap, 0.0)
            if max(np.abs(free).max(), np.abs(off).max()) < 1e-5 * self.rms:
                return p
            if np.linalg.norm(off) > np.linalg.norm(free):
                free, step = free + off, None
            if step is None or before is None:
                step = -free
            else:
                step = np.where(inside, (free * (free - before)).sum() / size * step - free, 0.0)
            before, size = free, float((free * free).sum())
            far = -(free * step).sum() / (step * self.bent(step)).sum()
            new = np.clip(p + far * step, 0.0, hardness)
            step = None if (new != p + far * step).any() else step
            p = new
        raise AssertionError("boundary elements did not converge")

    def stiffness(self, touching: np.ndarray) -> float:
        """-dp/dd of a contact that stays as it is."""
        rest = touching.astype(float)
        x, way, size = np.zeros_like(rest), rest.copy(), float(rest.sum())
        first = size
        while size > 1e-10 * first:
            bent = np.where(touching, self.bent(way), 0.0)
            far = size / float((way * bent).sum())
            x, rest = x + far * way, rest - far * bent
            before, size = size, float((rest * rest).sum())
            way = rest + size / before * way
        return float(x.mean())


def law_of(space: HalfSpace, hardness: float) -> ms.RoughSurface:
    """The law of such faces on one square metre, in units where E* is 1e11 Pa."""
    body = ms.Material(MODULUS, 0.0, hardness=MODULUS * hardness if hardness < 9.0 else None)
    pair = ms.MaterialPair(body, ms.Material.rigid())
    return ms.RoughSurface(pair, space.rms * SIDE, ROLL_OFF, SHORTEST, 1.0, HURST)


@pytest.mark.slow
@pytest.mark.parametrize("hardness", [0.05, 0.2, 0.6, math.inf])
def test_a_drawing_has_the_stiffness_of_boundary_elements(hardness: float) -> None:
    """Tightened, at half of it and at a quarter, elastic and pressed flat.

    The mean over four faces within 15 %, and each within 35 %: what the law tells of itself.
    """
    ratios = []
    for seed in (21, 22, 23, 24):
        space = HalfSpace(seed)
        p = np.full((POINTS, POINTS), 1e-3)
        for h in (1.7, 1.2, 0.7):
            d = h * space.rms
            p = space.pressed(d, p, hardness, space.z)
            mean, z = float(p.mean()), space.z
            law = law_of(space, hardness)
            if math.isfinite(hardness):
                gap = space.bent(p) - z + d
                z = z + np.where(p >= hardness, np.minimum(gap, 0.0), 0.0)
                law = law.tightened(MODULUS * mean)
            relieved, state = d, p
            for _ in range(3):
                load, stiff = float(state.mean()), space.stiffness(state > 0.0)
                found = float(law.stiffness(law.separation(MODULUS * load)))
                ratios.append(found * SIDE / MODULUS / stiff)
                relieved += 0.6 * load / stiff
                state = space.pressed(relieved, state, math.inf, z)
            if math.isfinite(hardness):
                touching = float(law.contact_area(law.separation(MODULUS * mean)))
                assert touching == pytest.approx(float((p > 0.0).mean()), rel=0.2)
    logs = np.log(ratios).reshape(4, 3, 3)
    assert abs(logs[:, :, 0].mean()) < 0.1
    assert abs(logs.mean()) < 0.15
    assert np.sqrt((logs[:, :, 0] ** 2).mean()) < 0.15
    assert np.abs(logs[:, :, 0]).max() < math.log(1.35)


def miss_of(law: ms.RoughSurface, load: float, stiffness: float) -> float:
    """Logarithm of a stiffness [N/m] over that of the law, divided by the factor that it tells."""
    joint = ms.Interface(law, 0.3, normal_load=load)
    values = {v.name: v.value or 0.0 for v in joint.validity}
    excess = values["stiffness too large by its peaks, as a factor"]
    excess /= values["stiffness too small by worn peaks, as a factor"]
    return math.log(stiffness * excess / joint.normal_stiffness)


def shaped(space: HalfSpace, heights: np.ndarray) -> np.ndarray:
    """A face with the spectrum of this one and, as far as both go together, those heights."""
    heights = np.sort(heights - heights.mean()) * (space.rms / heights.std())
    size, z = np.abs(np.fft.rfft2(space.z)), space.z
    for _ in range(60):
        ranked = np.empty(z.size)
        ranked[np.argsort(z.ravel(), kind="stable")] = heights
        waves = np.fft.rfft2(ranked.reshape(z.shape))
        z = np.fft.irfft2(size * np.exp(1j * np.angle(waves)), s=z.shape)
    return z - z.mean()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "kurtosis"), [("pointed", 4.7), ("peaks", 6.2), ("worn", 6.2), ("even", 2.1)]
)
def test_heights_that_are_not_gaussian_are_reported_as_a_factor(kind: str, kurtosis: float) -> None:
    """The factor of the heights, elastic and tightened, against boundary elements."""
    from scipy.special import ndtri

    x = ndtri((np.arange(POINTS**2) + 0.5) / POINTS**2)
    form = {
        "pointed": np.sinh(1.5 * np.arcsinh(x)), "peaks": np.exp(0.4 * x),
        "worn": -np.exp(-0.4 * x), "even": np.tanh(0.5 * x),
    }[kind]  # fmt: skip
    rough, yielded = [], []
    for seed in (51, 52, 53):
        space = HalfSpace(seed)
        z, p = shaped(space, form), np.full((POINTS, POINTS), 1e-3)
        assert (z**4).mean() / z.var() ** 2 == pytest.approx(kurtosis, rel=0.1)
        faces = {h: replace(law_of(space, h), heights=z) for h in (0.2, math.inf)}
        for share in (0.02, 0.06, 0.15):
            p = space.pressed(float(np.quantile(z, 1.0 - share)), p, math.inf, z)
            own = space.stiffness(p > 0.0) * MODULUS / SIDE
            rough.append(miss_of(faces[math.inf], MODULUS * float(p.mean()), own))
        p = space.pressed(float(np.quantile(z, 0.94)), p, 0.2, z)
        stiff = space.stiffness(p > 0.0) * MODULUS / SIDE
        yielded.append(miss_of(faces[0.2], MODULUS * float(p.mean()), stiff))
    # The law of a drawing, elastic and tightened: heights take off its elastic part alone.
    assert abs(np.mean(rough)) < 0.15
    assert np.abs(rough).max() < 0.4
    assert np.abs(yielded).max() < 0.35


def test_the_law_is_that_of_its_stiffness() -> None:
    """N' is the stiffness that was asked for, N is convex, the area scales, bands multiply."""
    body = ms.Material(210e9, 0.3, hardness=1.7e9)
    pair = ms.MaterialPair(body, body)
    law = ms.RoughSurface(pair, 1e-6, 2.5e-4, 1e-5, 2e-4, tightening_load=5e3)
    loads = np.geomspace(1.0, 4.9e3, 40)
    d = law.separation(loads)
    np.testing.assert_allclose(law.load(d), loads, rtol=1e-12)
    np.testing.assert_allclose(law.stiffness(d), law._stiffness_under(loads), rtol=2e-3)
    assert (np.diff(law.stiffness(d)) > 0.0).all()
    half = law._patch(1e-4, 0.5)
    np.testing.assert_allclose(half.stiffness(half.separation(0.5 * loads)),
                               0.5 * law.stiffness(d), rtol=1e-9)  # fmt: skip
    factor = ms.RoughSurface(pair, 1e-6, 2.5e-4, 1e-5, 2e-4, tightening_load=5e3,
                             stiffness_factor=1.2)  # fmt: skip
    at = factor.separation(3e3)
    assert factor.stiffness(at) == pytest.approx(1.2 * law.stiffness(law.separation(3e3)), 1e-6)
    # The limits: elastic where nothing yields, <q> and h' of a narrow band of waves.
    soft = ms.RoughSurface(ms.MaterialPair(ms.Material(210e9, 0.3), body), 1e-6, 2.5e-4, 1e-5, 2e-4)
    assert soft.hardness == 1.7e9, "of one body it is known"
    narrow = ms.RoughSurface(pair, 1e-6, 1e-4, 0.89e-4, 2e-4)
    q = 2.0 * math.pi / 0.945e-4
    assert narrow.mean_wavenumber == pytest.approx(q, rel=5e-3)
    assert narrow.rms_slope == pytest.approx(q * 1e-6, rel=5e-3)
    by_slope = ms.RoughSurface.from_slope(
        pair, rms=1e-6, slope=law.rms_slope / math.sqrt(2.0), roll_off=2.5e-4, area=2e-4
    )
    assert by_slope.shortest == pytest.approx(1e-5, rel=1e-9)


def test_a_joint_is_tightened_by_its_own_load() -> None:
    """Without a tightening load the largest is its own; heavier ones yield again."""
    body = ms.Material(210e9, 0.3, hardness=1.7e9)
    law = ms.RoughSurface(ms.MaterialPair(body, body), 1e-6, 2.5e-4, 1e-5, 2e-4)
    joint = ms.Interface(law, 0.2, normal_load=1e4)
    assert joint.surface.tightening_load == 1e4
    loose = joint.at(normal_load=5e3)
    assert loose.surface.tightening_load == 1e4, "what was pressed flat stays so"
    assert loose.tangential_stiffness > ms.Interface(law, 0.2, normal_load=5e3).tangential_stiffness
    again = joint.at(normal_load=2e4)
    assert (
        again.tangential_stiffness == ms.Interface(law, 0.2, normal_load=2e4).tangential_stiffness
    )
    summits = ms.GreenwoodWilliamson(law.pair, ms.Gaussian(5e-7), 5e-4, 2e8, 4e-4)
    once = ms.Interface(summits.tightened(5e3, hardness=1.7e9), 0.2, normal_load=8e3)
    assert once.surface.tightening_load == 8e3
    twice = summits.tightened(5e3, hardness=1.7e9).tightened(8e3).tightened(2e3)
    assert twice.tightening_load == 8e3
    assert (
        once.tangential_stiffness == ms.Interface(twice, 0.2, normal_load=8e3).tangential_stiffness
    )


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"shortest": 1e-3}, "shortest must be below 0.9 of the roll_off"),
        ({"hurst": 1.2}, "hurst must be in (0, 1]"),
        ({"tightening_load": -1.0}, "tightening_load must be above zero"),
        ({"tightening_load": 1e9}, "tightening_load must be at most 204000 N, 0.6 of the hardness"),
    ],
)
def test_what_is_refused(changes: dict[str, float], says: str) -> None:
    body = ms.Material(210e9, 0.3, hardness=1.7e9)
    numbers = {"rms": 1e-6, "roll_off": 2.5e-4, "shortest": 1e-5, "area": 2e-4, **changes}
    with pytest.raises(ms.InputError) as caught:
        ms.RoughSurface(ms.MaterialPair(body, body), **numbers)
    assert says in str(caught.value).replace("`", "")
