"""From a frame to a fit or a loop."""

import sys
from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd

from pvlib_fem._cli.printing import waiting
from pvlib_fem._fit import fit_fem, fit_frame
from pvlib_fem._fitting.fem_fit import FemFit
from pvlib_fem._loop.close import close_loop
from pvlib_fem._loop.progress import progress_line
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._record.parquet import ParquetRecord
from pvlib_fem._recovery.recover import recover_effects
from pvlib_fem._recovery.recovery_result import Recovery
from pvlib_fem.effects import EffectLike, find


def loop_of_frame(
    data: pd.DataFrame | ParquetRecord,
    model: str = "faiman",
    no_unit_check: bool = False,
    site: Mapping[str, Any] | None = None,
    ceiling: bool = False,
    **options: Any,
) -> Loop:
    """
    The loop of a frame, with its progress on a terminal.

    Parameters
    ----------
    data : DataFrame or ParquetRecord
    model : str, default "faiman"
    no_unit_check : bool, default False
    site : dict, optional
        ``location``, ``surface_tilt``, ``surface_azimuth`` and ``mount``.
    ceiling : bool, default False
        Compute the ceiling, too.
    **options
        Further ones of :func:`pvlib_fem.close_loop`.

    Returns
    -------
    Loop
    """
    with progress_line() as bar:
        loop = close_loop(
            data,
            model,
            **(site or {}),
            **options,
            check_units=not no_unit_check,
            progress=bar.set_description_str,
        )
        if ceiling:
            bar.set_description_str("growing trees")
            loop.ceiling()
        return loop


def recovery_of_frame(
    data: pd.DataFrame,
    no_unit_check: bool = False,
    site: Mapping[str, Any] | None = None,
    **options: Any,
) -> Recovery:
    """
    What is found of effects that are put into a frame.

    Parameters
    ----------
    data : DataFrame
        Record with the package's names.
    no_unit_check : bool, default False
        Accept columns that look to be in another unit.
    site : dict, optional
        ``location``, ``surface_tilt``, ``surface_azimuth`` and ``mount``.
    **options
        Further ones of :func:`pvlib_fem.recover_effects`.

    Returns
    -------
    Recovery
    """
    return recover_effects(
        data,
        **(site or {}),
        **options,
        check_units=not no_unit_check,
        progress=sys.stderr.isatty(),
    )


def fit_of_frame(
    data: pd.DataFrame,
    effects: Iterable[EffectLike],
    site: Mapping[str, Any],
    no_unit_check: bool = False,
    **options: Any,
) -> FemFit:
    """
    The fit of a frame.

    Parameters
    ----------
    data : DataFrame
        Record with the package's names.
    effects : iterable of str, dict or Effect
        Effects that the model has.
    site : dict
        ``location``, ``surface_tilt``, ``surface_azimuth`` and ``mount``.
    no_unit_check : bool, default False
        Accept columns that look to be in another unit.
    **options
        Further ones of :func:`pvlib_fem.fit_fem`, ``transposition`` and ``stand_ins``.

    Returns
    -------
    FemFit
    """
    options["check_units"] = not no_unit_check
    with waiting("fitting …"):
        return fit_frame(data, effects, **site, **options)


def fitted_files(
    record: ParquetRecord,
    effects: Iterable[EffectLike],
    no_unit_check: bool = False,
    **options: Any,
) -> FemFit:
    """
    The fit of Parquet files that follow each other.

    Parameters
    ----------
    record : ParquetRecord
        Opened files.
    effects : iterable of str, dict or Effect
        Effects that the model has.
    no_unit_check : bool, default False
        Accept columns that look to be in another unit.
    **options
        Further ones of :func:`pvlib_fem.fit_fem`.

    Returns
    -------
    FemFit
    """
    effects = [find(one) for one in effects]
    options["check_units"] = not no_unit_check
    with waiting("fitting, part by part …"):
        return fit_fem(record, effects=effects, **options)
