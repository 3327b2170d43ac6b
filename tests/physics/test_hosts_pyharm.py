"""The elements in pyHarm, against its own Jenkins and the library's own solvers; `make hosts`."""

from __future__ import annotations

import numpy as np
import pytest
from exported import JOINT

import microslip as ms

pytest.importorskip("pyHarm", reason="pyHarm is not installed; make hosts runs this")
pytestmark = pytest.mark.filterwarnings("ignore")  # NumPy's and Numba's, of pyHarm's own code


@pytest.fixture(autouse=True)
def own_folder(tmp_path, monkeypatch):
    """pyHarm writes which extensions it knows into the current folder."""
    monkeypatch.chdir(tmp_path)


M = np.diag([10.0, 5.0])
K = np.array([[3e9, -2e9], [-2e9, 2.5e9]])
C = np.diag([2e3, 1e3])
DRIVE = 300.0


def maestro(analysis, nh, connectors, *, adim=None, nti=256, matrices=None, ndofs=1):
    """A model of pyHarm: two masses, or those that are given."""
    from pyHarm.Maestro import Maestro

    from microslip.export.hosts import pyharm

    mass, stiffness, damping = matrices or (M, K, C)
    system = {"type": "Base", "nh": nh, "nti": nti}
    if adim:
        system["adim"] = {"status": True, "lc": adim[0], "wc": adim[1]}
    matrix = {"M": mass, "K": stiffness, "C": damping}
    return Maestro(
        {
            "analysis": analysis,
            "plugin": pyharm.elements(),
            "system": system,
            "substructures": {
                "beam": {"matrix": matrix, "ndofs": ndofs, "nnodes": len(mass) // ndofs}
            },
            "connectors": connectors,
        }
    )


def joint_connector(node=1):
    return {"type": "microslip_joint", "connect": {"beam": [node]}, "dirs": [0], "law": JOINT}


def force_connector(node=0):
    return {"type": "CosinusForcing", "connect": {"beam": [node]}, "dirs": [0], "amp": DRIVE}


def element_of(model, name="joint"):
    return next(element for element in model.system.LE if element.name == name)


def test_pyharm_finds_the_elements_by_their_entry_point():
    from pyHarm import extension, extension_manager
    from pyHarm.Elements.FactoryElements import ElementDictionary

    names = [entry.name for entry in extension_manager._entry_points()]
    assert "microslip" in names
    extension.load("microslip")
    assert {"microslip_joint", "microslip_planar_joint", "microslip_contact"} <= set(
        ElementDictionary
    )


@pytest.mark.parametrize("adim", [None, (1e-7, 1e4)])
def test_forces_and_derivatives_are_the_laws(adim):
    model = maestro({}, [0, 1, 3], {"joint": joint_connector()}, adim=adim)
    element = element_of(model)
    length = adim[0] if adim else 1.0
    c = np.array([1e-8, 3e-7, -5e-8, 4e-8, 2e-8])
    x = np.zeros(2 * c.size + 1)
    x[element.indices] = c / length
    force, jacobian = JOINT.harmonics(c, [0, 1, 3])
    np.testing.assert_allclose(element.evalResidual(x, 1.0), force, rtol=1e-13)
    J, dJdom = element.evalJacobian(x, 1.0)
    np.testing.assert_allclose(J, jacobian * length, rtol=1e-12, atol=1e-12 * np.abs(J).max())
    assert not dJdom.any()


def three_dof_element(kind, law, nti=64):
    """An element between the ground and a node of three directions, in lengths of 0.1 um."""
    directions = 2 if kind == "planar_joint" else 3
    connector = {
        "type": f"microslip_{kind}", "connect": {"beam": [0], "GROUND": [0]},
        "dirs": list(range(directions)), "law": law, "sliders": 32,
    }  # fmt: skip
    matrices = (np.eye(3), np.eye(3), np.zeros((3, 3)))
    options = {"matrices": matrices, "ndofs": 3, "nti": nti, "adim": (1e-7, 1.0)}
    return element_of(maestro({}, 1, {"joint": connector}, **options))


def test_two_directions_are_those_of_the_law():
    law = ms.IsotropicJoint(JOINT, sliders=24)
    element = three_dof_element("planar_joint", law)
    x = np.append(np.random.default_rng(1).normal(size=9), 0.0)
    force, jacobian = law.harmonics(1e-7 * x[:9].reshape(3, 3)[:, :2].T, [0, 1], samples=64)
    wanted, slopes = np.zeros((3, 3)), np.zeros((3, 3, 3, 3))  # by coefficient, then direction
    wanted[:, :2] = force.T
    slopes[:, :2, :, :2] = 1e-7 * jacobian.transpose(2, 0, 3, 1)
    np.testing.assert_allclose(element.evalResidual(x, 1.0), wanted.ravel(), rtol=1e-12)
    J = element.evalJacobian(x, 1.0)[0]
    np.testing.assert_allclose(J, slopes.reshape(9, 9), rtol=0.0, atol=1e-12 * np.abs(J).max())


def test_a_contact_pushes_apart_and_has_the_derivatives_of_its_forces():
    element = three_dof_element("contact", JOINT)
    scale = JOINT.normal_load
    assert np.abs(element.evalResidual(np.zeros(10), 1.0)).max() < 1e-12 * scale
    x = np.zeros(10)
    x[0] = -1.0  # a tenth of a micrometre nearer
    pushed = element.evalResidual(x, 1.0)[0]
    wanted = JOINT.normal_load - JOINT.surface.load(JOINT.separation - 1e-7)
    assert pushed == pytest.approx(wanted, rel=1e-9)
    # A line in one tangential direction while it breathes: the force is that of the coupled law.
    x = np.array([0.2, 0.0, 0.0, 0.3, 2.0, 0.0, -0.2, 0.5, 0.0, 0.0])
    motion = 1e-7 * x[:9].reshape(3, 3).T  # direction, coefficient
    t = 2.0 * np.pi * np.arange(64) / 64
    basis = np.column_stack((np.ones(64), np.cos(t), np.sin(t)))
    cycle = JOINT.periodic(basis @ motion[1], separation=JOINT.separation + basis @ motion[0])
    exact = 2.0 / 64 * basis.T @ cycle.force
    exact[0] *= 0.5
    found = element.evalResidual(x, 1.0).reshape(3, 3)
    # 32 sliders draw the load curve as a polygon.
    np.testing.assert_allclose(found[:, 1], exact, rtol=0.0, atol=0.02 * JOINT.force_limit)
    J, step = element.evalJacobian(x, 1.0)[0], 1e-3
    # Across the line sliders settle too slowly for differences of settled cycles.
    for k in (0, 1, 3, 4, 6, 7):
        ends = [element.evalResidual(x + sign * step * np.eye(10)[k], 1.0) for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(J[:, k], slope, rtol=0.0, atol=3e-3 * np.abs(J).max())


@pytest.mark.parametrize("dirs", [[2, 0], [2, 0, 1]])
def test_a_field_between_two_parts_is_its_pairs_of_nodes(dirs):
    """Three pairs in one element, numbered otherwise on the other side."""
    loads, count = [400.0, 900.0, 0.0], len(dirs)
    field = ms.JointField(JOINT.surface, 0.4, areas=np.full(3, 1e-4), loads=loads)
    parts = {
        name: {"matrix": {k: np.eye(9) for k in "MKC"}, "ndofs": 3, "nnodes": 3} for name in "ab"
    }
    from pyHarm.Maestro import Maestro

    from microslip.export.hosts import pyharm

    connector = {
        "type": "microslip_contact", "connect": {"a": [0, 1, 2], "b": [2, 0, 1]}, "dirs": dirs,
        "law": field, "sliders": 40,
    }  # fmt: skip
    system = {"type": "Base", "nh": [0, 1, 3], "nti": 64}
    model = Maestro({
        "analysis": {}, "plugin": pyharm.elements(), "system": system, "substructures": parts,
        "connectors": {"joint": connector},
    })  # fmt: skip
    element, table = element_of(model), model.system.expl_dofs

    def edof(sub, node):
        """Indices (direction, coefficient) of a node."""
        its = table[(table["sub"] == sub) & (table["node_num"] == node)]
        its = its.sort_values(["dof_num", "harm", "cs"])
        return np.array(its.index).reshape(3, 5)

    x = np.zeros(2 * 9 * 5 + 1)
    x[:-1] = 1e-7 * np.random.default_rng(8).normal(size=90)
    moved = np.zeros((3, 3, 5))  # pair, direction, coefficient
    for i, (a, b) in enumerate(zip([0, 1, 2], [2, 0, 1], strict=True)):
        moved[i] = x[edof("a", a)] - x[edof("b", b)]
    opened = moved[:, 2].copy()
    opened[:, 0] += field.separations
    if count == 2:
        force, load, _ = field.harmonics(moved[:, 0], [0, 1, 3], separations=opened)
        tangential = force[:, None]
    else:
        tangential, load, _ = field.two_directions(40).harmonics(
            moved[:, :2], [0, 1, 3], separations=opened, samples=64
        )
    load[:, 0] -= loads
    whole = np.zeros_like(x)
    for i, (a, b) in enumerate(zip([0, 1, 2], [2, 0, 1], strict=True)):
        for node, sign in ((("a", a), 1.0), (("b", b), -1.0)):
            places = edof(*node)
            whole[places[: count - 1]] += sign * tangential[i]
            whole[places[2]] -= sign * load[i]
    found = element.evalResidual(x, 1.0)
    np.testing.assert_allclose(found, whole[element.indices], rtol=0.0, atol=1e-9 * 900.0)
    J, way = element.evalJacobian(x, 1.0)[0], 1e-11 * np.random.default_rng(9).normal(size=90)
    step = np.append(way, 0.0)
    ends = [element.evalResidual(x + sign * step, 1.0) for sign in (1, -1)]
    slope = 0.5 * (ends[0] - ends[1])
    np.testing.assert_allclose(
        J @ step[element.indices], slope, rtol=0.0, atol=2e-3 * np.abs(slope).max()
    )
    wrong = {**connector, "connect": {"a": [0, 1], "b": [2, 0]}}
    with pytest.raises(ms.InputError, match="connect must list 3 node"):
        Maestro({
            "analysis": {}, "plugin": pyharm.elements(), "system": system, "substructures": parts,
            "connectors": {"joint": wrong},
        })  # fmt: skip


def test_the_forced_response_is_that_of_structure_and_of_time_integration():
    stuck = np.linalg.eigvalsh(
        np.diag(np.diag(M) ** -0.5)
        @ (K + np.diag([0.0, JOINT.tangential_stiffness]))
        @ np.diag(np.diag(M) ** -0.5)
    )
    omega = float(np.sqrt(stuck[0]))
    analysis = {
        "frf": {
            "study": "frf", "puls_inf": 0.85 * omega, "puls_sup": 1.02 * omega,
            "ds0": 0.2, "ds_max": 2.0, "ds_min": 1e-8, "verbose": False,
        }
    }  # fmt: skip
    connectors = {"joint": joint_connector(), "force": force_connector()}
    model = maestro(analysis, [0, 1, 3], connectors, adim=(1e-7, omega))
    model.operate()
    found = [point for point in model.nls["frf"].SolList if point.flag_accepted]
    assert len(found) > 10
    frequency = np.array([point.x[-1] for point in found]) * omega / (2.0 * np.pi)
    motion = np.array([1e-7 * np.hypot(point.x[2:4], point.x[4:6]) for point in found])
    assert motion[:, 1].max() > 1.5e-7  # well into slip
    structure = ms.Structure(M, K, C).attach(JOINT, directions=[0.0, 1.0])
    assert np.all(np.diff(frequency) > 0.0)  # softening, but no fold here
    keep = np.linspace(0, len(found) - 1, 8).astype(int)
    own = structure.forced_response([DRIVE, 0.0], frequency[keep], harmonics=[0, 1, 3])
    fundamental = np.abs(own.displacement[own.requested][:, :, 1])
    # What both solvers leave of their equations.
    np.testing.assert_allclose(motion[keep], fundamental, rtol=1e-6)
    peak = int(np.argmax(motion[:, 0]))
    f, steps, periods = frequency[peak], 512, 60
    t = np.arange(periods * steps + 1) / (steps * f)
    drive = np.column_stack((DRIVE * np.cos(2.0 * np.pi * f * t), np.zeros_like(t)))
    last = structure.integrate(drive, t).displacement[-steps:]
    spectrum = 2.0 / steps * np.abs(last.T @ np.exp(-2j * np.pi * np.arange(steps) / steps))
    # Newmark's rule at 512 steps, harmonics above the third, and what is left of the start.
    np.testing.assert_allclose(motion[peak], spectrum, rtol=5e-3)


def marched(push, pulsation, pull, damping, steps=600, periods=40):
    """Mean and fundamental (cos, sin) of 10 kg on springs and a joint, by central differences."""
    dt = 2.0 * np.pi / pulsation / steps
    phase = pulsation * dt * np.arange(steps * periods)
    force = sum(
        amplitude * np.outer((np.cos if kind == "Cosinus" else np.sin)(phase), np.eye(3)[place])
        for kind, place, amplitude in push
    )
    x, before, path = np.zeros(3), np.zeros(3), np.empty_like(force)
    for i in range(len(phase)):
        path[i] = x
        rest = force[i] - 5e8 * x - pull(x)
        after = dt * dt * rest + 20.0 * x - 10.0 * before + 0.5 * dt * damping * before
        x, before = after / (10.0 + 0.5 * dt * damping), x
    last, phase = path[-steps:], phase[-steps:]
    both = [2.0 / steps * wave(phase) @ last for wave in (np.cos, np.sin)]
    return last.mean(axis=0), np.array(both)


@pytest.mark.parametrize("kind", ["planar_joint", "contact"])
def test_ellipses_with_and_without_a_breathing_load_are_those_of_time_integration(kind):
    """An analysis with each element of several directions, at its peak against own small steps."""
    stuck = np.sqrt((5e8 + JOINT.tangential_stiffness) / 10.0)
    damping = np.array([4e4, 1e4, 1e4])
    push = [("Cosinus", 1, 100.0), ("Sinus", 2, 60.0)]
    if kind == "contact":
        law, directions = JOINT, [0, 1, 2]
        push.append(("Cosinus", 0, 100.0))
        state = (
            ms.JointField(JOINT.surface, JOINT.friction_coefficient, areas=[1.0],
                          separations=[JOINT.separation], surface_area=1.0)
            .two_directions(24).start()
        )  # fmt: skip

        def pull(x):
            trial = state.try_([x[1:]], separations=[JOINT.separation + x[0]])
            state.commit()
            normal = JOINT.normal_load - np.ravel(trial.load)[0]
            return np.append(normal, np.ravel(trial.force))
    else:
        law, directions = ms.IsotropicJoint(JOINT, sliders=24), [1, 2]
        state = law.start()

        def pull(x):
            force = state.try_(x[1:])[0]
            state.commit()
            return np.append(0.0, force)

    connectors = {
        f"push {i}": {
            "type": f"{name}Forcing", "connect": {"beam": [0]}, "dirs": [place], "amp": amplitude,
        }
        for i, (name, place, amplitude) in enumerate(push)
    }  # fmt: skip
    connectors["joint"] = {
        "type": f"microslip_{kind}", "connect": {"beam": [0], "GROUND": [0]}, "dirs": directions,
        "law": law, "sliders": 24,
    }  # fmt: skip
    analysis = {
        "study": "frf", "puls_inf": 0.8 * stuck, "puls_sup": stuck, "ds0": 0.1, "ds_max": 0.5,
        "ds_min": 1e-8, "verbose": False,
    }  # fmt: skip
    matrices = (10.0 * np.eye(3), 5e8 * np.eye(3), np.diag(damping))
    model = maestro(
        {"frf": analysis}, [0, 1, 3], connectors, adim=(1e-7, stuck), matrices=matrices, ndofs=3
    )
    model.operate()
    found = [point for point in model.nls["frf"].SolList if point.flag_accepted]
    motion = np.array([1e-7 * point.x[:-1].reshape(-1, 3) for point in found])
    size = np.hypot(motion[:, 1, 1], motion[:, 2, 1])
    peak = int(np.argmax(size))
    assert size[peak] > 1e-7, "well into slip"
    mean, fundamental = marched(push, found[peak].x[-1] * stuck, pull, damping)
    # Harmonics above the third; with the load that breathes its samples and sliders, too.
    share = 1e-2 if kind == "contact" else 1e-3
    np.testing.assert_allclose(motion[peak, 1:3], fundamental, rtol=0.0, atol=share * size[peak])
    np.testing.assert_allclose(motion[peak, 0], mean, rtol=0.0, atol=share * size[peak])


def nonlinear_mode():
    """Frequencies [Hz] of a mode over amplitudes of slip, by pyHarm and by `Structure`."""
    mass, stiffness = np.array([[10.0]]), np.array([[1e9]])
    omega = float(np.sqrt((1e9 + JOINT.tangential_stiffness) / 10.0))
    analysis = {
        "mode": {
            "study": "nlm_backbone", "amp_min": 1.0, "amp_max": 400.0, "df0": 5.0, "df_min": 1e-4,
            "df_max": 40.0, "max_steps": 25, "verbose": False,
        }
    }  # fmt: skip
    model = maestro(
        analysis, [0, 1], {"joint": joint_connector(node=0)},
        matrices=(mass, stiffness, np.zeros((1, 1))), adim=(1e-7, omega),
    )  # fmt: skip
    model.operate()
    found = [point for point in model.nls["mode"].SolList if point.flag_accepted]
    amplitude = np.array([1e-7 * np.hypot(*point.x[1:3]) for point in found])
    frequency = np.array([point.x[-1] for point in found]) * omega / (2.0 * np.pi)
    slipping = amplitude > 5e-9
    assert slipping.sum() >= 5
    own = ms.Structure(mass, stiffness).attach(JOINT, directions=[1.0])
    curve = own.modes(
        0, np.sort(amplitude[slipping]) * np.sqrt(10.0), harmonics=[0, 1], method="harmonic-balance"
    )
    return frequency[slipping][np.argsort(amplitude[slipping])], curve.frequency


def test_its_nonlinear_mode_is_that_of_structure():
    found, wanted = nonlinear_mode()
    # Of one mass and one harmonic, resonance of phase and the mode are one.
    np.testing.assert_allclose(found, wanted, rtol=1e-7)
    assert wanted[-1] < 0.7 * wanted[0]


def test_what_is_no_law_for_an_element_is_refused():
    for change, says in (
        ({"law": 3.0}, "law must be a backbone law"),
        ({"dirs": [0, 1]}, "dirs must be 1 direction"),
        ({"type": "microslip_planar_joint"}, "dirs must be 2 direction"),
    ):
        with pytest.raises(ms.InputError, match=says):
            maestro({}, 1, {"joint": {**joint_connector(), **change}})
