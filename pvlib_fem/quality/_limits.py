"""Every threshold by which faults are found."""

from dataclasses import dataclass, fields

from pvlib_fem._former_names import fields_in_new_names
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
#: of columns of which the others tell nothing: the limit of the time of a repetition
DRIVERS = {
    "wind_speed": "stale_wind_window",
    "relative_humidity": "stale_day_window",
    "longwave_down": "stale_day_window",
    "p_dc_per_area": "stale_day_window",
    "precipitation": "stale_day_window",
    "wind_direction": "stale_calm_window",
}


#: former names of thresholds
RENAMED = {
    "few_share": "max_accident_share",
    "few_rows": "max_accident_rows",
    "few_values": "min_known_values",
    "far": "min_fill_ratio",
    "most_impossible": "max_impossible_share",
    "day_side": "daylight_window",
    "sunny": "min_sunny_irradiance",
    "lit_nights": "max_lit_night_share",
    "spike": "min_spike",
    "end_days": "min_range_end_days",
    "still_chance": "max_stuck_chance",
    "still_time": "response_time",
    "still_air": "stale_air_window",
    "still_wind": "stale_wind_window",
    "still_day": "stale_day_window",
    "calm": "stale_calm_window",
    "warmed": "min_temperature_response",
    "temp_slack": "temperature_tolerance",
    "light": "min_light",
    "bright": "min_bright_irradiance",
    "shortest_record": "min_record",
    "coarsest_clock": "max_onset_step",
    "coarsest": "max_noon_step",
    "lag_left": "max_lag_error",
    "lag_next": "max_next_lag_error",
    "lag_share": "min_lag_share",
    "farthest_clock": "max_onset_shift",
    "sensor_slack": "onset_tolerance",
    "clear_peak": "min_peak_ratio",
    "block_number": "onset_blocks",
    "longest_block": "max_block_days",
    "block_error": "min_block_error",
    "sure": "min_standard_errors",
    "sun_slack": "daylight_tolerance",
    "noon_side": "noon_window",
    "noon_error": "min_noon_error",
    "shortest_night": "min_night",
    "stray_gap": "min_stray_gap",
}


