"""Files read in a child process, because other libraries parse them.

Damaged files can make such parsers write to invalid memory or exhaust it. The child loads the
library once and forks for each file, with bounded memory and time, and returns plain numbers in an
archive. A crash of a fork becomes a one-line error. If processes cannot be forked, a new child is
started for each file.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import numpy as np

from microslip._core.errors import InputError
from microslip.readers.files import POINTS, allowed_points, decoded, first_line, limited

_BYTES_A_POINT: Final = 24  # unpacked, parsed and written: 8 bytes each
_BESIDE: Final = 1 << 28  # bytes allowed in addition to the numbers
_UNKNOWN: Final = 1 << 30  # assumed address space of Python with libraries, if unknown
_SECONDS: Final = 10.0
_PATIENCE: Final = 10  # allowed wall time over CPU time, for a busy machine


def parsed(
    kind: str,
    path: Path,
    reader: Callable[..., Any],
    *,
    libraries: Sequence[str] = (),
    bytes_a_second: float = 2e7,
    **options: Any,
) -> Any:
    """Run a reader on a file in a child process and return its result.

    Parameters
    ----------
    kind : str
        Kind of the file, such as "MAT-file".
    path : path
        The file.
    reader : callable
        Module-level function, called with the path and `options`, which are plain numbers, texts
        and lists. It returns numbers, texts and arrays in lists and mappings; tuples become
        lists.
    libraries : sequence of str
        Modules imported by the reader, kept loaded for the next file.
    bytes_a_second : float
        Lowest expected parsing speed [B/s], which extends the time limit for large files.
    """
    size = path.stat().st_size  # raises OSError for a missing file
    with decoded(kind), tempfile.TemporaryDirectory(prefix="microslip-") as folder:
        answer = Path(folder) / "answer.npz"
        seconds = _SECONDS + size / bytes_a_second
        request = {
            "path": os.path.abspath(path),  # noqa: PTH100 - never raises
            "reader": [reader.__module__, reader.__name__],
            "options": options,
            "libraries": list(libraries),
            "points": allowed_points(),
            "seconds": seconds,
            "answer": str(answer),
        }
        status = _server.run(request)
        if status != 0 or not answer.is_file():
            raise ValueError(_cause(status, seconds))
        with np.load(answer, allow_pickle=False) as archive:
            tree = json.loads(str(archive["tree"]))
            if tree.get("error") == "memory":
                if (points := allowed_points()) > POINTS:
                    raise MemoryError
                raise ValueError(f"unpacks to more than {points} points can need")
            if "error" in tree:
                raise (InputError if tree["error"] == "input" else ValueError)(tree["text"])
            return _joined(tree["value"], archive)


def _cause(status: int | None, seconds: float) -> str:
    if status is None or status >= 0:
        return "damaged, its reader returned no result"
    name = signal.Signals(-status).name
    if name in ("SIGXCPU", "SIGALRM", "SIGKILL"):
        return f"its reader exceeded {seconds:.0f} s or the memory limit"
    return f"damaged, its reader crashed ({name})"


class _Server:
    """Child process that serves all requests, started at the first one."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._owner = 0
        self._lock = threading.Lock()

    def run(self, request: Mapping[str, Any]) -> int | None:
        """Return the exit status of the fork that handled a request; None if the child died."""
        with self._lock:
            process = self._started_process()
            assert process.stdin is not None
            assert process.stdout is not None
            patience = threading.Timer(2 * _PATIENCE * request["seconds"], process.kill)
            patience.daemon = True
            patience.start()
            try:
                process.stdin.write(json.dumps(request).encode("ascii") + b"\n")
                process.stdin.flush()
                line = process.stdout.readline()
            except OSError:
                line = b""
            except BaseException:  # a late reply would be taken for the next file's
                self._end()
                raise
            finally:
                patience.cancel()
            if not line or not hasattr(os, "fork"):
                self._end()
            return int(line) if line else None

    def _started_process(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._owner == os.getpid():
            if self._process.poll() is None:
                return self._process
            self._end()
        # A process forked from this one must not use its child.
        here = os.fspath(Path(__file__).parents[2])
        places = [here, *filter(None, [os.environ.get("PYTHONPATH")])]
        self._process = subprocess.Popen(
            # -P: the working directory may contain foreign modules.
            [sys.executable, "-P", "-m", "microslip.readers.child"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": os.pathsep.join(places)},
        )
        self._owner = os.getpid()
        atexit.register(self._end)
        return self._process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        with contextlib.suppress(OSError):
            if hasattr(os, "killpg"):
                os.killpg(process.pid, signal.SIGKILL)
            else:
                process.kill()
        for pipe in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):
                pipe.close()  # type: ignore[union-attr]
        process.wait()


_server = _Server()


def _joined(node: Any, archive: Mapping[str, Any]) -> Any:
    if isinstance(node, list):
        return [_joined(item, archive) for item in node]
    if not isinstance(node, dict):
        return node
    if "array" in node:
        return archive[node["array"]]
    return {name: _joined(item, archive) for name, item in node["items"].items()}


# ------------------------------------------------------------------ what runs in the child


def _split(value: Any, arrays: dict[str, Any]) -> Any:
    """Convert a result to JSON data; its arrays are stored in ``arrays`` and replaced by names."""
    if isinstance(value, dict):
        return {"items": {str(key): _split(item, arrays) for key, item in value.items()}}
    if isinstance(value, (list, tuple)):
        return [_split(item, arrays) for item in value]
    if isinstance(value, np.ndarray):
        if value.dtype.kind in "iufcb":
            name = f"a{len(arrays)}"
            arrays[name] = value
            return {"array": name}
        if value.dtype == object:
            return [_split(item, arrays) for item in value.flat]
        return None
    if isinstance(value, np.generic):
        value = value.item()
    return value if isinstance(value, (str, int, float, bool)) else None


def _read_request(request: Mapping[str, Any]) -> None:
    arrays: dict[str, Any] = {}
    try:
        import warnings

        warnings.simplefilter("ignore")
        module, name = request["reader"]
        with limited(request["points"]):
            value = getattr(import_module(module), name)(
                Path(request["path"]), **request["options"]
            )
        tree = {"value": _split(value, arrays)}
    except MemoryError:
        tree, arrays = {"error": "memory", "text": ""}, {}
    except InputError as error:
        tree, arrays = {"error": "input", "text": error.text}, {}
    except Exception as error:  # damaged files break parsers in many ways
        tree, arrays = {"error": "other", "text": first_line(error, Path(request["path"]))}, {}
    np.savez(request["answer"], tree=np.array(json.dumps(tree)), **arrays)


def _bounded(request: Mapping[str, Any]) -> None:
    try:
        import resource
    except ImportError:  # Windows: only the parent limits the time
        return
    before = _UNKNOWN
    with contextlib.suppress(OSError, ValueError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        before = pages * resource.getpagesize()
    memory = before + _BESIDE + _BYTES_A_POINT * request["points"]
    seconds = int(request["seconds"]) + 1
    for bound, value in (
        (resource.RLIMIT_AS, memory),
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(bound)[1]
        least = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(bound, (least, hard))
    signal.alarm(_PATIENCE * seconds)


def serve_child() -> None:
    """Handle requests of the parent, one per line of standard input, each in a fork."""
    lines = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # libraries must not print into the replies
    for line in sys.stdin:
        request = json.loads(line)
        for library in request["libraries"]:
            with contextlib.suppress(Exception):  # the reader reports the missing library
                import_module(library)
        status = 0
        if not hasattr(os, "fork"):
            _read_request(request)
        elif (fork := os.fork()) == 0:
            try:
                _bounded(request)
                _read_request(request)
            finally:
                os._exit(0)
        else:
            status = os.waitstatus_to_exitcode(os.waitpid(fork, 0)[1])
        print(status, file=lines, flush=True)


if __name__ == "__main__":
    serve_child()
