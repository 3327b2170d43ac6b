"""The functional mock-up unit, validated and run by FMPy; `tools/try_hosts.sh` installs it."""

import ctypes
import subprocess
from pathlib import Path

import numpy as np
import pytest
from exported import COMPILER, JOINT, STRICT, needs_compiler, records

from microslip import export

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed; make hosts runs this")
pytestmark = needs_compiler


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """The archive, what it says of itself, and its unpacked folder."""
    file = tmp_path_factory.mktemp("fmu") / "joint.fmu"
    export.write("fmu", JOINT, file, depth=64)
    return str(file), fmpy.read_model_description(str(file)), fmpy.extract(str(file))


def made(unit, kind):
    """An instance that has been initialised at rest."""
    _, description, folder = unit
    slave = kind(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier="joint",
        instanceName="one",
    )
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    return slave


def test_it_is_valid(unit):
    from fmpy.validation import validate_fmu

    assert list(validate_fmu(unit[0])) == []
    assert unit[1].modelExchange.providesDirectionalDerivative
    assert unit[1].coSimulation.canSerializeFMUstate


def test_its_sources_make_the_same_unit(unit, tmp_path):
    from fmpy.fmi2 import FMU2Slave

    _, description, folder = unit
    (tmp_path / "binaries" / "linux64").mkdir(parents=True)
    library = tmp_path / "binaries" / "linux64" / "joint.so"
    source = Path(folder) / "sources" / "joint.c"
    command = [str(COMPILER), *STRICT, "-shared", "-fPIC", "-o", str(library), str(source), "-lm"]
    subprocess.run(command, check=True, capture_output=True)
    slave = made((None, description, str(tmp_path)), FMU2Slave)
    slave.setReal([0], [2e-7])
    assert slave.getReal([1]) == pytest.approx([JOINT.force([2e-7])[0]], rel=1e-13)
    slave.freeInstance()


def test_co_simulation_follows_the_law_one_input_behind(unit):
    from fmpy.fmi2 import FMU2Slave

    slave = made(unit, FMU2Slave)
    for x in records(3e-7, 400).values():
        slave.reset()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        wanted, forces, ahead = JOINT.force(x), [], []
        for i, place in enumerate(x):
            slave.setReal([0], [place])
            ahead += slave.getReal([1])  # a trial at the input that has just come
            slave.doStep(currentCommunicationPoint=0.1 * i, communicationStepSize=0.1)
            forces += slave.getReal([1])
        # At the end of the step the force is that of the input at its beginning.
        np.testing.assert_allclose(forces, wanted, rtol=0.0, atol=1e-13 * np.abs(wanted).max())
        np.testing.assert_array_equal(ahead, forces)
    slave.terminate()
    slave.freeInstance()


def test_model_exchange_commits_completed_steps_alone(unit):
    from fmpy.fmi2 import FMU2Model

    model = made(unit, FMU2Model)
    model.enterContinuousTimeMode()
    x = records(3e-7, 300)["walk"]
    forces = []
    for place in x:
        for trial in (3.0 * place, -place):  # an iteration that goes astray
            model.setReal([0], [trial])
            model.getReal([1])
        model.setReal([0], [place])
        model.completedIntegratorStep()
        forces += model.getReal([1])
    wanted = JOINT.force(x)
    np.testing.assert_allclose(forces, wanted, rtol=0.0, atol=1e-13 * np.abs(wanted).max())
    model.terminate()
    model.freeInstance()


def test_an_importer_simulates_it(unit):
    t = np.arange(0, 2001) / 2000
    x = 1e-6 * np.sin(2.0 * np.pi * 3.0 * t)
    given = np.rec.array((t, x), names=["time", "displacement"])
    for kind, lag in (("ModelExchange", 0), ("CoSimulation", 1)):
        answer = fmpy.simulate_fmu(
            unit[0],
            fmi_type=kind,
            solver="Euler",
            step_size=5e-4,
            output_interval=5e-4,
            stop_time=1.0,
            input=np.asarray(given),
            output=["force"],
        )
        wanted = JOINT.force(np.append(np.zeros(lag), x[: x.size - lag]))
        found = np.interp(t, answer["time"], answer["force"])
        assert np.abs(found - wanted).max() <= 1e-9 * JOINT.force_limit, kind


def test_state_can_be_kept_serialised_and_differentiated(unit):
    from fmpy.fmi2 import FMU2Slave

    slave = made(unit, FMU2Slave)
    for i, place in enumerate((3e-7, -1e-7, 2e-7)):
        slave.setReal([0], [place])
        slave.doStep(currentCommunicationPoint=0.1 * i, communicationStepSize=0.1)
    kept = slave.getFMUState()
    numbers = slave.serializeFMUState(kept)
    slave.setReal([0], [-9e-7])
    slave.doStep(currentCommunicationPoint=0.3, communicationStepSize=0.1)
    again = slave.deserializeFMUState(numbers)
    for state in (kept, again):
        slave.setFMUState(state)
        slave.setReal([0], [1e-8])
        found = slave.getReal([1, 2])
        trial = JOINT.start()
        trial.advance([3e-7, -1e-7, 2e-7])
        assert found == pytest.approx([*trial.try_(1e-8)], rel=1e-9)
        assert slave.getDirectionalDerivative([1], [0], [2.0])[0] == 2.0 * found[1]
    broken = bytearray(numbers)
    broken[40:48] = bytes(ctypes.c_double(1e9))  # a depth that no state has
    with pytest.raises(Exception, match=r"(?i)deserialize"):
        slave.deserializeFMUState(bytes(broken))
    slave.freeFMUState(kept)
    slave.freeFMUState(again)
    slave.terminate()
    slave.freeInstance()


