"""Draw the chapter's figures for the documentation: python docs/make_figures.py"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from microslip.chapter import LEFT_OUT, PLATES

PAGE = Path(__file__).with_name("figures.md")
FOLDER = Path(__file__).with_name("images") / "chapter"

HEAD = """\
# The chapter's figures

Here you find the figures of chapter 19 of *The Mechanics of Jointed Structures*
([doi:10.1007/978-3-319-56818-8_19](https://doi.org/10.1007/978-3-319-56818-8_19)), all but one
photograph, drawn with this library. The axes of the chapter have no numbers, so each figure states
its assumptions. Where the chapter shows measurements (19.6, 19.7, 19.22) the data are synthetic and
labelled so. One command draws all figures as SVG and PNG, with their data as CSV (sketches have
none); `--only` selects figures:

```sh
microslip figures -o figures
microslip figures --only 19.13 --only 19.14 -o loops
```

Differences from the chapter are listed in [misprints.md](misprints.md).
`python docs/make_figures.py` writes this page.
"""


def page() -> str:
    """Return the page with titles, captions and assumptions of the figures."""
    parts = [HEAD]
    for plate in PLATES:
        title = f"Fig. {plate.number}: {plate.title}"
        parts.append(
            f"## {title}\n\n![{title}](images/chapter/{plate.stem}.svg)\n\n"
            f"{plate.caption}\n\n*{plate.parameters}* `{plate.command}`\n"
        )
    rows = "".join(f"| {number} | {why} |\n" for number, why in LEFT_OUT.items())
    parts.append(f"## Not reproduced\n\n| figure | reason |\n| --- | --- |\n{rows}")
    return "\n".join(parts)


def main() -> None:
    FOLDER.mkdir(parents=True, exist_ok=True)
    names = {f"{plate.stem}.svg" for plate in PLATES}
    for old in FOLDER.glob("*.svg"):
        if old.name not in names:
            old.unlink()
    with tempfile.TemporaryDirectory() as scratch:
        for plate in PLATES:
            plate.write(Path(scratch))
            shutil.copy(Path(scratch, f"{plate.stem}.svg"), FOLDER)
    PAGE.write_text(page(), encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
