"""Runs of the workbench: commands in separate processes and folders."""

from __future__ import annotations

import asyncio
import json
import os
import re
import shlex
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from secrets import token_hex
from typing import Any

from microslip._core.errors import InputError
from microslip._core.wording import quote
from microslip.study.toml_text import FILE_KEYS, read_text, tables_of

LOOK = "look"
"""Prefix of the form names for file previews: "look record", "look scan"."""
LONGEST_TEXT = 200
_JOB_LIMIT = 500
_WORKERS = max(1, (os.cpu_count() or 2) - 1)
RESULT = "result"
MANIFEST_NAME = "manifest"
"""Field of a form for a sheet that lists the uploaded files."""


@dataclass(frozen=True)
class Field:
    """Form field for an option of a command, generated from the command."""

    name: str  # option name without dashes
    label: str
    help: str
    kind: str  # text, flag, choice, column, file or study: the last two are uploads
    choices: tuple[str, ...]
    several: bool  # may be repeated
    values: int  # number of values per occurrence
    placeholder: str  # default or example
    looks: bool  # affects file previews
    usual: bool  # always shown


Forms = Mapping[str, Sequence[Field]]
"""Fields of each command and of each file preview."""


@dataclass
class Upload:
    """Uploaded file, stored under a safe name."""

    id: str
    name: str
    path: Path

    def summary(self) -> dict[str, Any]:
        """Return identifier and name of the upload for the web page."""
        return {"id": self.id, "name": self.name}


@dataclass
class Run:
    """Run of a command: its arguments, state, output and folder."""

    id: str
    kind: str
    arguments: list[str]
    folder: Path
    state: str = "waiting"
    progress: float = 0.0
    message: str = ""
    printed: str = ""
    process: asyncio.subprocess.Process | None = field(default=None, repr=False)

    @property
    def command(self) -> str:
        """Command line that gives the same result if it is run in the folder of the files."""
        return shlex.join(["microslip", *self.arguments])

    def files(self) -> dict[str, Path]:
        """Return the paths of the result files by name."""
        folder = self.folder / RESULT
        if self.state != "done" or not folder.is_dir():
            return {}
        return {path.name: path for path in sorted(folder.iterdir()) if path.is_file()}

    def summary(self) -> dict[str, Any]:
        """Return state, messages and result files of the run for the web page."""
        plain = {
            name: getattr(self, name) for name in ("id", "kind", "state", "progress", "message")
        }
        return {
            **plain, "command": self.command, "printed": self.printed, "files": [*self.files()],
        }  # fmt: skip


def safe_name(name: str) -> str:
    """Return a file name that is valid on every system and contains no path."""
    last = re.split(r"[\\/]", name)[-1]
    stem = re.sub(r"[^A-Za-z0-9._-]", "_", last).lstrip(".-")[-80:].lstrip(".-")
    return stem or "file"