def test_zig_makes_it_for_other_machines(unit):
    pytest.importorskip("ziglang", reason="ziglang is not installed; make hosts runs this")
    folder = Path(unit[2]) / "binaries"
    begins = {
        path.parent.name: path.read_bytes()[:4]
        for path in folder.glob("*/joint.*")
        if path.is_file()
    }
    assert begins["linux64"] == b"\x7fELF"
    assert begins["win64"][:2] == b"MZ"
    assert begins["darwin64"] == b"\xcf\xfa\xed\xfe"


def third(tmp_path, kind, element="joint", size=3, **options):
    """An array of joints as FMI 3, valid, initialised at rest."""
    from fmpy.validation import validate_fmu

    file = tmp_path / "joint.fmu"
    export.write("fmu3", JOINT, file, element=element, size=size, depth=64, **options)
    assert list(validate_fmu(str(file))) == []
    description = fmpy.read_model_description(str(file))
    unit = kind(
        guid=description.guid,
        unzipDirectory=fmpy.extract(str(file)),
        modelIdentifier="joint",
        instanceName="three",
    )
    unit.instantiate()
    unit.enterInitializationMode()
    unit.exitInitializationMode()
    return unit


def test_fmi_3_has_an_array_of_joints_with_stiffness(tmp_path):
    from fmpy.fmi3 import FMU3Model

    model = third(tmp_path, FMU3Model)
    model.enterContinuousTimeMode()
    x = np.array([records(3e-7, 200, seed)["noise"] for seed in range(3)]).T
    states = [JOINT.start() for _ in range(3)]
    for row in x:
        model.setFloat64([1], [3.0 * value for value in row])  # an iteration that goes astray
        model.getFloat64([2], 3)
        model.setFloat64([1], row.tolist())
        wanted = np.array([state.try_(value) for state, value in zip(states, row, strict=True)])
        found = np.array(model.getFloat64([2, 3], 6)).reshape(2, 3).T
        np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-12 * JOINT.force_limit)
        force, place = (ctypes.c_uint32 * 1)(2), (ctypes.c_uint32 * 1)(1)
        seed, slope = (ctypes.c_double * 3)(1.0, 2.0, -1.0), (ctypes.c_double * 3)()
        for name in ("fmi3GetDirectionalDerivative", "fmi3GetAdjointDerivative"):
            # FMPy's own wrapper takes one number a variable.
            getattr(model, name)(model.component, force, 1, place, 1, seed, 3, slope, 3)
            np.testing.assert_allclose(slope, found[:, 1] * seed, rtol=1e-14)
        model.completedIntegratorStep()
        for state in states:
            state.commit()
    lost = [state.dissipated_energy for state in states]
    np.testing.assert_allclose(model.getFloat64([4], 3), lost, rtol=1e-10)
    stored = [state.stored_energy for state in states]
    np.testing.assert_allclose(model.getFloat64([5], 3), stored, rtol=1e-9)
    kept = model.getFMUState()
    numbers = model.serializeFMUState(kept)
    before = model.getFloat64([2], 3)
    model.setFloat64([1], [1e-6, -1e-6, 0.0])
    model.completedIntegratorStep()
    again = model.deserializeFMUState(numbers)
    model.setFMUState(again)
    assert model.getFloat64([2], 3) == before
    model.terminate()
    model.freeInstance()


def test_fmi_3_has_contacts_whose_load_varies(tmp_path):
    from fmpy.fmi3 import FMU3Slave

    slave = third(tmp_path, FMU3Slave, element="contact", size=2)
    state, rng = JOINT.start(), np.random.default_rng(1)
    for i in range(100):
        x, opening = 3e-7 * rng.standard_normal(), 5e-8 * rng.standard_normal()
        slave.setFloat64([1], [x, opening, x, 0.0])
        slave.doStep(currentCommunicationPoint=0.1 * i, communicationStepSize=0.1)
        trial = state.try_(x, separation=JOINT.separation + opening)
        state.commit()
        force, load = slave.getFloat64([2], 4)[:2]
        assert force == pytest.approx(trial.force, rel=1e-9, abs=1e-9 * JOINT.force_limit)
        assert load == pytest.approx(trial.normal_load, rel=1e-12)
    slave.terminate()
    slave.freeInstance()


def test_the_sources_of_fmi_3_make_the_same_unit(tmp_path):
    from fmpy.fmi3 import FMU3Model

    options = {"cells": 24, "smallest_amplitude": 3e-7}
    third(tmp_path, FMU3Model, element="planar-contact", **options).freeInstance()
    folder = Path(fmpy.extract(str(tmp_path / "joint.fmu")))
    command = [str(COMPILER), *STRICT, "-shared", "-fPIC", "-o", "again.so", "joint.c", "-lm"]
    done = subprocess.run(command, cwd=folder / "sources", capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