@fields_in_new_names(RENAMED)
@dataclass(frozen=True, kw_only=True)
class Limits:
    """
    Every threshold by which :func:`pvlib_fem.screen_record` and :func:`check` decide.

    ``Limits(stale_wind_window=43200.0)`` changes one; give it as ``limits=``.
    :doc:`/quality` has what they find, and what they find wrongly. What a column can
    hold at all is in ``pvlib_fem._record.ranges``.

    Attributes
    ----------
    max_accident_share : float
        *All checks.* Largest share of rows that counts as an accident: values in
        another unit, rows years from all others, changes of a temperature from row to
        row that lead to no row of zeros, rows that are missing by day or
        present by night in a file of days alone, values below a calm. An unknown code
        in more rows is a state of what is measured, such as on. Of lone zeros as large
        a share may have been measured. [-]
    max_accident_rows : int
        *Fill value, lone zero, spike, stuck.* Most rows of one accident: a value that
        jumps and returns, or stays. A code that nobody knows has more rows, and so few
        zeros in a temperature need that no other reading was reached by such a jump.
        [-]
    min_known_values : int
        *Fill value, lone zero, spike, end of range, units.* Fewest values by which a
        column's range is known: different ones, else it is a switch; readings between
        a lone zero and those around it; and rows at the largest reading, else that is
        no end of a range. [-]
    min_fill_ratio : float
        *Fill value, spike.* Smallest ratio of a positive code to the largest other
        value, in size, in a column whose range is not known. A value that repeats and
        is no known code needs the square of it, a single one the cube. [-]
    max_impossible_share : float
        *Out of range.* Largest share of impossible values in one of the four columns
        that every fit needs; a record with more is refused. [-]
    daylight_window : int
        *Negative by day, light by night.* Days on each side that are compared. [days]
    min_sunny_irradiance : float
        *Negative by day, units.* Irradiance from which a time of day is light, so that
        a negative value is not of the night, and a module gives power. [W/m²]
    max_lit_night_share : float
        *Light by night.* Largest share of the nights around on which light at a time of
        night is an accident; with more, a clock may have been set. [-]
    min_spike : float
        *Spike.* Smallest change of temperature there and back that is no noise, in
        addition to the fastest change of air and of modules. For air it is twice as
        much within ``stale_air_window``: heat bursts reach 15 K, and fronts do not
        return. [K]
    min_range_end_days : int
        *End of range.* Fewest days with rows at the largest, or smallest, reading from
        which the sensor's range may end there: weather reaches its extreme once.
        [days]
    max_stuck_chance : float
        *Stuck, units.* Largest chance of a repetition that is no accident, by how often
        the column keeps a value from row to row; and of rain that falls so seldom from
        row to row, since a counter alone does. [-]
    response_time : float
        *Stuck, end of range.* Time in which a module has responded to irradiance, five
        time constants. A shorter repetition is no fault, and older rows have no
        influence. [s]
    stale_air_window : float
        *Stuck, lone zero.* Longest time without a change of the air temperature, or of
        a module in the dark; calm evenings are shorter. Values further apart do not
        tell what was in between. [s]
    stale_wind_window : float
        *Stuck.* Longest time without a change of wind above its lowest speed. [s]
    stale_day_window : float
        *Stuck.* Longest time with irradiance 0, with a module under melting snow at
        0 °C, and without a change of humidity, longwave irradiance, power and rain:
        a day, and the longest night outside the polar circles. [s]
    stale_calm_window : float
        *Stuck.* Longest time with wind at its lowest speed, where a cup anemometer does
        not start, and with one wind direction, as in a trade wind; and the time after
        which module, air and irradiance are stuck whatever they usually do. [s]
    min_temperature_response : float
        *Stuck.* Smallest change of module temperature, or of its rise over air, that
        needs a change of irradiance, of some 300 W/m². [K]
    temperature_tolerance : float
        *Stuck, lone zero, all zero.* Difference of temperatures without meaning: of the
        air, to which a module need not respond, in addition to twice the resolution of
        both; from 0 °C, where snow melts; and from a row in which all columns are 0, in
        addition to the column's own changes. [K]
    min_light : float
        *Noon, stuck, light by night.* Irradiance from which there is light, above what
        a pyranometer reads at night. [W/m²]
    min_bright_irradiance : float
        *Noon, stuck, lone zero.* Irradiance that a day has to reach for clear edges;
        the change of it to which a module must respond, by 2 to 6 K at the 20 to
        60 mK/(W/m²) of all mountings; and what there is on both sides of a lone zero:
        1 % of it, less than passes through any cloud, is more than half of the 1 W/m²
        in which loggers count. [W/m²]
    min_record : float
        *Clock, noon.* Shortest record whose clock is checked: two days and the night
        between. [s]
    max_onset_step : float
        *Clock.* Largest step of the rows at which the onset of a response shows; within
        a larger one it is half over. [s]
    max_noon_step : float
        *Clock, noon.* Largest step of the rows at which the row shows in which a
        response begins, and a jump of the noon by an hour. [s]
    max_lag_error, max_next_lag_error : float
        *Clock.* Largest remaining error of a lag, as a share of that without a lag, and
        the same for a lag of one row, which may be due to rows with means of one column
        and instantaneous values of the other. [-]
    min_lag_share : float
        *Clock.* Smallest share of the module's changes from row to row that a lag has
        to explain: a column that irradiance hardly moves is no module temperature. [-]
    max_onset_shift : float
        *Clock, stuck.* Largest shift about such a lag, or about none, at which the
        onset is searched: two time zones. [s]
    onset_tolerance : float
        *Clock.* Time beyond one sample by which contact sensors and averaging may
        differ, and the largest error of an onset that counts: contact sensors respond
        within 10 to 60 s. [s]
    min_peak_ratio : float
        *Clock.* Smallest ratio of a correlation's peak to its own scatter at which
        clouds show the begin of a response. [-]
    onset_blocks : int
        *Clock.* Blocks into which a long record is divided. [-]
    max_block_days : int
        *Clock.* Longest block; in longer ones a drift of 7 s a day is lost. [days]
    min_block_error : float
        *Clock.* Error of the shape of the response that a block's own error may not
        contain. [s]
    min_standard_errors : float
        *Clock, noon.* Standard errors by which a fault differs from none; with few
        blocks, Student's t with the same chance. A single block needs twice as many.
        [-]
    daylight_tolerance : float
        *Noon, negative by day.* Uncertainty of the time of day by light alone, from a
        turned plane, a horizon or hourly means; the smallest jump of it; and the parts
        of a day that are compared with other days. [s]
    noon_window : int
        *Noon, light by night.* Days on each side of a jump that are compared; with
        missing days they may span four times as many. [days]
    min_noon_error : float
        *Noon, clock.* Smallest error that clouds cause in the noon of one day. A jump
        is of whole hours to within ``min_standard_errors`` times that, and one of a
        module's clock to within it. [s]
    min_night : float
        *Noon.* Shortest dark time of a day with clear edges; near the midnight sun it
        is shorter. [s]
    min_stray_gap : float
        *Times.* Shortest gap between rows from which the rows on one side are suspect.
        [s]
    """

    max_accident_share: float = 0.02
    max_accident_rows: int = 3
    min_known_values: int = 20
    min_fill_ratio: float = 3.5
    max_impossible_share: float = 0.2
    daylight_window: int = 3
    min_sunny_irradiance: float = 300.0
    max_lit_night_share: float = 0.2
    min_spike: float = 12.0
    min_range_end_days: int = 5

    max_stuck_chance: float = 1e-9
    response_time: float = 1800.0
    stale_air_window: float = 10800.0
    stale_wind_window: float = 21600.0
    stale_day_window: float = 86400.0
    stale_calm_window: float = 259200.0
    min_temperature_response: float = 10.0
    temperature_tolerance: float = 1.0
    min_light: float = 20.0
    min_bright_irradiance: float = 100.0

    min_record: float = 129600.0
    max_onset_step: float = 900.0
    max_noon_step: float = 3600.0
    max_lag_error: float = 0.8
    max_next_lag_error: float = 0.5
    min_lag_share: float = 0.3
    max_onset_shift: float = 7200.0
    onset_tolerance: float = 30.0
    min_peak_ratio: float = 5.0
    onset_blocks: int = 8
    max_block_days: int = 14
    min_block_error: float = 3.0
    min_standard_errors: float = 3.0
    daylight_tolerance: float = 1800.0
    noon_window: int = 10
    min_noon_error: float = 300.0
    min_night: float = 10800.0
    min_stray_gap: float = 31622400.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not value > 0:
                raise ValueError(f"{field.name} = {value} must be more than 0")