class Workspace:
    """Uploads and runs of the workbench, in a private temporary folder."""

    def __init__(self, folder: Path, forms: Forms) -> None:
        self.folder, self.forms = folder, forms
        self.uploads: dict[str, Upload] = {}
        self.runs: dict[str, Run] = {}
        self._free = asyncio.Semaphore(_WORKERS)
        self._tasks: set[asyncio.Task[None]] = set()

    def place(self, name: str) -> Upload:
        """Register a new upload and create its folder; the file is written later."""
        number = token_hex(8)
        folder = self.folder / number
        folder.mkdir(mode=0o700)
        upload = Upload(number, safe_name(name), folder / safe_name(name))
        self.uploads[number] = upload
        return upload

    def start(self, request: dict[str, Any]) -> Run:
        """Start a run requested by the page, after validating its uploads and options."""
        kind = request.get("kind")
        commands = [name for name in self.forms if not name.startswith(LOOK)]
        if not isinstance(kind, str) or kind not in commands:
            raise InputError(f"kind must be one of {', '.join(commands)}, got {quote(kind)}")
        inputs = request.get("uploads")
        if not isinstance(inputs, list) or not 1 <= len(inputs) <= _JOB_LIMIT:
            raise InputError(f"a run must have 1 to {_JOB_LIMIT} files, in a list `uploads`")
        uploads = [self._upload(number) for number in inputs]
        options = request.get("options") or {}
        arguments, others = self._options(kind, options)
        for study in uploads if kind == "predict" else ():
            check_study(study.path)
        manifest = options.get(MANIFEST_NAME)
        names = manifest_names(self._upload(manifest), uploads) if manifest else {}
        run = Run(token_hex(8), kind, [], self.folder / token_hex(8))
        run.folder.mkdir(mode=0o700)
        by_id = {
            number: _copied(self.uploads[number], run.folder, names.get(number))
            for number in dict.fromkeys(u.id for u in (*uploads, *others))
        }
        run.arguments = [
            kind,
            *(_filled(argument, by_id) for argument in arguments),
            *("-o", RESULT, "--"),
            *(by_id[upload.id] for upload in uploads if not manifest),
        ]
        self.runs[run.id] = run
        task = asyncio.get_running_loop().create_task(self._work(run))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return run

    def _upload(self, number: Any) -> Upload:
        if not isinstance(number, str) or number not in self.uploads:
            raise InputError("an upload is no longer available; upload the file again")
        return self.uploads[number]

    def _options(self, kind: str, options: Any) -> tuple[list[str], list[Upload]]:
        if not isinstance(options, dict):
            raise InputError("options must be a table")
        fields = {field.name: field for field in self.forms[kind]}
        arguments: list[str] = []
        files = []
        for name, value in options.items():
            field = fields.get(name)
            if field is None:
                raise InputError(f"{kind} has no option {quote(name)} here")
            if field.kind == "flag":
                if value:
                    arguments.append(f"--{name}")
                continue
            values = value if isinstance(value, list) else [value]
            if len(values) > (_JOB_LIMIT if field.several else field.values):
                count = _JOB_LIMIT if field.several else field.values
                raise InputError(f"{name} must hold at most {count} values")
            if field.kind in ("file", "study"):
                uploads = [self._upload(item) for item in values]
                for upload in uploads if field.kind == "study" else ():
                    check_study(upload.path)
                files += uploads
                arguments += [f"--{name}=\0{upload.id}" for upload in uploads]
            elif field.values > 1:
                if len(values) != field.values:
                    raise InputError(f"{name} must hold {field.values} values, got {len(values)}")
                arguments += [f"--{name}", *(_text(name, item) for item in values)]
            else:
                arguments += [f"--{name}={_text(name, item)}" for item in values]
        return arguments, files

    def in_fields(self, kind: str, text: str) -> str:
        """Replace names of options in the message of a command by labels of the form fields."""
        labels = {f"--{field.name}": field.label for field in self.forms[kind]}
        return re.sub(
            r"--[a-z][a-z-]*[a-z]",
            lambda match: f'"{labels[match[0]]}"' if match[0] in labels else match[0],
            text,
        )

    async def look(self, kind: str, upload: Upload, options: Any) -> Any:
        """Return the preview of an upload, which is read in a separate process.

        ``kind`` is "scan" or "record", and ``options`` are those of the form of its preview.
        """
        fields = {field.name: field for field in self.forms[f"{LOOK} {kind}"]}
        options = {
            name: value[: None if fields[name].several else fields[name].values]
            if isinstance(value, list)
            else value
            for name, value in (options if isinstance(options, dict) else {}).items()
            if name in fields
        }
        arguments, _ = self._options(f"{LOOK} {kind}", options)
        view = await preview([kind, *arguments, "--", upload.name], upload.path.parent)
        for name in {"error", "no_cycles"} & view.keys():
            view[name] = self.in_fields(f"{LOOK} {kind}", view[name])
        return view

    async def _work(self, run: Run) -> None:
        async with self._free:
            if run.state == "cancelled":
                return
            run.state = "running"
            run.process = await asyncio.create_subprocess_exec(
                sys.executable, "-P", "-m", "microslip", *run.arguments,
                cwd=run.folder, stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.PIPE,
                env={**os.environ, "MICROSLIP_PROGRESS": "lines", "NO_COLOR": "1",
                     "PYTHONIOENCODING": "utf-8"},
            )  # fmt: skip
            if run.state == "cancelled":  # while the process was starting
                run.process.terminate()
            assert run.process.stdout is not None
            reading = asyncio.create_task(run.process.stdout.read())
            await self._follow(run, run.process)
            run.printed = (await reading).decode("utf-8", "replace")[:200_000]
            code = await run.process.wait()
        if run.state != "cancelled":
            run.state = "done" if code == 0 else "failed"
            run.progress = 1.0

    async def _follow(self, run: Run, process: asyncio.subprocess.Process) -> None:
        assert process.stderr is not None
        while True:
            try:
                line = await process.stderr.readline()
            except ValueError:  # line exceeds the buffer
                continue
            if not line:
                return
            text = line.decode("utf-8", "replace").strip()
            if re.fullmatch(r"progress [01]\.\d+", text):
                run.progress = float(text.split()[1])
            elif text:
                run.message = self.in_fields(run.kind, text.removeprefix("error: "))[:2000]

    async def cancel(self, run: Run) -> None:
        """Stop a run and remove its partial results."""
        if run.state not in ("waiting", "running"):
            return
        run.state = "cancelled"
        if run.process is not None and run.process.returncode is None:
            run.process.terminate()
            try:
                await asyncio.wait_for(run.process.wait(), 5.0)
            except TimeoutError:
                run.process.kill()

    async def remove(self, run: Run) -> None:
        """Delete a run and its files."""
        await self.cancel(run)
        self.runs.pop(run.id, None)
        shutil.rmtree(run.folder, ignore_errors=True)

    async def close(self) -> None:
        """Stop all runs."""
        for run in list(self.runs.values()):
            await self.cancel(run)
        await asyncio.gather(*self._tasks, return_exceptions=True)


