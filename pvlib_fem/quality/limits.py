"""Every threshold by which a sensor or a logger is found at fault, in one place."""

from dataclasses import dataclass, fields


@dataclass(frozen=True, kw_only=True)
class Limits:
    """
    Every threshold by which :func:`check` decides.

    A change is made by ``Limits(still_wind=43200.0)`` and given as ``limits=``. What
    they find, and what they find wrongly, is in :doc:`/quality`.

    Attributes
    ----------
    still_rows : int
        *stuck.* Rows of one value, up to which it is an accident. [-]
    still_time : float
        *stuck.* Time for which a value may repeat at the resolution of
        ``fine``: five time constants of a module. [s]
    still_air : float
        *stuck.* Time over which air moves a thermometer, or a module in the dark,
        which an evening's calm may not. [s]
    still_day : float
        *stuck.* Time for which irradiance may be 0 and a module under melting snow
        at 0 °C: the longest night outside the polar circles, and a day. [s]
    still_wind, calm : float
        *stuck.* Time for which wind may repeat any speed but 0, and stay at 0, where
        a cup anemometer does not start. [s]
    felt : float
        *stuck.* Change of irradiance that a module must answer, by 2 to 6 K at the
        20 to 60 mK/(W/m²) of all mountings. [W/m²]
    felt_memory : float
        *stuck.* Time constant by which that irradiance is smoothed, as the module
        does it; usual modules have 5 to 10 min. [s]
    felt_air : float
        *stuck.* Change of air temperature that a module must answer, beside twice
        the resolution of both sensors. [K]
    sunny_change : float
        *stuck.* Change of irradiance that goes with a change of the air, as between
        night and a fair day. [W/m²]
    warmed : float
        *stuck.* Change of over-temperature that takes a change of irradiance, some
        300 W/m². [K]
    fine : float
        *stuck.* Resolution up to which ``still_time`` holds; a coarser sensor may
        stand still for that much longer. [K]
    melting : float
        *stuck.* Distance from 0 °C within which snow that melts may hold a module.
        [K]
    shortest_record : float
        *clock, noon.* Time below which no clock is looked at: two days and the
        night between. [s]
    coarsest_clock : float
        *clock.* Step of the rows above which the onset of an answer does not show,
        since it is half over within it. [s]
    farthest_clock : float
        *clock.* Time up to which a clock is looked for: two zones. [s]
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
    off_noon : float
        *noon.* What a turned plane, a horizon or averages of an hour may do to a
        noon. [s]
    noon_slack : float
        *noon.* Distance from an hour within which a jump of the noon is of summer
        time: what clouds leave in the median of ten days. [s]
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
    sunny : float
        *units.* Irradiance above which that is looked at. [W/m²]
    """

    still_rows: int = 5
    still_time: float = 1800.0
    still_air: float = 10800.0
    still_day: float = 86400.0
    still_wind: float = 21600.0
    calm: float = 259200.0
    felt: float = 100.0
    felt_memory: float = 378.0
    felt_air: float = 1.0
    sunny_change: float = 300.0
    warmed: float = 10.0
    fine: float = 0.1
    melting: float = 0.5

    shortest_record: float = 129600.0
    coarsest_clock: float = 900.0
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
    sunny: float = 200.0

    def __post_init__(self):
        for field in fields(self):
            value = getattr(self, field.name)
            if not value > 0:
                raise ValueError(f"{field.name} = {value} must be more than 0")
