"""The workbench: who may ask it, what it refuses, and a person's way through it in a browser."""

from __future__ import annotations

import asyncio
import io
import json
import shutil
import socket
import threading
import time
import zipfile
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
import pytest

import microslip as ms
from microslip.app.jobs import Workspace, check_study, safe_name
from microslip.cli import main
from microslip.cli.workbench import COMMANDS, forms

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
TOKEN = "a-token-of-the-tests"
FORMS = forms(main.commands)


class Bench(NamedTuple):
    port: int
    folder: Path

    def ask(
        self, method: str, path: str, body: Any = None, **headers: str | None
    ) -> tuple[int, dict[str, str], bytes]:
        """A request as the page makes it, with other headers where they are given."""
        own: dict[str, str | None] = {
            "Host": f"127.0.0.1:{self.port}",
            "Origin": f"http://127.0.0.1:{self.port}",
            "Cookie": f"microslip={TOKEN}",
        }
        own |= {name.replace("_", "-"): value for name, value in headers.items()}
        data = (
            body if isinstance(body, bytes) else b"" if body is None else json.dumps(body).encode()
        )
        own.setdefault("Content-Length", str(len(data)))
        connection = HTTPConnection("127.0.0.1", self.port, timeout=60)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        for name, value in own.items():
            if value is not None:
                connection.putheader(name, value)
        connection.endheaders(data)
        answer = connection.getresponse()
        found = answer.status, dict(answer.getheaders()), answer.read()
        connection.close()
        return found

    def json(self, method: str, path: str, body: Any = None) -> Any:
        status, _, text = self.ask(method, path, body)
        assert status == 200, text
        return json.loads(text)

    def finished(self, run: str) -> Any:
        for _ in range(600):
            found = self.json("GET", f"/api/runs/{run}")
            if found["state"] not in ("waiting", "running"):
                return found
            time.sleep(0.1)
        raise AssertionError("a run took over a minute")


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    pytest.importorskip("starlette", reason="the extra app is not installed")
    uvicorn = pytest.importorskip("uvicorn", reason="the extra app is not installed")
    from microslip.app.server import build

    listening = socket.socket()
    listening.bind(("127.0.0.1", 0))
    port, folder = listening.getsockname()[1], tmp_path_factory.mktemp("bench")
    server = None

    def serve() -> None:
        nonlocal server

        async def begin() -> None:
            nonlocal server
            app = build(Workspace(folder, FORMS), TOKEN, port)
            server = uvicorn.Server(uvicorn.Config(app, log_level="warning"))
            await server.serve(sockets=[listening])

        asyncio.run(begin())

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    for _ in range(200):
        if server is not None and server.started:
            break
        time.sleep(0.05)
    yield Bench(port, folder)
    server.should_exit = True
    thread.join(20.0)


def record_text(folder: Path) -> bytes:
    rig = ms.VirtualTribometer(ms.Interface.examples()[0], noise=0.003, sample_rate=2560)
    rig.record(amplitude=4e-6, frequency=10.0, cycles=8).to_csv(folder / "run.csv")
    return (folder / "run.csv").read_bytes()


# -- who may ask --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Host": "evil.example"}, 421),
        ({"Host": "127.0.0.1:1"}, 421),
        ({"Origin": "http://evil.example"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": None}, 403),
        ({"Sec_Fetch_Site": "cross-site"}, 403),
        ({"Cookie": None}, 401),
        ({"Cookie": "microslip=guess"}, 401),
        ({"Content_Length": None}, 411),
        ({"Content_Length": None, "Transfer_Encoding": "chunked"}, 411),
        ({"Content_Length": str(2**40)}, 413),
        ({"Content_Length": "1e3"}, 400),
    ],
)
def test_others_are_refused(bench: Bench, headers: dict[str, str | None], status: int) -> None:
    given = {"Content_Length": "0", **headers}
    assert bench.ask("POST", "/api/example", **given)[0] == status


def test_the_address_with_the_token_opens_it(bench: Bench) -> None:
    status, headers, _ = bench.ask("GET", f"/?token={TOKEN}", Cookie=None, Origin=None)
    assert (status, headers["location"]) == (303, "/")
    assert "HttpOnly; SameSite=Strict" in headers["set-cookie"]
    status, headers, page = bench.ask("GET", "/", Origin=None)
    assert status == 200
    assert "script-src 'self'" in headers["content-security-policy"]
    assert b"workbench" in page
    assert bench.ask("GET", "/?token=guess", Cookie=None, Origin=None)[0] == 401