def check_study(path: Path) -> str:
    """Return the text of a study; raise an InputError if the study names files on this machine."""
    try:
        tables: list[Any] = [tables_of(text := read_text(path))]
    except ValueError as error:
        raise InputError(f"{path.name}: {error}") from None
    while tables:
        table = tables.pop()
        for key, value in table.items() if isinstance(table, dict) else enumerate(table):
            if key in FILE_KEYS:
                raise InputError(
                    f"{path.name}: {key} refers to a file, which only the command can read: "
                    f"microslip predict {path.name}"
                )
            if isinstance(value, (dict, list)):
                tables.append(value)
    return text


def manifest_names(manifest: Upload, uploads: Sequence[Upload]) -> dict[str, str]:
    """Map the identifier of each upload to the file name that the manifest lists for it.

    A manifest is a table of records with their loads and columns.

    Raises
    ------
    InputError
        If the files in the manifest are not exactly the uploads.
    """
    from microslip.laboratory.manifest import Manifest

    try:
        paths = Manifest.read(manifest.path).paths
    except InputError as error:
        raise InputError(error.text.replace(f"{manifest.path.parent}{os.sep}", "")) from None
    names = [os.path.relpath(path, manifest.path.parent) for path in paths]
    sent = {upload.name for upload in uploads}
    for name in names:
        is_plain = not re.search(r'[\\/:*?"<>|]', name) and not name.startswith(".")
        if not is_plain or safe_name(name) not in sent:
            raise InputError(
                f"{manifest.name}: lists {quote(name)}, which is not among the files of this run; "
                "choose all files together, and list them without folders"
            )
    by_name = {safe_name(name): name for name in names}
    if missing := sent - by_name.keys():
        raise InputError(f"{manifest.name}: does not list {quote(min(missing))}")
    return {upload.id: by_name[upload.name] for upload in uploads}


def _filled(argument: str, names: dict[str, str]) -> str:
    head, mark, number = argument.partition("\0")
    return f"{head}{names[number]}" if mark else argument


def _copied(upload: Upload, folder: Path, name: str | None = None) -> str:
    name, number = name or upload.name, 1
    while (folder / name).exists() or name == RESULT:
        number += 1
        name = f"{number}-{upload.name}"
    shutil.copyfile(upload.path, folder / name)
    return name


def _text(name: str, value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise InputError(f"{name} must be text or a number")
    text = str(value).strip()
    if not text or len(text) > LONGEST_TEXT or not text.isprintable():
        raise InputError(f"{name} must be 1 to {LONGEST_TEXT} printable characters")
    return text


async def preview(arguments: list[str], folder: Path) -> dict[str, Any]:
    """Run :mod:`microslip.cli.workbench` in a separate process and return its preview of a file.

    ``arguments`` are those of its command, run in ``folder``. The key "error" is the reason why
    there is no preview.
    """
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-P", "-m", "microslip.cli.workbench", *arguments, cwd=folder,
        stdin=asyncio.subprocess.DEVNULL, stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
    )  # fmt: skip
    try:
        output, _ = await asyncio.wait_for(process.communicate(), 120.0)
    except TimeoutError:
        process.kill()
        return {"error": "reading the file took over two minutes"}
    try:
        view: dict[str, Any] = json.loads(output)
    except ValueError:
        return {"error": "the file could not be read"}
    return view
