"""Which effects would be found on a plant, and from which size?"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from pvlib.location import Location
from pvlib.pvsystem import AbstractMount

from pvlib_fem._former_names import keys_in_new_names
from pvlib_fem._loop.close import finished_search
from pvlib_fem._loop.criteria import Criteria
from pvlib_fem._loop.preparation.planes import with_given
from pvlib_fem._loop.preparation.replacements import Replacements
from pvlib_fem._loop.progress import item_counter
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._loop.search import Search
from pvlib_fem._parallel import spread
from pvlib_fem._record.column_names import ALWAYS
from pvlib_fem._recovery.checkpoint import digest, in_plan, resumed, said_all
from pvlib_fem._recovery.draw import Draw, injectable_effects
from pvlib_fem._recovery.inject import Injector
from pvlib_fem._recovery.judge import recovered
from pvlib_fem._recovery.predict import predictions
from pvlib_fem._recovery.recovery_result import Recovery
from pvlib_fem._recovery.scramble import Scrambler
from pvlib_fem._recovery.trial import trial_of
from pvlib_fem.drivers import checked_place
from pvlib_fem.drivers._mounts import plane_of_rows
from pvlib_fem.effects import EffectLike
from pvlib_fem.types import FilePath

#: multiples of the predicted size
SIZES = (0.5, 1.0, 1.5, 2.0, 3.0)


def recover_effects(
    data: pd.DataFrame,
    effects: EffectLike | Iterable[EffectLike] | None = None,
    sizes: Sequence[float] | Mapping[str, Sequence[float]] = SIZES,
    draws: int = 3,
    seed: int = 0,
    model: str = "faiman",
    location: Location | None = None,
    surface_tilt: float | pd.Series | None = None,
    surface_azimuth: float | pd.Series | None = None,
    holdout: pd.Series | None = None,
    tried: EffectLike | Iterable[EffectLike] | None = None,
    check_units: bool = True,
    criteria: Criteria | None = None,
    fixed: Mapping[str, float] | None = None,
    processes: int | None = None,
    path: FilePath | None = None,
    progress: bool = True,
    reliability: bool = False,
    trials: int = 10,
    mount: AbstractMount | None = None,
    transposition: str | None = None,
    stand_ins: str | Iterable[str] = (),
) -> Recovery:
    """
    Add effects of known size to a measured record, and count how many the loop finds.

    The loop is closed on the record once; its findings are the *baseline*. The response
    of its last model to an effect is added to ``temp_module``, on the record's own
    steps, so that time constant and wind act as in reality. A fault of a sensor is
    added to the column of that sensor; power and second sensors do not change. Then the
    loop runs again with the same arguments, without knowledge of the injection.

    Parameters
    ----------
    data : DataFrame
        Record, see :func:`close_loop`.
    effects : str, Effect, or sequence of these, optional
        Effects to inject; by default all effects of the catalogue for which the record
        has the columns, and each sensor fault with each time profile. Effects of the
        baseline are not injected; ``notes`` list them.
    sizes : sequence of float, or dict of these, default (0.5, 1, 1.5, 2, 3)
        Multiples of the predicted size; or, by effect, sizes of its coefficient in its
        own unit (for several coefficients the root of the sum of their squares).
    draws : int, default 3
        Number of draws of dates and signs per effect. An effect without date and sign
        has one draw.
    seed : int, default 0
        Seed of the drawn dates, signs and scrambled records.
    model, location, surface_tilt, surface_azimuth, holdout, mount : optional
        See :func:`close_loop`.
    tried : str, Effect, or sequence of these, optional
        Effects that the loop tests, its ``effects``; by default all.
    check_units, criteria, fixed : optional
        See :func:`close_loop`.
    transposition, stand_ins : optional
        Make missing columns of others before anything is added, as
        :func:`transpose_record` and :func:`fill_record` do; see :func:`close_loop`. A
        fault of the irradiance sensor is then one in the plane of the module.
    processes : int, optional
        Number of parallel processes, by default the number of cores. The result does
        not depend on it.
    path : str or path-like, optional
        JSON file for the results so far, written after each injection. If it exists
        with the same record, arguments and version, only the missing part is computed.
    progress : bool, default True
        Show the progress.
    reliability : bool, default False
        Close the loop on scrambled records, too: a name of an effect that these have
        lost is false. With ``sizes=()`` there are no injections.
    trials : int, default 10
        Number of scrambled records of each kind.

    Returns
    -------
    Recovery

    Raises
    ------
    ValueError
        If the record is unusable, as in :func:`close_loop`; if the file of ``path``
        is of another record, version or call; if no effect can be injected; or if
        ``sizes`` or ``draws`` is none.

    Notes
    -----
    The predicted size is the smallest with which the loop would select the effect, or a
    set with it. The effect is added to the last model's remaining error, and a fault of
    a sensor to its cross-checks, with increasing size. The selection is run for each
    size, beginning with the record's own findings. The prediction does not include the
    refit.

    The record may contain the effect itself. That adds to its coefficient, and
    ``ratio`` and ``covered`` count it as error.

    **Reliability.** A scrambled record is the record without the information that a
    name needs. Whole days are moved, with the clocks that the loop corrected. There are
    two kinds:

    * *drivers moved*: all columns except irradiance, air and module temperature, wind
      speed, power and second sensors are taken from 1, 2, … years later, or run
      backwards from day to day. The record loses an effect that cannot be tested
      without a moved column, such as wind direction, rain, or a user's own column. It
      does not lose an effect with another variant, such as radiation to the sky by
      clouds of the day, nor one whose moved column still explains more than half of
      the variance of the original;
    * *dates scrambled*: each week of the year, or each quarter in every second record,
      is taken from a random year, with all columns. The record loses steps and drifts
      of sensors, and with weeks also episodes. Faults that the record itself shows are
      subtracted from ``temp_module`` before.

    Everything else remains true and is not counted: the model, the bias, longwave
    exchange, functions of irradiance, air, wind and sun. If ``f`` of ``n`` records that
    have lost an effect name it, its reliability is ``1 - f / n`` [2]_. A false set of
    causes has lost effects alone.

    References
    ----------
    .. [1] J. L. Christiansen et al., "Measuring Transit Signal Recovery in the Kepler
       Pipeline", Astrophys. J. Suppl. Ser. 207, 35, 2013: injection and recovery.
       :doi:`10.1088/0067-0049/207/2/35`
    .. [2] S. E. Thompson et al., "Planetary Candidates Observed by Kepler. VIII",
       Astrophys. J. Suppl. Ser. 235, 38, 2018: completeness and reliability of one
       catalogue, by injected, inverted and scrambled light curves.
       :doi:`10.3847/1538-4365/aab4f9`

    Examples
    --------
    >>> import pvlib_fem as fem
    >>> data = fem.simulator.record(days=100, step=3600)
    >>> recovery = fem.recover_effects(data, "module_offset_step", sizes=[3],
    ...                                processes=1, progress=False)
    >>> recovery.summary["found"].tolist()
    [1.0]
    """
    from pvlib_fem import __version__  # here, because of circular imports

    check_sizes(sizes, draws)
    criteria = criteria or Criteria()
    how: dict[str, Any] = dict(
        holdout=holdout, effects=tried, check_units=check_units, fixed=fixed
    )
    how |= {"criteria": criteria}
    place = checked_place(location, surface_tilt, surface_azimuth, mount)
    data, place = with_given(data, place)
    data = with_replacements(
        data, place, transposition, stand_ins, check_units, criteria
    )
    result = Recovery(
        given=said_all(effects, sizes, draws, seed, model, place, how),
        version=__version__,
        sha256=digest(data),
    )
    if path is not None and Path(path).exists():
        result = resumed(result, path)
    search, loop = finished_search(data, model, place, None, **how)
    wanted = (effects, sizes, draws, seed)
    planned, notes = planned_injections(search, loop, *wanted, processes, progress)
    if not planned and not reliability:
        reasons = "; ".join(f"{name}: {why}" for name, why in notes.items())
        raise ValueError(f"there is nothing to put into this record: {reasons}")
    keys = [injection.key for injection in planned]
    units = {
        effect.name: {name: row.unit for name, row in effect.rows().items()}
        for effect in search.case.wanted
    }
    result = replace(
        result,
        outcomes=in_plan(result.outcomes, keys),
        planned=len(planned),
        baseline=loop.finding_objects,
        units=units,
        notes=notes,
    )
    done = {outcome.key for outcome in result.outcomes}
    tasks = [(injection,) for injection in planned if injection.key not in done]
    how |= {"model": model, **place}
    injector = Injector.from_loop(search, loop)
    shared: tuple = (data, injector, loop.finding_objects, how)
    with item_counter(len(planned), len(done), progress, "put in") as report:
        for outcome in spread(recovered, tasks, processes, shared):
            outcomes = in_plan([*result.outcomes, outcome], keys)
            result = replace(result, outcomes=outcomes)
            if path is not None:
                result.to_json(path)
            report(outcome.injection.effect)
    if not reliability:
        return result
    scrambler = Scrambler.from_loop(search, loop, injector, data, holdout)
    kinds, why = scrambler.kinds()
    kept = [(kind, number) for kind in kinds for number in range(trials)]
    result = replace(
        result,
        trials=in_plan(result.trials, kept),
        planned_trials=len(kept),
        not_scrambled=why,
    )
    ready = {trial.key for trial in result.trials}
    tasks = [key for key in kept if key not in ready]
    shared = (scrambler, how, seed)
    with item_counter(len(kept), len(ready), progress, "scrambled") as report:
        for trial in spread(trial_of, tasks, processes, shared):
            result = replace(result, trials=in_plan([*result.trials, trial], kept))
            if path is not None:
                result.to_json(path)
            report(trial.what)
    return result


def check_sizes(sizes: Any, draws: int) -> None:
    """Refuse sizes that are no sequences, and no draws."""
    for some in sizes.values() if isinstance(sizes, Mapping) else [sizes]:
        if np.ndim(some) != 1:
            raise ValueError(f"sizes has {some!r}; give a sequence of numbers")
    if draws < 1:
        raise ValueError(f"draws = {draws}; give 1 or more")


def with_replacements(
    data: pd.DataFrame,
    place: dict,
    transposition: Any,
    stand_ins: Any,
    check_units: bool,
    criteria: Criteria,
) -> pd.DataFrame:
    """The record with missing columns made of others, if that is wanted."""
    if not transposition and not stand_ins:
        return data
    instead = Replacements.of_arguments(transposition, stand_ins)
    plane = plane_of_rows(data, place)
    filled = instead.filled(data, ALWAYS, plane, criteria.limits, check_units)
    return data.drop(columns=list(data)).assign(**filled.columns)


def planned_injections(
    search: Search,
    loop: Loop,
    effects: Any,
    sizes: Any,
    draws: int,
    seed: int,
    processes: int | None = 1,
    progress: bool = False,
) -> tuple[list, dict]:
    """All injections in order, and reasons for effects that cannot be injected."""
    step, injections = search.steps[loop.last], []
    if not len(sizes):
        return [], {}
    ready, notes = injectable_effects(search.case, loop, effects)
    if isinstance(sizes, Mapping):
        sizes = keys_in_new_names(sizes)
        if unknown := {*sizes} - {effect.name for effect in ready}:
            name = min(unknown)
            why = notes.get(name, "it is not among the effects that are put in")
            raise ValueError(f"sizes has {name}: {why}")
        ready = [effect for effect in ready if effect.name in sizes]
    shared = (search.case, search.last, step, draws, seed)
    tasks = [(effect,) for effect in ready]
    looked = spread(predictions, tasks, processes, shared)
    with item_counter(len(tasks), 0, progress, "predicted") as report:
        for effect, (looks, why) in zip(ready, looked):
            report(effect.name)
            if why is not None:
                notes[effect.name] = str(why)
            for draw, *known in looks:
                injections += injections_of_sizes(*[draw, *known, sizes, notes])
    return injections, notes


def injections_of_sizes(
    draw: Draw, predicted: float, own: float, sizes: Sequence | dict, notes: dict
) -> Any:
    """Injections of a draw with all possible sizes."""
    name, most = draw.effect.name, draw.most
    if isinstance(sizes, Mapping):
        wanted = sizes[name]
    elif np.isnan(predicted):
        notes[f"{name}, draw {draw.number}"] = (
            "no size that it can have should be found"
        )
        return
    else:
        wanted = [times * predicted for times in sizes]
    for size in wanted:
        if 0.0 < size <= most:
            yield draw.of_size(size, predicted, own)
        else:
            notes[f"{name}, draw {draw.number}"] = (
                f"a size of {size:.3g} is not possible, it has more than 0 and at most "
                f"{most:.3g}"
            )
