"""Reading of a study file, with a one-line error for invalid content."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any, Self

from microslip._core.checks import show
from microslip._core.errors import StudyError
from microslip._core.wording import shorten
from microslip.contact import NormalLaw
from microslip.study.consistency import check_consistency, mean_load
from microslip.study.joints import Joint
from microslip.study.metals import with_metals
from microslip.study.pressure import set_clamped_materials
from microslip.study.readers import KeyedError, Place
from microslip.study.schema import StudyTables
from microslip.study.structure import StructurePart
from microslip.study.toml_text import apply, dump, read_text, relocated_text, tables_of


class StudyDescription(StudyTables):
    """Validated content of a study, before anything is computed."""

    _name: str = "study"
    _text: str | None = None
    _tables: dict[str, Any]
    _notes: tuple[str, ...] = ()
    _folder: Path = Path()
    _law: NormalLaw | None = None  # drawn, in place of the surface's own

    def __init__(self, /, **tables: Any) -> None:
        self._fill(tables)

    def _fill(
        self,
        tables: dict[str, Any],
        name: str = "study",
        folder: Path | None = None,
        notes: Sequence[str] = (),
    ) -> None:
        """Validate tables as read from a file, and set the attributes of this empty study."""
        place = Place("", folder, [*notes])
        try:
            with place.located():
                read = self.read(with_metals(tables, place.notes), place)
        except KeyedError as error:
            where = f"{error.key}: " if error.key else ""
            raise StudyError(f"{name}: {where}{error}") from None
        self.__dict__.update(read.__dict__)
        self._name = name
        self._tables = tables
        self._folder = folder or Path()
        self._notes = tuple(place.notes)

    def check(self, place: Place) -> None:
        """Set the default load, and reject invalid combinations of tables."""
        self.settle()
        if isinstance(self.joint, Joint) and not self.joint.normal_load:
            self.__dict__["joint"] = self.joint.copy(normal_load=(mean_load(self),))
        check_consistency(self)

    def settle(self) -> None:
        """Copy the elastic moduli of the plates to the bolts that clamp them."""
        set_clamped_materials(self)

    @property
    def bolted(self) -> StructurePart:
        """Structure of a study; only valid if the study has one."""
        assert self.structure is not None
        return self.structure

    @property
    def reports_joint(self) -> bool:
        """Whether a study with a structure also requests cycles of the joint alone."""
        joint = self._tables.get("joint", {})
        return self.structure is None or "normal_load" in joint or "excitation" in self._tables

    @property
    def name(self) -> str:
        """Name of the file, used in messages."""
        return self._name

    @property
    def text(self) -> str:
        """TOML text with overrides applied and comments kept."""
        if self._text is None:
            self._text = dump(self._tables)
        return self._text

    def text_for(self, folder: str | Path) -> str:
        """Return the study as TOML for a file in another folder, with adapted relative paths.

        Parameters
        ----------
        folder : str or pathlib.Path
            Folder of the new file.

        Returns
        -------
        str
            The :attr:`text` with relative paths that are valid in that folder.
        """
        return relocated_text(self.text, self._folder, Path(folder))

    @property
    def notes(self) -> tuple[str, ...]:
        """Sources of the values of the study, such as tables, files and overrides."""
        return self._notes

    @classmethod
    def load(cls, path: str | Path, overrides: Sequence[str] = ()) -> Self:
        """Read a study file (TOML).

        Parameters
        ----------
        path : str or pathlib.Path
            Study file. Relative paths in it refer to its folder.
        overrides : sequence of str
            Values that replace those in the file, such as ``'joint.normal_load="3 kN"'``. A
            value that is not valid TOML is taken as text.

        Returns
        -------
        Study
            The validated study, in SI units.
        """
        if not isinstance(path, (str, PathLike)):
            raise StudyError(f"`path` must be the name of a study file, got {show(path)}")
        path = Path(path)
        name = shorten(str(path), 200)
        try:
            text = read_text(path)
        except ValueError as error:
            raise StudyError(f"{name}: {error}") from None
        return cls.from_toml(text, name, overrides, path.parent)

    @classmethod
    def from_toml(
        cls,
        text: str,
        name: str = "study",
        overrides: Sequence[str] = (),
        folder: str | Path | None = None,
    ) -> Self:
        """Read a study from TOML text.

        Parameters
        ----------
        text : str
            Content of a study file.
        name : str
            Name of the study in messages.
        overrides : sequence of str
            As in :meth:`load`.
        folder : str or pathlib.Path, optional
            Folder to which relative paths refer; by default the current one.

        Returns
        -------
        Study
            The validated study, in SI units.
        """
        try:
            data = tables_of(text)
        except ValueError as error:
            raise StudyError(f"{name}: {error}") from None
        if not data:
            raise StudyError(
                f"{name}: wanted a study, got none; microslip new NAME.toml writes one"
            )
        notes: list[str] = []
        if overrides:
            try:
                text, data, notes = apply(overrides, text, data)
            except StudyError as error:
                raise StudyError(f"{name}: {error}") from None
        study = cls.__new__(cls)
        study._fill(data, name, None if folder is None else Path(folder), notes)
        study._text = text
        return study