@pytest.mark.parametrize(
    "path",
    ["/runs/x/files/../../run.json", "/app.py", "/..%2f..%2fetc/passwd", "/api/runs/none"],
)
def test_no_path_leads_anywhere(bench: Bench, path: str) -> None:
    assert bench.ask("GET", path)[0] == 404


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ("../../etc/passwd", "passwd"), ("..\\a b.csv", "a_b.csv"), ("--law", "law"),
        (".bashrc", "bashrc"), ("", "file"), ("/", "file"), ("x" * 300 + ".csv", "x" * 76 + ".csv"),
    ],
)  # fmt: skip
def test_names_of_files_are_ours(given: str, name: str) -> None:
    assert safe_name(given) == name


NAMES_A_FILE = '[excitation]\nhistory = { file = "/etc/passwd", column = "x" }\n'


@pytest.mark.parametrize(
    ("key", "text"),
    [
        ("file", NAMES_A_FILE),
        ("scan", '[surface]\nscan = "/etc/passwd"\n'),
        ("scan", '[surface.first]\nscan = ["a.plu", "/etc/passwd"]\n'),
        ("file", '[[a]]\nb = [{ c = { file = "x" } }]\n'),
    ],
)
def test_a_study_names_no_file(key: str, text: str, tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(text)
    with pytest.raises(
        ms.InputError, match=f"{key} refers to a file, which only the command can read"
    ):
        check_study(file)


def test_a_study_that_names_a_file_is_not_run(tmp_path: Path, bench: Bench) -> None:
    file = tmp_path / "study.toml"
    file.write_text(NAMES_A_FILE)
    sent = bench.json("POST", "/api/uploads?name=study.toml", file.read_bytes())
    asked = {"kind": "predict", "uploads": [sent["id"]], "options": {}}
    status, _, text = bench.ask("POST", "/api/runs", asked)
    assert (status, b"refers to a file" in text) == (422, True)


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        ({"kind": "rm", "uploads": ["x"]}, "kind must be one of"),
        ({"kind": [], "uploads": ["x"]}, "kind must be one of"),
        ({"kind": "look record", "uploads": ["x"]}, "kind must be one of"),
        ({"kind": "measure", "uploads": ["x"]}, "an upload is no longer available"),
        ({"kind": "measure", "uploads": []}, "a run must have 1 to 500 files"),
        ([], "must be a JSON object"),
    ],
)
def test_unsupported_requests(bench: Bench, asked: Any, text: str) -> None:
    status, _, answer = bench.ask("POST", "/api/runs", asked)
    assert status == 422
    assert text in json.loads(answer)["error"]


def test_forms_leave_out_nothing_but_where_results_go() -> None:
    for name in COMMANDS:
        offered = {field.name for field in FORMS[name]}
        left_out = {
            param.name
            for param in main.commands[name].params
            if isinstance(param, click.Option)
            and not {text.removeprefix("--") for text in param.opts} & offered
        }
        assert left_out <= {"folder", "overwrite", "as_json", "overrides"}, name
        assert all(field.label and field.help for field in FORMS[name])
    kinds = {field.name: field.kind for name in COMMANDS for field in FORMS[name]}
    # What names a file in the command is a file that was sent.
    assert {name for name, kind in kinds.items() if kind == "study"} == {"study"}
    assert {name for name, kind in kinds.items() if kind == "file"} == {"manifest"}


@pytest.mark.slow
def test_what_a_look_refuses_names_no_folder(bench: Bench, tmp_path: Path) -> None:
    sent = bench.json("POST", "/api/uploads?name=run.csv", record_text(tmp_path))
    for options in ({"time": "clock"}, {"rows": "x"}, {"sample-rate": "-1"}):
        asked = {"what": "record", "options": options}
        status, _, text = bench.ask("POST", f"/api/uploads/{sent['id']}/look", asked)
        assert status == 422
        assert str(bench.folder) not in text.decode()
        assert "rror:" not in text.decode()  # a line for people, no name of an exception


