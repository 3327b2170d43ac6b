"""The command on a terminal: colours, widths, progress, signals."""

from __future__ import annotations

import os
import re
import selectors
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command import STUDY, names, process

from microslip.cli.options import stoppable


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("joint.toml").write_text(STUDY, encoding="utf-8")


def on_a_terminal(*arguments: str, columns: int = 80, **environment: str) -> tuple[str, str]:
    """What a terminal of that width gets on standard output, and what on standard error."""
    pty = pytest.importorskip("pty")
    masters, slaves = zip(*(pty.openpty() for _ in range(2)), strict=True)
    env = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR", "COLUMNS")}
    env |= {"TERM": "xterm-256color", "PYTHONIOENCODING": "utf-8", **environment}
    for slave in slaves:
        import fcntl
        import struct
        import termios

        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    child = subprocess.Popen(
        [sys.executable, "-m", "microslip.cli", *arguments],
        stdin=slaves[0], stdout=slaves[0], stderr=slaves[1], env=env,
    )  # fmt: skip
    for slave in slaves:
        os.close(slave)
    texts = [b"", b""]
    with selectors.DefaultSelector() as selector:
        for index, master in enumerate(masters):
            selector.register(master, selectors.EVENT_READ, index)
        while selector.get_map():
            for key, _ in selector.select():
                try:
                    piece = os.read(key.fd, 65536)
                except OSError:  # the end, to Linux
                    piece = b""
                if piece:
                    texts[key.data] += piece
                else:
                    selector.unregister(key.fd)
                    os.close(key.fd)
    assert child.wait() == 0, texts
    out, err = (text.decode("utf-8").replace("\r\n", "\n") for text in texts)
    return out, err


def plain(text: str) -> str:
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", text)


@pytest.mark.slow
def test_a_terminal_gets_colours_unless_it_wants_none() -> None:
    assert "\x1b[36m" in on_a_terminal("check", "joint.toml")[0]
    for wish in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        assert "\x1b" not in on_a_terminal("check", "joint.toml", **wish)[0]
    assert "\x1b[36m" in process("check", "joint.toml", FORCE_COLOR="1").stdout.decode()
    both = process("check", "joint.toml", FORCE_COLOR="1", NO_COLOR="1")
    assert b"\x1b" not in both.stdout


@pytest.mark.parametrize(("command", "columns"), [("predict", 80), ("check", 40)])
def test_nothing_is_cut_on_a_narrow_terminal(command: str, columns: int) -> None:
    text = plain(on_a_terminal(command, "joint.toml", columns=columns, NO_COLOR="1")[0])
    for line in text.splitlines():
        assert len(line) <= columns or " predict " in line or line.startswith("  ok"), line
    for number in ("5700", "2.79 %", "5.70 GN/m", "1.10 kN", "343 nm", "0.568"):
        assert re.search(rf"(?m)^2 kN\b.* {re.escape(number)}(  |$)", text), number
    if command == "predict":
        for number in ("0.421", "13.6 µJ", "0.0934", "0.0467"):
            assert re.search(rf"(?m)^2 kN +100 nm\b.* {re.escape(number)}(  |$)", text), number
    assert "…" not in text


@pytest.mark.skipif(os.name == "nt", reason="other signals there")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_signals_leave_no_trace(number: signal.Signals) -> None:
    if signal.getsignal(number) is signal.SIG_IGN:
        pytest.skip(f"{number.name} is ignored here, as it is under nohup, and then by the command")
    child = subprocess.Popen(
        [sys.executable, "-m", "microslip.cli", "predict", "joint.toml", "-o", "out",
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
