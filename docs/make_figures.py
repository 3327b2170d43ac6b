"""Draw the chapter's figures for the documentation again: python docs/make_figures.py"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from microslip.chapter import LEFT_OUT, PLATES

PAGE = Path(__file__).with_name("figures.md")
FOLDER = Path(__file__).with_name("images") / "chapter"

HEAD = """\
# The chapter's figures

The figures of chapter 19 of *The Mechanics of Jointed Structures*
([doi:10.1007/978-3-319-56818-8_19](https://doi.org/10.1007/978-3-319-56818-8_19)), all but one
photograph, drawn from this library; at the end some that the chapter has not. Its axes carry no
numbers in its text, so each figure states what it assumes. Where the chapter shows measurements
(19.6, 19.7, 19.22) these are synthetic, and say so. One command draws them all, as SVG and PNG,
each with its data as CSV (the sketches have none); `--only` draws some of them:

```sh
microslip figures -o figures
microslip figures --only 19.13 --only 19.14 -o loops
```

What differs from the chapter is said in [misprints.md](misprints.md).
`python docs/make_figures.py` makes this page.
"""


def page() -> str:
    """The page, from what the figures say of themselves."""
    parts = [HEAD]
    for plate in PLATES:
        number = f"Fig. {plate.number}: " if plate.number[0].isdigit() else ""
        title = number + plate.title
        parts.append(
            f"## {title}\n\n![{title}](images/chapter/{plate.stem}.svg)\n\n"
            f"{plate.caption}\n\n*{plate.parameters}* `{plate.command}`\n"
        )
    rows = "".join(f"| {number} | {why} |\n" for number, why in LEFT_OUT.items())
    parts.append(f"## Left out\n\n| figure | why |\n| --- | --- |\n{rows}")
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