# -- what it does -------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_record_measured(bench: Bench, tmp_path: Path) -> None:
    """Looked at, measured, downloaded with the command that repeats it, removed."""
    sent = bench.json("POST", "/api/uploads?name=run.csv", record_text(tmp_path))
    seen = bench.json("POST", f"/api/uploads/{sent['id']}/look", {"what": "record"})
    assert seen["samples"] == len(seen["displacement"][0])
    assert len(seen["cycles"]) >= 6
    asked = {"kind": "measure", "uploads": [sent["id"]], "options": {"rig-stiffness": "1e12 N/m"}}
    run = bench.finished(bench.json("POST", "/api/runs", asked)["id"])
    assert run["state"] == "done", run
    status, headers, page = bench.ask("GET", f"/runs/{run['id']}/files/report.html")
    assert status == 200
    assert headers["content-security-policy"].startswith("sandbox")
    assert b"dissipates" in page
    _, _, data = bench.ask("GET", f"/runs/{run['id']}/download.zip")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert {"command.txt", "run.csv", "result/summary.json"} <= set(archive.namelist())
        command = archive.read("command.txt").decode()
    assert command.startswith("microslip measure '--rig-stiffness=1e12 N/m' -o result -- run")
    assert bench.json("DELETE", f"/api/runs/{run['id']}") == {}
    assert not (bench.folder / run["id"]).exists()


@pytest.mark.slow
def test_a_scan_measured(bench: Bench) -> None:
    x, y = np.meshgrid(np.arange(80.0), np.arange(60.0))
    file = io.BytesIO()
    np.save(file, 1e-7 * np.sin(0.5 * x) * np.cos(0.4 * y))
    sent = bench.json("POST", "/api/uploads?name=ground.npy", file.getvalue())
    options = {"unit": "m", "pixel": "1 um", "level": "auto"}
    seen = bench.json(
        "POST", f"/api/uploads/{sent['id']}/look", {"what": "scan", "options": options}
    )
    assert seen["picture"].startswith("data:image/png;base64,")
    assert seen["level"] == "plane"
    asked = {"kind": "surface", "uploads": [sent["id"]], "options": {**options, "cutoff": "4 um"}}
    run = bench.finished(bench.json("POST", "/api/runs", asked)["id"])
    assert run["state"] == "done"
    _, _, summary = bench.ask("GET", f"/runs/{run['id']}/files/summary.json")
    assert json.loads(summary)["summits"]["radius"] > 0.0


@pytest.mark.slow
def test_a_manifest_and_its_files(bench: Bench, tmp_path: Path) -> None:
    """All files of a campaign run at once; a manifest opens no file that was not sent."""
    text = record_text(tmp_path)
    sent = [bench.json("POST", f"/api/uploads?name={n}.csv", text)["id"] for n in ("a%20b", "c")]
    sheets = {
        "good.csv": b"file,specimen,load\na b.csv,S1,500 N\nc.csv,S2,600 N\n",
        "other.csv": b"file\na b.csv\nc.csv\nd.csv\n",
        "above.csv": b"file\na b.csv\n../c.csv\n",
        "less.csv": b"file\nc.csv\n",
        "none.csv": b"specimen\nS1\n",
    }
    for name, content in sheets.items():
        manifest = bench.json("POST", f"/api/uploads?name={name}", content)["id"]
        asked = {"kind": "measure", "uploads": sent, "options": {"manifest": manifest}}
        if name != "good.csv":
            status, _, answer = bench.ask("POST", "/api/runs", asked)
            message = json.loads(answer)["error"]
            assert (status, message.startswith(f"{name}: ")) == (422, True), message
            continue
        run = bench.finished(bench.json("POST", "/api/runs", asked)["id"])
        assert run["state"] == "done", run["message"]
        assert run["command"] == "microslip measure --manifest=good.csv -o result --"
        assert "campaign.csv" in run["files"]


@pytest.mark.slow
def test_an_upload_is_no_module_of_ours(bench: Bench, tmp_path: Path) -> None:
    """Python would import from the folder that it is started in, and run what lies there."""
    trace = tmp_path / "ran"
    sent = bench.json("POST", "/api/uploads?name=numpy.py", f"open({str(trace)!r}, 'w')".encode())
    bench.ask("POST", f"/api/uploads/{sent['id']}/look", {"what": "scan"})
    asked = {"kind": "measure", "uploads": [sent["id"]], "options": {}}
    assert bench.finished(bench.json("POST", "/api/runs", asked)["id"])["state"] == "failed"
    assert not trace.exists()


