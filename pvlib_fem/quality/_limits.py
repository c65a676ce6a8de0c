"""Every threshold by which faults are found."""

from dataclasses import dataclass, fields

from pvlib_fem._record.ranges import RANGES

#: share of irradiance that a module gives: at its best not below 0.5 %, and never 40 %;
#: the best give a quarter, and sensors err
EFFICIENCY = 0.005, 0.4
#: over-temperature by irradiance: 15 to 40 K at 1000 W/m² on racks, 60 K on insulated
#: backs (King et al., 2004, SAND2004-3535), and what the coolest have [K m²/W]
GAIN = 0.008, 0.065
#: fastest change there and back: a front moves air by 20 K in ten minutes, and
#: 1000 W/m² a light module of 7 kJ/(m² K) by 0.15 K each second [K/s]
FASTEST = {"temp_air": 0.035, "temp_module": 0.15}
#: the four columns that every fit needs
POSSIBLE = {
    name: RANGES[name]
    for name in ("poa_global", "temp_air", "wind_speed", "temp_module")
}


@dataclass(frozen=True, kw_only=True)
class Limits:
    """
    Every threshold by which :func:`pvlib_fem.screen_record` and :func:`check` decide.

    A change is made by ``Limits(still_wind=43200.0)`` and given as ``limits=``. What
    they find, and what they find wrongly, is in :doc:`/quality`; what a column can hold
    at all is in ``pvlib_fem._record.ranges``.

    Attributes
    ----------
    few_share : float
        *all.* Share of rows up to which what is odd is an accident: values of another
        unit, rows years from all others, rows that are missing by day or present by
        night in a file of days alone, values below a calm. An unknown code has no more,
        since more is a state of what is measured, such as on. [-]
    few_rows : int
        *fill value, spike, stuck.* Rows that an accident may last: a value that jumps
        and returns, or stays; a code that nobody knows is there more often. [-]
    few_values : int
        *fill value, spike, end of range, units.* Values that a column needs to know
        itself: different ones, or it is a switch, and rows at the most that it reads,
        or that is no end. [-]
    far : float
        *fill value, spike.* Multiple of the largest other value, in size, from which a
        positive code is one in a column whose range is not known. Its square is needed
        of a value that repeats and is no known code, its cube of a lone one. [-]
    most_impossible : float
        *out of range.* Share of one of the four columns that may be impossible; with
        more the record is refused. [-]
    day_side : int
        *negative by day, light by night.* Days on either side that are compared. [days]
    sunny : float
        *negative by day, units.* Irradiance of a time of day that is light for sure, so
        that a negative value is not of the night, and a module gives power. [W/m²]
    lit_nights : float
        *light by night.* Share of the nights around up to which light at a time of
        night is an accident; with more it may be a clock that was set. [-]
    spike : float
        *spike.* Change of temperature there and back that may be noise, against the
        fastest of air and of modules. Of air twice as much within ``still_air`` is
        none: fronts do not return, and heat bursts reach 15 K. [K]
    end_days : int
        *end of range.* Days with rows at the most, or the least, that a column reads,
        from which its sensor's range may end there: what is measured is at its very
        most once. [days]
    still_chance : float
        *stuck.* Chance of a repetition, by how often its column keeps a value from row
        to row, below which that is no accident. [-]
    still_time : float
        *stuck, end of range.* Time in which a module has answered irradiance: up to it
        a repetition is no fault, and after it what was before is forgotten. It is five
        time constants. [s]
    still_air : float
        *stuck.* Time over which air moves a thermometer, or a module in the dark,
        which an evening's calm may not. [s]
    still_wind : float
        *stuck.* Time for which wind may repeat any speed but its lowest. [s]
    still_day : float
        *stuck.* Time for which irradiance may be 0, a module under melting snow at
        0 °C, and humidity, longwave, power and rain what they are, but where their
        sensors rest: a day, and the longest night outside the polar circles. [s]
    calm : float
        *stuck.* Time for which wind may stay at its lowest, where a cup anemometer
        does not start, and a vane in a trade wind; and after which a module, air and
        irradiance are stuck whatever they usually do. [s]
    warmed : float
        *stuck.* Change of module or over-temperature that takes a change of irradiance,
        some 300 W/m². [K]
    temp_slack : float
        *stuck.* Difference of temperatures that tells nothing: of the air that a module
        need not answer, in addition to twice the resolution of both, and from 0 °C
        where snow melts. [K]
    light : float
        *noon, stuck, light by night.* Irradiance above which there is light, above what
        a pyranometer reads at night. [W/m²]
    bright : float
        *noon, stuck.* Irradiance that a day has to reach, to have clear edges; and the
        change of it that a module must answer, by 2 to 6 K at the 20 to 60 mK/(W/m²)
        of all mountings. [W/m²]
    shortest_record : float
        *clock, noon.* Time below which no clock is looked at: two days and the
        night between. [s]
    coarsest_clock : float
        *clock.* Step of the rows above which the onset of an answer does not show,
        since it is half over within it. [s]
    coarsest : float
        *clock, noon.* Step of the rows up to which the step shows in which an answer
        begins, and a jump of the noon by an hour. [s]
    lag_left, lag_next : float
        *clock.* Share of what no lag leaves of the changes from row to row, below
        which another lag's has to be, and one that is but a step off: that may be by
        half where rows hold means of one column and ends of the other. [-]
    lag_share : float
        *clock.* Share of those changes that it has to explain: what irradiance
        hardly moves is no module. [-]
    farthest_clock : float
        *clock, stuck.* Time around such a lag, or none, within which the onset is
        looked for: two zones. [s]
    sensor_slack : float
        *clock.* Time beyond one sample by which contact sensors and averaging may
        differ, and the error of an onset that tells anything: contact sensors answer
        within 10 to 60 s. [s]
    clear_peak : float
        *clock.* Height of a correlation over its own scatter, from which clouds
        show when an answer begins. [-]
    block_number : int
        *clock.* Blocks into which a record is divided if it is long enough. [-]
    longest_block : int
        *clock.* Length of a block at most; over longer ones a drift of 7 s a day is
        lost in them. [days]
    block_error : float
        *clock.* What a block's own error may leave out, of the shape of the answer.
        [s]
    sure : float
        *clock, noon.* Standard errors by which a fault has to differ from none; with
        few blocks Student's t of the same chance. Twice as many are required of a block
        beside the others. [-]
    sun_slack : float
        *noon, negative by day.* Time of day to which light alone tells it: what a
        turned plane, a horizon or averages of an hour may do to a noon, the least jump
        of it, and the parts of a day that are compared with other days. [s]
    noon_side : int
        *noon, light by night.* Days on each side of a jump that are compared; they may
        span four times as many, where some are missing. [days]
    noon_error : float
        *noon, clock.* What clouds leave in the noon of one day, at least; a jump is by
        whole hours within ``sure`` times that, and of a module's clock within it. [s]
    shortest_night : float
        *noon.* Dark time below which a day has no clear edges, as near the midnight
        sun. [s]
    stray_gap : float
        *times.* Gap between rows from which those on its one side are suspect. [s]
    """

    few_share: float = 0.02
    few_rows: int = 3
    few_values: int = 20
    far: float = 3.5
    most_impossible: float = 0.2
    day_side: int = 3
    sunny: float = 300.0
    lit_nights: float = 0.2
    spike: float = 12.0
    end_days: int = 5

    still_chance: float = 1e-9
    still_time: float = 1800.0
    still_air: float = 10800.0
    still_wind: float = 21600.0
    still_day: float = 86400.0
    calm: float = 259200.0
    warmed: float = 10.0
    temp_slack: float = 1.0
    light: float = 20.0
    bright: float = 100.0

    shortest_record: float = 129600.0
    coarsest_clock: float = 900.0
    coarsest: float = 3600.0
    lag_left: float = 0.8
    lag_next: float = 0.5
    lag_share: float = 0.3
    farthest_clock: float = 7200.0
    sensor_slack: float = 30.0
    clear_peak: float = 5.0
    block_number: int = 8
    longest_block: int = 14
    block_error: float = 3.0
    sure: float = 3.0
    sun_slack: float = 1800.0
    noon_side: int = 10
    noon_error: float = 300.0
    shortest_night: float = 10800.0
    stray_gap: float = 31622400.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not value > 0:
                raise ValueError(f"{field.name} = {value} must be more than 0")
