"""The command on a terminal: colours, widths, progress, signals."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command import STUDY, names

from microslip.cli.options import stoppable


@pytest.fixture(autouse=True)
def _a_study(here: Path) -> None:
    Path("joint.toml").write_text(STUDY, encoding="utf-8")


@pytest.mark.skipif(os.name == "nt", reason="other signals there")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_signals_leave_no_trace(number: signal.Signals) -> None:
    if signal.getsignal(number) is signal.SIG_IGN:
        pytest.skip(f"{number.name} is ignored here, as it is under nohup, and then by the command")
    child = subprocess.Popen(
        [sys.executable, "-m", "microslip", "predict", "joint.toml", "-o", "out",
         "--set", "output.report=true"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    deadline = time.monotonic() + 60.0
    while not any(name.startswith(".microslip-") for name in names()):
        assert child.poll() is None, "it ended before it wrote"
        assert time.monotonic() < deadline
        time.sleep(0.005)
    child.send_signal(number)
    _, said = child.communicate()
    assert child.returncode == 128 + number
    assert said.strip() == ("error: interrupted" if number == signal.SIGINT else "")
    assert names() == ["joint.toml"]


@pytest.mark.skipif(os.name == "nt", reason="there is no nohup")
def test_what_is_to_be_ignored_stays_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stoppable():
            os.kill(os.getpid(), signal.SIGHUP)
            assert signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)