def test_a_run_is_cancelled(bench: Bench) -> None:
    sent = bench.json("POST", "/api/example")
    run = bench.json("POST", "/api/runs", {"kind": "predict", "uploads": [sent["id"]]})
    assert bench.json("POST", f"/api/runs/{run['id']}")["state"] == "cancelled"
    assert bench.finished(run["id"])["files"] == []


# -- as a person --------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_session_in_a_browser(bench: Bench, tmp_path: Path) -> None:
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    (tmp_path / "run.csv").write_bytes(record_text(tmp_path))
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1500, "height": 1000})
        wrong: list[str] = []
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("console", lambda m: wrong.append(m.text) if m.type == "error" else None)
        page.goto(f"http://127.0.0.1:{bench.port}/?token={TOKEN}")
        assert "token" not in page.url
        page.set_input_files("#file", str(tmp_path / "run.csv"))
        page.locator("canvas").first.wait_for(timeout=120_000)
        # What is refused takes neither the pictures nor the open fields away.
        page.locator("details.more summary").click()
        page.locator('[name="zero"]').fill("force=2")
        page.locator('[name="zero"]').press("Enter")
        page.locator("#error", has_text="wanted a zero such as").wait_for(timeout=60_000)
        assert page.locator("canvas").count() == 3
        page.locator('[name="zero"]').fill("")
        page.locator('[name="zero"]').press("Tab")
        columns = page.locator('[name="force"] option').all_inner_texts()
        assert columns[0] == "found by its name"
        assert any("force" in name for name in columns[1:])
        page.locator('[name="flip-sign"]').check()
        page.locator("p.error", has_text="Flip sign").wait_for(timeout=60_000)
        page.locator('[name="flip-sign"]').uncheck()
        page.locator("p.error").wait_for(state="detached", timeout=60_000)
        wrong.clear()  # the browser notes that the workbench refused
        page.locator('[name="command"]').select_option("identify")
        assert page.inner_text("#run") == "Run identify"
        page.locator('[name="command"]').select_option("measure")
        page.click("#run")
        page.locator("#runs li.done").first.wait_for(timeout=120_000)
        report = page.frame_locator("article iframe").locator("h1")
        assert "run" in report.inner_text(timeout=60_000)
        page.reload()
        page.locator("#runs li.done.shown").wait_for(timeout=60_000)  # the list is asked for anew
        assert page.locator("#runs li.done.shown").count() == 1
        page.click("#example")
        page.click("#run")  # waits until the study is there
        page.locator("#runs li.done").nth(1).wait_for(timeout=120_000)
        for _ in range(60):  # the list is drawn anew while the run ends, and a click may be lost
            page.locator("#runs li input").nth(1).check()
            page.wait_for_timeout(500)
            if page.locator("article iframe").count() == 2:
                break
        page.locator("article iframe").nth(1).wait_for(timeout=60_000)
        # A manifest is found by its column of files, and more than twenty records are taken.
        for number in range(21):
            (tmp_path / f"r{number}.csv").write_bytes((tmp_path / "run.csv").read_bytes())
        lines = "\n".join(f"r{number}.csv,{number}" for number in range(21))
        (tmp_path / "list.csv").write_text(f"file,stage\n{lines}\n")
        page.set_input_files("#file", sorted(map(str, tmp_path.glob("[lr]*[0-9t].csv"))))
        page.locator("label", has_text="Manifest").locator("text=list.csv").wait_for(timeout=60_000)
        page.click("#run")
        page.locator("#runs li.done").nth(2).wait_for(timeout=120_000)
        page.screenshot(path=str(tmp_path / "workbench.png"))
        assert not wrong
        browser.close()


def test_options_are_those_of_the_command(bench: Bench, tmp_path: Path) -> None:
    sent = bench.json("POST", "/api/uploads?name=run.csv", record_text(tmp_path))
    for options in (
        {"output": "/tmp"}, {"o": "x"}, {"set": "a=b"}, {"unit": "a\nb"},
        {"confidence": ["1", "2"]},
        {"model": "/etc/passwd"},
    ):  # fmt: skip
        asked = {"kind": "measure", "uploads": [sent["id"]], "options": options}
        assert bench.ask("POST", "/api/runs", asked)[0] == 422
