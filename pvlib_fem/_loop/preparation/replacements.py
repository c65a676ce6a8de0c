"""Replacements for columns that are missing from a record."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import pandas as pd

from pvlib_fem._fitting.horizontal import files_in_plane, with_plane
from pvlib_fem._fitting.stand_ins import StandIn, stand_in_names, with_stand_ins
from pvlib_fem._record.column_names import with_aliases
from pvlib_fem._record.parquet import ParquetRecord
from pvlib_fem.drivers._transposition import PARTS
from pvlib_fem.quality._limits import Limits

LEVEL: dict[str, Any] = {"surface_tilt": 0.0, "surface_azimuth": 180.0, "mount": None}


@dataclass(frozen=True)
class Replacements:
    """Replacements that a user wants for columns that are missing from a record."""

    #: model of the sky by which ``poa_global`` is made of ``ghi``; "" without
    transposition: str = ""
    #: second sources of air and wind that fill the first
    stand_ins: tuple[str, ...] = ()
    #: whether wind that never moves is taken as not measured, which no model needs
    calm: bool = False

    @classmethod
    def of_arguments(
        cls,
        transposition: str | None,
        stand_ins: str | Iterable[str],
        calm: bool = False,
    ) -> Self:
        """The replacements by the arguments of :func:`close_loop`."""
        return cls(transposition or "", tuple(stand_in_names(stand_ins).values()), calm)

    @property
    def arguments(self) -> dict[str, Any]:
        """The arguments of a call that are no default."""
        given = {"transposition": self.transposition, "stand_ins": self.stand_ins}
        return {name: value for name, value in given.items() if value}

    def filled(
        self,
        data: pd.DataFrame,
        needed: Sequence[str],
        site: dict[str, Any],
        limits: Limits | None,
        check_units: bool,
        check_clock: bool = True,
    ) -> "Filled":
        """
        The columns of a frame with the replacements, and notes on these.

        It is refused without the ``needed`` columns, and if checked with a unit or a
        clock that cannot be.
        """
        columns, notes = with_aliases(data, ()), ()
        standing: tuple[StandIn, ...] = ()
        horizontal: np.ndarray | None = None
        if self.calm and "wind_speed" in columns:
            columns, notes = without_still_wind(columns)
        if not (self.transposition or self.stand_ins or notes):
            return Filled(with_aliases(data, needed))
        if self.stand_ins:
            columns, standing, more = with_stand_ins(columns, self.stand_ins, limits)
            notes = (*notes, *more)
        if self.transposition:
            measured = "poa_global" in columns
            sky = data.index, site, self.transposition, limits
            columns, more = with_plane(columns, *sky, check_units, check_clock)
            notes = (*notes, *more)
            if not measured:
                # poa_global is made of these: they are no causes in addition to it
                light = {n: columns.pop(n) for n in ("ghi", *PARTS) if n in columns}
                horizontal = light["ghi"].to_numpy()
        frame = data.drop(columns=list(data)).assign(**columns)
        return Filled(with_aliases(frame, needed), notes, horizontal, standing)

    def of_files(
        self, source: ParquetRecord, place: dict[str, Any], limits: Limits
    ) -> tuple[ParquetRecord, dict[str, Any]]:
        """Files with the replacements, and these as fields of a :class:`Loop`."""
        transposed = bool(self.transposition) and "poa_global" not in source.columns
        if transposed:
            source = files_in_plane(source, place, self.transposition, limits)
        standing = []
        for usual, name in stand_in_names(self.stand_ins).items():
            source = instead_of(source, usual, name)
            standing.append(StandIn(usual, name))
        sky = self.transposition if transposed else ""
        return source, {"transposition": sky, "stand_ins": tuple(standing)}


NOTHING = Replacements()


def instead_of(source: ParquetRecord, usual: str, name: str) -> ParquetRecord:
    """Files in which another column is the usual one, which they do not have."""
    if usual in {*source.columns, *source.partial}:
        raise ValueError(
            f"the files have {usual}, whose gaps {name} cannot fill while they are "
            "read in blocks; fill them before with fill_record(part, "
            f"{name!r}), or leave stand_ins out"
        )
    source.needing([name])
    columns = {n: c for n, c in source.columns.items() if n != name}
    words = f"there is no {usual}: {name} stands in for it"
    return replace(
        source,
        columns=columns | {usual: source.columns[name]},
        notes=(*source.notes, words),
    )


def without_still_wind(
    columns: dict[str, pd.Series],
) -> tuple[dict[str, pd.Series], tuple[str, ...]]:
    """Columns without wind that never moves, and a note on that."""
    wind = columns["wind_speed"].dropna().to_numpy()
    if (wind[1:] != wind[:-1]).any():
        return columns, ()
    rest = {name: column for name, column in columns.items() if name != "wind_speed"}
    words = "wind_speed never moves: it is taken as not measured"
    return rest, (words,)


@dataclass(frozen=True, eq=False)
class Filled:
    """Columns with the replacements of missing ones."""

    columns: dict[str, pd.Series]
    notes: tuple[str, ...] = ()
    horizontal: np.ndarray | None = None  # irradiance that was transposed [W/m²]
    standing: tuple[StandIn, ...] = ()

    def plane(self, site: dict[str, Any]) -> dict[str, Any]:
        """The site with the plane in which irradiance was measured."""
        return site if self.horizontal is None else {**site, **LEVEL}
