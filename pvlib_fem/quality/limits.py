"""Every threshold by which a sensor or a logger is found at fault, in one place."""

from dataclasses import dataclass, fields

#: values that a sensor can have measured: least, most, unit. Below a pyranometer's
#: offset by night no irradiance is negative; 2000 W/m² is more than any cloud's edge
POSSIBLE = {
    "poa_global": (-30.0, 2000.0, "W/m²"),
    "temp_air": (-60.0, 100.0, "°C"),
    "wind_speed": (0.0, 60.0, "m/s"),
    "temp_module": (-60.0, 100.0, "°C"),
}
#: the same of further columns, with room for what a sensor errs: longwave is σT⁴ from
#: −100 °C to 60 °C, rain the most that fell in a minute, power that of a bright second
POSSIBLE_DRIVERS = {
    "wind_direction": (-360.0, 720.0, "°"),
    "relative_humidity": (-5.0, 110.0, "%"),
    "longwave_down": (50.0, 700.0, "W/m²"),
    "precipitation": (0.0, 2500.0, "mm/h"),
    "snow_depth": (-50.0, 1500.0, "cm"),
    "p_dc": (-50.0, 1000.0, "W/m²"),
    **dict.fromkeys(
        ("ghi", "dni", "dhi", "poa_direct", "poa_diffuse"), (-30.0, 2000.0, "W/m²")
    ),
}


def possible(name):
    """Least and most that a column can hold, and its unit, or None for any other."""
    if name not in POSSIBLE and name.startswith("temp_"):
        return -100.0, 200.0, "°C"
    return {**POSSIBLE, **POSSIBLE_DRIVERS}.get(name)


