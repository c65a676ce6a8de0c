"""Every threshold by which the loop decides, in one place."""

import inspect
import re
from dataclasses import dataclass, field

from pvlib_fem.quality.limits import Limits

#: stages in the order in which the loop goes through them
STAGES = (
    "record",
    "weeks",
    "weighing",
    "scan",
    "naming",
    "classes",
    "structure",
    "confirming",
)


@dataclass(frozen=True, kw_only=True)
class Criteria:
    """
    Every threshold by which :func:`pvlib_fem.close_loop` decides.

    A change is made by ``Criteria(chance=0.01)`` and given as ``criteria=``. What
    each does, halved and doubled, to the records of the study is in
    :doc:`/sensitivity`.

    Attributes
    ----------
    enough_days : int
        *record.* Days that count, below which no cause is named and nothing is
        added: on noise alone 1 in 30 records of 90 days and 10 in 60 of 45 days
        showed an effect. [days]
    most_missing : float
        *record.* Share of a driver's rows that may lack; above it the driver is
        not used. [-]
    leak : float
        *record.* Share of a column's variance that the measured temperature leaves,
        below which the column is made from it and is not used. [-]
    leak_beyond : float
        *record.* The same, of what the model and the usual columns leave: a column
        that those foretell as well is no leak. [-]
    leak_same : float
        *record.* Share by which a column may follow the model's part of the temperature
        otherwise than what the model leaves, and still be made from the whole; with its
        error. Causes follow the two by −20 to 3 times each other. [-]
    leak_sure : float
        *record.* Standard errors by which it has to follow what the model leaves. [-]
    search_step : float
        *record.* Step on which effects are searched, half of the shortest time
        constants; fits end on the record's own. [s]
    step_present : float
        *record.* Share of such a step's rows that have to be there. [-]
    unseen_clock : float
        *record.* Time by which the module's clock may be off unseen, beyond which
        that is said. [s]
    test_every, choose_every : int
        *weeks.* One of this many weeks is a test week, and one of this many of
        the others a choosing week. [weeks]
    fewest_weeks : int
        *weeks.* Weeks below which days take their place: every other day is a
        test day. [weeks]
    fewest_fitting_days : int
        *weeks.* Fitting days below which none can be left out in turn, so that no
        effect is weighed. [days]
    folds : int
        *weighing.* Groups of fitting weeks that are left out in turn. [-]
    fewest_clusters : int
        *weighing.* Weeks below which errors come from the spread between days.
        [weeks]
    min_gain : float
        *weighing.* Gain that is worth an effect: root of the fall of the mean
        square on fitting weeks left out in turn. A third of the 0.4 K of a
        contact sensor. Of what has a driver, or a date, it counts beside what is in
        the model; in the end it is asked of all that is told. [K]
    min_share : float
        *weighing.* The same, as a share of the mean square that is left. [-]
    chance : float
        *weighing.* Chance that any of the family of hypotheses looks as good by
        accident. [-]
    power : float
        *weighing.* Chance to see an effect of the minimum detectable size. [-]
    bound_slack : float
        *weighing.* Share of a bound by which the tangent's coefficient may miss
        it, since a tangent is bent where an effect is large; a refit may not. [-]
    bound_errors : float
        *weighing.* Standard errors by which it may miss a bound. [-]
    rounds : int
        *weighing.* Times that all effects are weighed anew beside those that were
        found. [-]
    hint_gain : float
        *naming.* Gain from which an effect that was not added is told as a hint.
        [K]
    rival, tied : float
        *classes.* A candidate of this share of the best one's mean square is a
        rival; beside it, the best is tied if less than ``tied`` of its own mean
        square is left. A change of an instrument that keeps less beside the
        confounders is none. [-]
    confounder_rival, confounder_tied : float
        *classes.* The same of confounders, which the sun drives all alike. [-]
    structure_keeps : float
        *structure.* Share of its mean square that an effect has to keep beside a
        table of unknown structure that explains more, and an effect with a driver
        beside the confounders; one that keeps less has to be material beside them. [-]
    structure_left : float
        *structure.* Share of a table's mean square that may be left beside an
        effect which explains it. [-]
    structure_spill : float
        *structure.* Share of a table's mean square that an effect has to exceed
        afterwards, since a table does not say all of the unknown. [-]
    most_structures : int
        *structure.* Tables that are set aside, or told, in one round. [-]
    episode_chance : float
        *structure.* Chance that noise shows any day or stretch of days that stands
        out, if its tails are as heavy as exponential ones at most: of 7200 series of
        normal noise with a memory of 0 to 95 % from day to day (60 days to 8 years)
        5 showed one. [-]
    cell_time : float
        *structure.* Time over which rows share a cell of a table. [s]
    driver_bins : int
        *structure.* Bins of a driver, with equal numbers of rows. [-]
    cell_weight : float
        *structure.* Time's worth of rows by which a cell's mean is shrunk towards
        zero. [s]
    pair_gain : float
        *structure.* A table of two drivers has to take this many times as much of
        the mean square as that of one. [-]
    better_gain : float
        *structure.* The same of a later table beside an earlier one. [-]
    fold_share : float
        *structure.* Share of the groups of weeks in which a table has to gain. [-]
    strong_cell : float
        *structure.* Share of the largest mean from which a cell is part of the
        place that is told. [-]
    place_share : float
        *structure.* Share of those cells' squares that the told range holds. [-]
    dark : float
        *structure.* Irradiance up to which rows are in the night's own bin. [W/m²]
    weekend_days : int
        *structure.* Days below which weekends are not told from the week: two of
        each. [days]
    timetable_chance : float
        *structure.* Chance that noise keeps any timetable of days, and the same of
        minutes, before it has to be material: of 2325 series of fifteen kinds of
        noise (white, of hours' to weeks' memory, of sun, weather, shade, episodes;
        90 to 730 days) 3 showed one of days and 4 one of minutes. [-]
    timetable_days : int
        *structure.* Longest timetable of days. [days]
    timetable_repeats : int
        *structure.* Times that a timetable of days has to come again. [-]
    timetable_longest : float
        *structure.* Longest timetable of minutes: longer ones are the day's. [s]
    timetable_steps : int
        *structure.* Steps of the record in the shortest one. [-]
    timetable_trend : int
        *structure.* Days over which the mean of each time of day is taken off
        before one of minutes is looked for: what comes back to the same time
        within these days is the hour's. [days]
    timetable_lines : int
        *structure.* Lines of the spectrum whose median is the noise of the one in
        their middle. [-]
    timetable_phases : int
        *structure.* Phases by which a timetable of minutes is told. [-]
    timetable_bins : int
        *structure.* Bins that its phases are joined to: on, off and what a module's
        memory makes of them; a table with the hour has few rows in each cell. [-]
    timetable_multiples : int
        *structure.* Times its strongest line's period that one may be. [-]
    timetable_gain : float
        *structure.* Held-out gain that a timetable has alone at least: a third of
        what is worth an effect, since an hour or a driver beside it adds to that.
        Edges of sun and shade that wander through the year leave less. [K]
    most_timetables : int
        *structure.* Timetables of days that are tried beside each other. [-]
    window_azimuth, window_elevation : float
        *scan.* Cells of the sky in which windows of shade are looked for; the sun
        crosses one in ten minutes. [°]
    window_share : float
        *scan.* Share of the beam that a window has to take, since less is no
        obstacle. [-]
    window_most : float
        *scan.* Share of the beam that it can take at most: all, and what the beam
        by irradiance in the plane is too small by. [-]
    window_errors : float
        *scan.* Standard errors, by the spread between weeks, that its share has to be
        from nothing: more than elsewhere, for it is the best of thousands. [-]
    most_windows : int
        *scan.* Rectangles of which an obstacle, or several, are made; each has to
        take ``hint_gain``. [-]
    change_chance : float
        *scan.* Chance that noise shows any date at which a channel changes, and that
        any of the changes that are tried looks as good. [-]
    change_side : int
        *scan.* Days with rows that there have to be before a date and after it, and
        of an episode: fewer cannot be left out in turn. [days]
    sure : float
        *confirming.* Standard errors that a coefficient of the refit has to be
        from nothing. [-]
    contradiction : float
        *confirming.* Standard errors by which a refit may raise the mean square
        of the choosing weeks, and not be withdrawn. [-]
    limits : Limits
        Thresholds of what is checked of sensors and clocks before any fit.
    """

    enough_days: int = 60
    most_missing: float = 0.2
    leak: float = 0.05
    leak_beyond: float = 0.5
    leak_same: float = 0.15
    leak_sure: float = 5.0
    search_step: float = 300.0
    step_present: float = 0.5
    unseen_clock: float = 120.0

    test_every: int = 5
    choose_every: int = 4
    fewest_weeks: int = 5
    fewest_fitting_days: int = 10

    folds: int = 5
    fewest_clusters: int = 8
    min_gain: float = 0.15
    min_share: float = 0.015
    chance: float = 0.05
    power: float = 0.8
    bound_slack: float = 0.35
    bound_errors: float = 2.0
    rounds: int = 3

    hint_gain: float = 0.10

    rival: float = 0.6
    tied: float = 0.15
    confounder_rival: float = 0.35
    confounder_tied: float = 0.4

    structure_keeps: float = 0.5
    structure_left: float = 0.4
    structure_spill: float = 0.1
    most_structures: int = 3
    episode_chance: float = 0.01
    cell_time: float = 900.0
    driver_bins: int = 10
    cell_weight: float = 43200.0
    pair_gain: float = 1.2
    better_gain: float = 1.02
    fold_share: float = 0.8
    strong_cell: float = 0.5
    place_share: float = 0.92
    dark: float = 1.0
    weekend_days: int = 14
    timetable_chance: float = 0.01
    timetable_days: int = 28
    timetable_repeats: int = 6
    timetable_longest: float = 43200.0
    timetable_steps: int = 3
    timetable_trend: int = 21
    timetable_lines: int = 101
    timetable_phases: int = 60
    timetable_bins: int = 6
    timetable_multiples: int = 4
    timetable_gain: float = 0.05
    most_timetables: int = 2

    window_azimuth: float = 2.0
    window_elevation: float = 1.0
    window_share: float = 0.1
    window_most: float = 1.5
    window_errors: float = 4.0
    most_windows: int = 8
    change_chance: float = 0.001
    change_side: int = 21

    sure: float = 3.0
    contradiction: float = 1.0

    limits: Limits = field(default_factory=Limits)

    @classmethod
    def stages(cls) -> dict[str, str]:
        """Name of each criterion to the stage that uses it, from the text above."""
        text = inspect.cleandoc(cls.__doc__ or "")  # indented before Python 3.13
        rows = re.findall(r"^([\w, ]+) : .*\n +\*(\w+)\.\*", text, re.M)
        return {name: stage for names, stage in rows for name in names.split(", ")}

    def __post_init__(self):
        for name, value in vars(self).items():
            if name != "limits" and not value > 0:
                raise ValueError(f"{name} = {value} must be more than 0")
