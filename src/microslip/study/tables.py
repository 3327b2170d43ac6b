"""Floor 8: a result on the terminal."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from rich.box import ASCII, SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from microslip.study.result import some
from microslip.study.units import engineering, significant

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rich.box import Box

MOST_JOINTS = 20
MOST_LOOPS = 40
MOST_VERDICTS = 3

# Friction coefficients are the Greek letter here, prefixes the micro sign.
# Plain words for what an old terminal or a pipe in another encoding cannot carry.
_PLAIN = str.maketrans(
    {
        "\N{MICRO SIGN}": "u",
        "\N{GREEK SMALL LETTER MU}": "mu ",
        "η": "eta",
        "ζ": "zeta",
        "Σ": "sum ",
        "π": " pi ",
        "²": "^2",
        "ₜ": "_t",
        "–": "-",
    }
)
_UNICODE_NEEDED = "µμηζΣπ²ₜ–─"
_COUNTING_LAWS = ("population", "sphere")
_AREA_VERDICT = "real over apparent area"
_WORD_STYLE = {"ok": "green", "watch": "yellow", "outside": "bold red"}


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Leave to the caller what an unread pipe means; rich would exit with 1."""
        raise  # the error that rich is handling when it calls this


class Printer:
    """Prints to one stream, with no more than the stream can show.

    Parameters
    ----------
    stream : file object
        Where the text goes: a terminal in colour, a pipe plainly and in full width.
    """

    def __init__(self, stream: TextIO) -> None:
        encoding = getattr(stream, "encoding", None) or "utf-8"
        try:
            _UNICODE_NEEDED.encode(encoding)
            self._ascii = False
        except (UnicodeEncodeError, LookupError):
            self._ascii = True
        self._encoding = encoding
        # Tables and paths are never folded or cut, and in a pipe there is no width to fit into.
        self._wide = self._narrow = _console(stream, 10_000)
        if _is_terminal(stream):
            self._narrow = _console(stream, None)

    def _fit(self, text: str) -> str:
        if self._ascii:
            text = text.translate(_PLAIN)
        try:
            return text.encode(self._encoding, "replace").decode(self._encoding)
        except LookupError:
            return text.encode("ascii", "replace").decode("ascii")

    def line(self, text: str = "", style: str = "") -> None:
        """Print text, folded between words where it is wider than the terminal."""
        self._narrow.print(Text(self._fit(text), style=style))

    def path(self, text: str) -> None:
        """Print text that must stay in one piece, such as a path."""
        self._wide.print(Text(self._fit(text)), soft_wrap=True)

    def table(self, title: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
        """Print a table of numbers; its columns are never cut."""
        box: Box = ASCII if self._ascii else SIMPLE_HEAD
        self.line(title, style="bold")
        table = Table(
            box=box,
            pad_edge=False,
            show_edge=False,
            header_style="",
        )
        for name in head:
            table.add_column(Text(self._fit(name), style="cyan"), justify="right", no_wrap=True)
        for row in rows:
            table.add_row(*(Text(self._fit(cell)) for cell in row))
        self._wide.print(table)
        self.line()

    def verdict(self, word: str, text: str) -> None:
        """Print one line of the validity."""
        line = Text("  ")
        line.append(f"{word:8}", style=_WORD_STYLE.get(word, ""))
        line.append(self._fit(text))
        self._narrow.print(line)


def _console(stream: TextIO, width: int | None) -> Console:
    return _Console(file=stream, width=width, highlight=False, markup=False, emoji=False)


def _is_terminal(stream: TextIO) -> bool:
    try:
        return stream.isatty()
    except (AttributeError, ValueError):
        return False


def show(summary: dict[str, Any], folder: Path, stream: TextIO) -> None:
    """Print a result so that it can be read at a glance.

    Parameters
    ----------
    summary : dict
        Of a :class:`~microslip.study.result.Result`.
    folder : pathlib.Path
        Where its files are.
    stream : file object
        Such as `sys.stdout`.

    Raises
    ------
    OSError
        If the stream cannot be written.
    """
    out = Printer(stream)
    counted = summary["study"]["surface"]["law"] in _COUNTING_LAWS
    joints = summary["joints"]
    out.line(summary["title"] or "Joint", style="bold")
    out.line()
    shown = [joints[i] for i in some(len(joints), MOST_JOINTS)]
    out.table(
        "Joint" + _left_out(len(shown), len(joints), "loads"),
        ["load", "contacts", "real area", "kₜ", "μN", "slip scale", "h"],
        [_joint_row(joint, counted) for joint in shown],
    )
    amplitudes = len(joints[0]["amplitudes"])
    loops = len(joints) * amplitudes
    if loops > MOST_LOOPS:
        shown = [joints[i] for i in some(len(joints), 4)]
    kept = some(amplitudes, MOST_LOOPS // len(shown))
    out.table(
        "Cycles" + _left_out(len(shown) * len(kept), loops, "loops"),
        ["load", "amplitude", "T/μN", "energy/cycle", "η", "ζ"],
        [_cycle_row(joint, joint["amplitudes"][i]) for joint in shown for i in kept],
    )
    _validity(out, joints)
    out.line()
    for note in summary["notes"][:-1]:
        out.line(note)
    out.line(
        "η (loss factor) and ζ = η/2 (damping ratio) are the interface's own, not a mode's: "
        "in a structure ζ_mode = ΣE_d / 4πU."
    )
    out.line()
    out.path(f"Written to {folder}:")
    out.path("  " + "  ".join(summary["files"]))


def _left_out(shown: int, count: int, what: str) -> str:
    return "" if shown == count else f" ({shown} of {count} {what}; all are in summary.json)"


def _joint_row(joint: dict[str, Any], counted: bool) -> list[str]:
    count, share = joint["contact_count"], joint["contact_area_fraction"]
    h = joint["standardised_separation"]
    return [
        engineering(joint["normal_load"], "N", trim=True),
        _count(count, counted),
        _area(joint["contact_area"]) if share is None else f"{significant(100.0 * share)} %",
        engineering(joint["tangential_stiffness"], "N/m"),
        engineering(joint["force_limit"], "N"),
        engineering(joint["slip_scale"], "m"),
        "–" if h is None else f"{h:.3f}" if abs(h) < 1000.0 else f"{h:.3g}",
    ]


def _count(count: float | None, counted: bool) -> str:
    """Contacts: whole where they are counted, else digits of their expected number."""
    if count is None:
        return "–"
    return f"{count:.0f}" if counted or count >= 100.0 else significant(count)


def _area(area: float | None) -> str:
    return "–" if area is None else f"{significant(area * 1e6)} mm²"


def _cycle_row(joint: dict[str, Any], row: dict[str, Any]) -> list[str]:
    return [
        engineering(joint["normal_load"], "N", trim=True),
        engineering(row["amplitude"], "m", trim=True),
        _share(row["force_ratio"]),
        engineering(row["dissipated_energy"], "J"),
        _ratio(row["loss_factor"]),
        _ratio(row["damping_ratio"]),
    ]


def _ratio(value: float) -> str:
    """Decimals below each other where they all show something."""
    return f"{value:.3f}" if value >= 0.0995 else significant(value)


def _share(value: float) -> str:
    """A ratio that tends to one, where all slides, and says so only once it is there."""
    return ">0.999" if 0.9995 <= value < 1.0 - 1e-12 else _ratio(value)


def _judged(verdict: dict[str, Any]) -> str:
    """Value of a verdict that is not ok, and where ok would be."""
    value, limit = verdict["value"], verdict["limit"]
    if verdict["name"] == _AREA_VERDICT:  # in percent, as in the table
        shown, bound = f"{significant(100.0 * value)} %", f"{100.0 * limit:.3g} %"
    else:
        shown, bound = significant(value), f"{limit:.3g}"
    return f"{shown} (ok {'from' if value < limit else 'up to'} {bound})"


def _validity(out: Printer, joints: list[dict[str, Any]]) -> None:
    """Each verdict that is not ok, with its value and where ok is; the others only by name."""
    out.line("Validity", style="bold")
    fine: list[str] = []
    for name in dict.fromkeys(v["name"] for joint in joints for v in joint["validity"]):
        found = [
            (joint, verdict)
            for joint in joints
            for verdict in joint["validity"]
            if verdict["name"] == name
        ]
        doubtful = [(joint, verdict) for joint, verdict in found if verdict["word"] != "ok"]
        if not doubtful:
            fine.append(name)
        same = len(doubtful) == len(joints) and len({v["value"] for _, v in doubtful}) == 1
        doubtful.sort(key=lambda pair: pair[1]["word"] != "outside")
        shown = doubtful[: 1 if same else MOST_VERDICTS]
        for joint, verdict in shown:
            at = "" if same else f" at {engineering(joint['normal_load'], 'N', trim=True)}"
            out.verdict(
                verdict["word"],
                f"{name}{at}: {_judged(verdict)} – assumed: {verdict['meaning']}",
            )
        if not same and len(doubtful) > len(shown):
            left = len(doubtful) - len(shown)
            out.line(f"          and at {left} other load{'s' if left > 1 else ''}")
    if fine:
        out.verdict("ok", ", ".join(fine))
    if not any(joint["validity"] for joint in joints):
        out.line("  no limits are known for this law")