@dataclass(frozen=True, kw_only=True)
class Limits:
    """
    Every threshold by which :func:`pvlib_fem.screen` and :func:`check` decide.

    A change is made by ``Limits(still_wind=43200.0)`` and given as ``limits=``. What
    they find, and what they find wrongly, is in :doc:`/quality`.

    Attributes
    ----------
    fill_apart : float
        *fill value.* Distance of a logger's code for "no value" from all that a
        column otherwise holds, as a share of its span: a code among its values is a
        value. [-]
    fill_above : float
        *fill value.* Multiple of the largest other value, in size, from which a
        positive code is one in a column whose range is not known. [-]
    far : float
        *fill value.* The same for a value that is no known code and repeats. [-]
    far_rows : int
        *fill value.* Rows from which such a value repeats; below it is one accident.
        [-]
    far_share : float
        *fill value.* Share of a column's values up to which one that repeats far
        outside is a code: more is a state of what is measured, such as on. [-]
    lone : float
        *spike.* Multiple of the largest other value, in size, from which a value that
        does not repeat is an accident, in a column whose range is not known; no
        skewed quantity jumps so far beyond its own largest. [-]
    few_distinct : int
        *fill value, spike.* Different values that a column needs to know its own span;
        with fewer it is a switch. [-]
    most_impossible : float
        *out of range.* Share of one of the four columns that may be impossible; with
        more the record is refused. [-]
    day_slot : float
        *negative by day.* Length of the parts of a day that are compared with the same
        on the days around. [s]
    day_side : int
        *negative by day.* Days on either side that are compared. [days]
    day_light : float
        *negative by day.* Irradiance that the brightest of those days has to reach at
        that time of day: so early and late a negative value may be of the night.
        [W/m²]
    few_rows : int
        *spike, stuck.* Rows that a value which jumps and returns may last, and a
        repetition that is an accident; longer is weather. [-]
    spike_air, spike_module : float
        *spike.* Change there and back that may be noise, in a thermometer's hut and on
        a module. [K]
    spike_air_most : float
        *spike.* Change of air there and back within ``still_air`` that is none: fronts
        do not return, and heat bursts of some minutes reach 15 K. [K]
    spike_air_rate, spike_module_rate : float
        *spike.* Fastest change beyond that: a front moves air by 20 K in ten minutes,
        and 1000 W/m² a light module of 7 kJ/(m² K) by 0.15 K each second. [K/s]
    end_rows, end_days : int
        *end of range.* Rows at the most, or the least, that a column reads, and days
        with such rows, from which its sensor's range may end there: what is measured
        is at its very most once. [-]
    end_near : float
        *end of range.* Part of its span next to that value in which a column has to be
        less often than at it. [-]
    still_chance : float
        *stuck.* Chance of a repetition, by how often its column keeps a value from row
        to row, below which that is no accident. [-]
    still_time : float
        *stuck.* Time up to which a repetition is none: five time constants of a module,
        by the fifth of which it smooths irradiance. [s]
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
    felt : float
        *stuck.* Change of irradiance that a module must answer, by 2 to 6 K at the
        20 to 60 mK/(W/m²) of all mountings. [W/m²]
    felt_air : float
        *stuck.* Change of air temperature that a module must answer, beside twice
        the resolution of both sensors. [K]
    warmed : float
        *stuck.* Change of over-temperature that takes a change of irradiance, some
        300 W/m². [K]
    melting : float
        *stuck.* Distance from 0 °C within which snow that melts may hold a module.
        [K]
    shortest_record : float
        *clock, noon.* Time below which no clock is looked at: two days and the
        night between. [s]
    coarsest_clock : float
        *clock.* Step of the rows above which the onset of an answer does not show,
        since it is half over within it. [s]
    coarsest_lag : float
        *clock.* Step of the rows up to which the step shows in which an answer
        begins. [s]
    lag_left, lag_next : float
        *clock.* Share of what no lag leaves of the changes from row to row, below
        which another lag's has to be, and one that is but a step off: that may be by
        half where rows hold means of one column and ends of the other. [-]
    lag_share : float
        *clock.* Share of those changes that has to be told at it: what irradiance
        hardly moves is no module. [-]
    farthest_clock : float
        *clock.* Time around such a lag, or none, within which the onset is looked
        for: two zones. [s]
    sensor_slack : float
        *clock.* Time beyond one sample by which contact sensors and averaging may
        differ: contact sensors answer within 10 to 60 s. [s]
    hour_slack : float
        *clock.* Distance from an hour within which a jump is of summer time. [s]
    clear_peak : float
        *clock.* Height of a correlation over its own scatter, from which clouds
        show when an answer begins. [-]
    onset_error : float
        *clock.* Standard error, in samples, from which a block tells nothing. [-]
    block_number : int
        *clock.* Blocks into which a record is divided if it is long enough. [-]
    shortest_block, longest_block : int
        *clock.* Length of a block; one day has no error, and over longer blocks a
        drift of 7 s a day is lost in them. [days]
    block_outlier : float
        *clock.* Distance from the line through the others, in median deviations,
        from which a block is an accident: six standard deviations. [-]
    block_error : float
        *clock.* What a block's own error may leave out, of the shape of the answer.
        [s]
    sure : float
        *clock.* Standard errors by which a fault has to differ from none; with few
        blocks Student's t of the same chance. [-]
    light : float
        *noon, stuck.* Irradiance above which there is light, above what a
        pyranometer reads at night. [W/m²]
    bright : float
        *noon.* Irradiance that a day has to reach, to have clear edges. [W/m²]
    whole_day : float
        *noon.* Share of a day's rows that have to be there: what is lost may be its
        first or last light. [-]
    night_rows : float
        *noon.* Share of the rows by night up to which a file holds days alone, so that
        what lacks around them is dark. [-]
    off_noon : float
        *noon.* What a turned plane, a horizon or averages of an hour may do to a
        noon, and the least jump of it. [s]
    noon_slack : float
        *noon.* Distance from whole hours within which a jump of the noon is by
        those: what clouds leave in the median of ten days. [s]
    noon_side : int
        *noon.* Days on each side of a jump that are compared. [days]
    shortest_night : float
        *noon.* Dark time below which a day has no clear edges, as near the midnight
        sun. [s]
    noon_gap : int
        *noon.* Days that these may span, where some are missing. [days]
    noon_error : float
        *noon.* What clouds leave in the noon of one day, at least. [s]
    coarsest_noon : float
        *noon.* Step of the rows above which no jump is looked for: it would be
        less than a row. [s]
    stray_gap : float
        *times.* Gap between rows from which those on its one side are suspect. [s]
    stray_share : float
        *times.* Share of the record's rows up to which they are stray. [-]
    few_values : int
        *units.* Values of which the largest tells of no unit yet. [-]
    odd_share : float
        *units.* Share of odd values that is still an accident. [-]
    largest_fraction : float
        *units.* Relative humidity up to which it is a fraction, with room for a
        sensor in fog. [-]
    largest_humidity : float
        *units.* Relative humidity that a sensor in fog may read. [%]
    least_longwave, most_longwave : float
        *units.* What skies send: σT⁴ of −60 °C and of 40 °C. [W/m²]
    largest_radians : float
        *units.* 2π, rounded up, up to which a direction is in radians. [-]
    least_kelvin : float
        *units.* Median of a temperature from which it is in kelvin. [K]
    most_efficiency : float
        *units.* Power per irradiance that no module gives; the best give a quarter,
        and sensors err. [-]
    least_efficiency : float
        *units.* Power per irradiance below which it is in kW: no module in the sun
        gives so little at its best. [-]
    sunny : float
        *units.* Irradiance above which that is looked at. [W/m²]
    swapped : float
        *units.* Fall of module over air temperature with irradiance from which the two
        are swapped: what the coolest mounting gains, the other way. [K m²/W]
    hot_air : float
        *units.* Air temperature that 1 % of the rows may reach without a word; in
        Kuwait's summer it is 49 °C. [°C]
    windy : float
        *units.* Mean wind without a word: near the ground few sites on land have
        more. [m/s]
    least_gain, most_gain : float
        *units.* Gain of over-temperature with irradiance outside which a record gets a
        word; racks gain 15 to 40 K at 1000 W/m², insulated backs 60. [K m²/W]
    """

    fill_apart: float = 0.1
    fill_above: float = 3.0
    far: float = 10.0
    far_rows: int = 3
    far_share: float = 0.05
    lone: float = 50.0
    few_distinct: int = 20
    most_impossible: float = 0.2
    day_slot: float = 1800.0
    day_side: int = 3
    day_light: float = 300.0
    few_rows: int = 3
    spike_air: float = 10.0
    spike_module: float = 15.0
    spike_air_most: float = 25.0
    spike_air_rate: float = 0.035
    spike_module_rate: float = 0.15

    end_rows: int = 20
    end_days: int = 5
    end_near: float = 0.03

    still_chance: float = 1e-9
    still_time: float = 1800.0
    still_air: float = 10800.0
    still_day: float = 86400.0
    still_wind: float = 21600.0
    calm: float = 259200.0
    felt: float = 100.0
    felt_air: float = 1.0
    warmed: float = 10.0
    melting: float = 0.5

    shortest_record: float = 129600.0
    coarsest_clock: float = 900.0
    coarsest_lag: float = 3600.0
    lag_left: float = 0.8
    lag_next: float = 0.5
    lag_share: float = 0.3
    farthest_clock: float = 7200.0
    sensor_slack: float = 30.0
    hour_slack: float = 300.0
    clear_peak: float = 5.0
    onset_error: float = 2.0
    block_number: int = 8
    shortest_block: int = 2
    longest_block: int = 14
    block_outlier: float = 8.9
    block_error: float = 3.0
    sure: float = 3.0

    light: float = 20.0
    bright: float = 100.0
    whole_day: float = 0.98
    night_rows: float = 0.1
    off_noon: float = 1800.0
    noon_slack: float = 900.0
    noon_side: int = 10
    shortest_night: float = 10800.0
    noon_gap: int = 40
    noon_error: float = 300.0
    coarsest_noon: float = 3600.0

    stray_gap: float = 31622400.0
    stray_share: float = 0.01

    few_values: int = 5
    odd_share: float = 0.01
    largest_fraction: float = 1.5
    largest_humidity: float = 110.0
    least_longwave: float = 100.0
    most_longwave: float = 550.0
    largest_radians: float = 6.3
    least_kelvin: float = 150.0
    most_efficiency: float = 0.4
    least_efficiency: float = 0.005
    sunny: float = 200.0
    swapped: float = 0.008
    hot_air: float = 50.0
    windy: float = 5.5
    least_gain: float = 0.008
    most_gain: float = 0.065

    def __post_init__(self):
        for field in fields(self):
            value = getattr(self, field.name)
            if not value > 0:
                raise ValueError(f"{field.name} = {value} must be more than 0")
