#!/usr/bin/env python3
"""Predict the published numbers of the record, and write results.json and docs/record.md.

Each folder beside this file is a case: ``case.toml`` has the measured numbers with their source,
``predict.py`` the frozen inputs and a function ``predict`` that returns 5, 50 and 95 % of each
number, ``frozen.sha256`` the checksums of the inputs. A case is computed again when its files or
the version of microslip have changed. One that needs data that this machine lacks keeps its
earlier row. CONTRIBUTING.md describes how to add a case.

Usage: run.py [CASE ...] [--again] [--freeze CASE]
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import importlib.util
import json
import math
import re
import sys
import textwrap
import time
import tomllib
from pathlib import Path
from typing import Any

import microslip as ms

HERE = Path(__file__).parent
ROOT = HERE.parent
RESULTS = HERE / "results.json"
PAGE = ROOT / "docs" / "record.md"
FIGURE = ROOT / "docs" / "images" / "predictions.svg"
LABELS = ("blind", "retrospective")
REQUIRED = {"title", "source", "label", "known", "licence", "condition", "measured"}
ROUNDING = 1e-12
"""Relative difference that counts as none."""


def cases() -> list[str]:
    """Return the names of all cases in alphabetical order."""
    return sorted(path.parent.name for path in HERE.glob("*/case.toml"))


def read_case(name: str) -> dict[str, Any]:
    """Read the description of a case; raise ValueError where something is missing."""
    case = tomllib.loads((HERE / name / "case.toml").read_text("utf-8"))
    missing = REQUIRED - set(case)
    if missing:
        raise ValueError(f"{name}/case.toml lacks {', '.join(sorted(missing))}")
    if not case["label"].startswith(LABELS):
        raise ValueError(f"{name}/case.toml: label must begin with one of {LABELS}")
    names = [row["name"] for row in case["measured"]]
    if len(set(names)) != len(names):
        raise ValueError(f"{name}/case.toml: two measured numbers have the same name")
    return case


def checksums(name: str) -> str:
    """Return the checksums of the inputs of a case, as sha256sum writes them."""
    files = sorted(
        path
        for path in (HERE / name).iterdir()
        if path.is_file() and path.name not in ("case.toml", "frozen.sha256")
    )
    lines = [f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}" for path in files]
    return "\n".join(lines) + "\n"


def check_frozen(name: str) -> None:
    """Raise ValueError if an input of a case has changed since it was frozen."""
    frozen = HERE / name / "frozen.sha256"
    if not frozen.exists():
        raise ValueError(f"{name} is not frozen: run record/run.py --freeze {name}")
    if frozen.read_text("utf-8") != checksums(name):
        raise ValueError(
            f"the inputs of {name} have changed since they were frozen; "
            "a better model is a new case with a new date"
        )


def predict(name: str) -> dict[str, tuple[float, float, float]]:
    """Run the frozen prediction of a case."""
    path = HERE / name / "predict.py"
    spec = importlib.util.spec_from_file_location(f"record_{name.replace('-', '_')}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    bands: dict[str, tuple[float, float, float]] = module.predict()
    return bands


def compared(case: dict[str, Any], bands: dict[str, tuple[float, float, float]]) -> list[dict]:
    """Return one row for each measured number, beside its prediction."""
    rows = []
    for number in case["measured"]:
        low, median, high = (float(x) for x in bands[number["name"]])
        if not (math.isfinite(median) and low <= median <= high):
            raise ValueError(f"{case['title']}: {number['name']} has no band: {low, median, high}")
        value = float(number["value"])
        least, most = (float(number.get(key, value)) for key in ("low", "high"))
        slack = ROUNDING * abs(value)
        rows.append(
            {
                "name": number["name"],
                "unit": number.get("unit", ""),
                "measured": value,
                "measured_range": [least, most],
                "predicted": [low, median, high],
                "ratio": median / value,
                "inside": low <= most + slack and high >= least - slack,
            }
        )
    return rows


def run(names: list[str], again: bool) -> dict[str, Any]:
    """Compute the cases and return all results, those of before included."""
    stored = json.loads(RESULTS.read_text("utf-8")) if RESULTS.exists() else {"cases": {}}
    results = {name: stored["cases"][name] for name in cases() if name in stored["cases"]}
    for name in names:
        case = read_case(name)
        check_frozen(name)
        inputs = hashlib.sha256(
            (HERE / name / "case.toml").read_bytes() + checksums(name).encode()
        ).hexdigest()
        known = results.get(name)
        if known and not again and (known["inputs"], known["version"]) == (inputs, ms.__version__):
            print(f"{name}: up to date", flush=True)
            continue
        begun = time.perf_counter()
        try:
            bands = predict(name)
        except OSError as error:
            # SciPy wraps the error of a file that is not there in one of its own.
            missing = error if isinstance(error, FileNotFoundError) else error.__cause__
            if not isinstance(missing, FileNotFoundError):
                raise
            print(f"{name}: kept, it needs {missing.filename or missing}", flush=True)
            continue
        results[name] = {
            "version": ms.__version__,
            "date": datetime.date.today().isoformat(),
            "inputs": inputs,
            "rows": compared(case, bands),
        }
        hit = sum(row["inside"] for row in results[name]["rows"])
        took = time.perf_counter() - begun
        print(f"{name}: {hit} of {len(results[name]['rows'])} inside, {took:.0f} s", flush=True)
        # Written after each case, so that a run that is stopped goes on where it was.
        write_results(results)
    write_results(results)
    return results


def write_results(results: dict[str, Any]) -> None:
    """Write the results of all cases."""
    text = json.dumps({"cases": dict(sorted(results.items()))}, indent=1)
    RESULTS.write_text(text + "\n", "utf-8")


def short(value: float) -> str:
    """A number in four digits."""
    return f"{value:.4g}"


def wrapped(text: str) -> list[str]:
    """Return the lines of a paragraph."""
    return textwrap.wrap(text, 118, break_long_words=False, break_on_hyphens=False)


def page(results: dict[str, Any]) -> str:
    """Return docs/record.md."""
    rows = [row for name in results for row in results[name]["rows"]]
    inside = sum(row["inside"] for row in rows)
    lines = [
        "# Record of predictions",
        "",
        *wrapped(
            "Here you find how far predictions of microslip are from published measurements, and "
            f"from computations of others, misses included: {len(results)} cases, {len(rows)} "
            f"numbers, {inside} of them inside the predicted band."
        ),
        "",
        "![Predicted over measured with the predicted bands, all cases](images/predictions.svg)",
        "",
        *wrapped(
            "Inputs are frozen by checksums before the comparison and stay as they are: a better "
            "model adds a case with a new date. A prediction is *blind* only if it is dated before "
            "the data were seen; all others are *retrospective*. A number is inside if its "
            "measured range meets the predicted band of 5 to 95 %. `make record` computes the "
            "page; [Contributing](contributing.md) describes how to add a case."
        ),
        "",
        "| case | numbers | inside | median of predicted / measured | label |",
        "| --- | --- | --- | --- | --- |",
    ]
    described = {name: read_case(name) for name in results}
    for name, result in results.items():
        ratios = sorted(row["ratio"] for row in result["rows"])
        middle = ratios[len(ratios) // 2]
        hit = sum(row["inside"] for row in result["rows"])
        case = described[name]
        anchor = re.sub(r"[^\w\- ]", "", case["title"].lower()).replace(" ", "-")
        lines.append(
            f"| [{case['title']}](#{anchor}) | {len(ratios)} | {hit} | {middle:.3g} "
            f"| {case['label']} |"
        )
    for name, result in results.items():
        case = described[name]
        doi = f", [doi:{case['doi']}](https://doi.org/{case['doi']})" if case.get("doi") else ""
        lines += ["", f"## {case['title']}", ""]
        text = (
            f"{case['condition']} Source: {case['source']}{doi}; {case['licence']}. "
            f"*{case['label'].capitalize()}*: {case['known']}"
        )
        lines += wrapped(text)
        if not all(row["inside"] for row in result["rows"]):
            text = f"**Misses.** {case['miss']}"
            lines += ["", *wrapped(text)]
        lines += [
            "",
            f"Computed with version {result['version']} on {result['date']}; inputs in "
            f"[record/{name}](../record/{name}/predict.py).",
            "",
            "| what | measured | predicted 5 % | 50 % | 95 % | predicted / measured | inside |",
            "| --- | --- | --- | --- | --- | --- | --- |",
        ]
        for row in result["rows"]:
            unit = f" [{row['unit']}]" if row["unit"] else ""
            least, most = row["measured_range"]
            measured = short(row["measured"])
            if least != most:
                measured += f" ({short(least)} to {short(most)})"
            low, median, high = (short(x) for x in row["predicted"])
            lines.append(
                f"| {row['name']}{unit} | {measured} | {low} | {median} | {high} "
                f"| {row['ratio']:.3g} | {'yes' if row['inside'] else '**no**'} |"
            )
    return "\n".join(lines) + "\n"


def draw(results: dict[str, Any]) -> None:
    """Draw all ratios with their bands on one logarithmic axis."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "microslip"
    import matplotlib.pyplot as plt

    plt.style.use("microslip.style")
    count = sum(len(result["rows"]) for result in results.values()) + 2 * len(results)
    figure, axes = plt.subplots(figsize=(7.5, 0.6 + 0.105 * count))
    place, ticks, words = 0.0, [], []
    for name, result in results.items():
        begin = place
        for row in result["rows"]:
            low, median, high = (x / row["measured"] for x in row["predicted"])
            least, most = (x / row["measured"] for x in row["measured_range"])
            axes.plot([least, most], [place, place], color="0.75", linewidth=4.0, zorder=1)
            colour = "C0" if row["inside"] else "C1"
            axes.plot([low, high], [place, place], color=colour, linewidth=1.5, zorder=2)
            marker = "o" if row["inside"] else "D"
            axes.plot(median, place, marker, color=colour, markersize=3.5, zorder=3)
            place += 1.0
        ticks.append((begin + place - 1.0) / 2.0)
        words.append(read_case(name)["title"])
        place += 1.0
        axes.axhline(place - 1.0, color="0.9", linewidth=0.6, zorder=0)
        place += 1.0
    axes.axvline(1.0, color="0.3", linewidth=0.8, zorder=0)
    marks = (0.2, 0.5, 1, 2, 5)
    axes.set(xscale="log", xlabel="predicted / measured", yticks=ticks, ylim=(place - 1.0, -1.0))
    axes.set_xticks(marks, [f"{mark:g}" for mark in marks])
    axes.minorticks_off()
    axes.set_yticklabels(["\n".join(textwrap.wrap(word, 34)) for word in words], fontsize=7)
    axes.plot([], [], "o-", color="C0", markersize=3.5, label="inside the 5 to 95 % band")
    axes.plot([], [], "D-", color="C1", markersize=3.5, label="outside")
    axes.plot([], [], color="0.75", linewidth=4.0, label="range of the measurement")
    axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncol=3, fontsize=7, frameon=False)
    FIGURE.parent.mkdir(exist_ok=True)
    figure.savefig(FIGURE, bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("case", nargs="*", help="cases to run; all if none is named")
    parser.add_argument("--again", action="store_true", help="compute also what is up to date")
    parser.add_argument("--freeze", metavar="CASE", help="write the checksums of a new case")
    arguments = parser.parse_args()
    if arguments.freeze:
        frozen = HERE / arguments.freeze / "frozen.sha256"
        if frozen.exists():
            print(f"error: {arguments.freeze} is frozen already", file=sys.stderr)
            return 2
        read_case(arguments.freeze)
        frozen.write_text(checksums(arguments.freeze), "utf-8")
        return 0
    unknown = set(arguments.case) - set(cases())
    if unknown:
        print(f"error: no case {', '.join(sorted(unknown))} in {HERE}", file=sys.stderr)
        return 2
    results = run(arguments.case or cases(), arguments.again)
    for name, result in results.items():
        explained = "miss" in read_case(name)
        if explained == all(row["inside"] for row in result["rows"]):
            wanted = "must not explain" if explained else "must explain"
            print(f"error: {name}/case.toml {wanted} a miss (`miss = ...`)", file=sys.stderr)
            return 1
    PAGE.write_text(page(results), "utf-8")
    draw(results)
    print(f"{len(results)} cases, {sum(len(r['rows']) for r in results.values())} numbers")
    return 0


if __name__ == "__main__":
    sys.exit(main())
