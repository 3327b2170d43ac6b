"""Pictures of a document, each made once, whoever asks for it."""

from __future__ import annotations

from microslip.report.document import Picture
from microslip.report.plot import Plot


class PictureCache:
    """Makes each picture once: the file and the page share it."""

    def __init__(self) -> None:
        self._plots: dict[str, Plot] = {}
        self._svgs: dict[str, bytes] = {}
        self._pngs: dict[str, bytes] = {}

    def _plot(self, picture: Picture) -> Plot:
        if picture.name not in self._plots:
            self._plots[picture.name] = picture.plot()
        return self._plots[picture.name]

    def as_bytes(self, picture: Picture, kind: str) -> bytes:
        """The picture in a format: "svg", "png" or "pdf"."""
        if kind == "pdf":  # asked for once, by its file
            from microslip.report import pdf

            return pdf(self._plot(picture))
        return self.svg(picture) if kind == "svg" else self.png(picture)

    def svg(self, picture: Picture) -> bytes:
        """The picture as lines and text."""
        if picture.name not in self._svgs:
            from microslip.report.svg import svg

            self._svgs[picture.name] = svg(self._plot(picture))
        return self._svgs[picture.name]

    def png(self, picture: Picture) -> bytes:
        """The picture as pixels."""
        if picture.name not in self._pngs:
            from microslip.report import png

            self._pngs[picture.name] = png(self._plot(picture))
        return self._pngs[picture.name]
