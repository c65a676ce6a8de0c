"""What a column may be, by its name."""

import re
import unicodedata
from collections.abc import Mapping

import pandas as pd

from pvlib_fem._record.column_names import ALIASES, COLUMNS, GEOMETRY
from pvlib_fem._record.header_units import (
    AMOUNTS,
    QUANTITIES,
    in_other_unit,
    named_unit,
    usual_name_of,
)

#: at the start of a name: neither a factor, nor another power, nor a limit, nor a load
TRUE_POWER = (
    r"^(?!.*(fa[ck]?t+(o|eu)r|reac|reat[ti]|appar|apar|blind|schein|limit|set|因数|"
    r"無効|无功|皮相|视在|consum|verbrauch|bezug|bat+er|import|demand|(\b|_)load|消費))"
)
#: power in the large languages, after :func:`without_accents`
POWER = (
    r"(power|leist\w*|poten[cz]\w*|puissance|vermogen|effekt(\b|_)|moc(\b|_)|мощност\w*|"
    r"電力|出力|功率)"
)
ROMANCE = r"(poten[cz]\w*|puissance)"  # in which AC is CA, and DC is CC
#: column: names that loggers have for it, the surest first
NAMES = {
    "poa_rear": (
        r"(rear|back[\s_-]*side|(?<!d)rue?ck\w*)[\s_.-]*(irr|poa|g(\b|_)|rad|einstr)|"
        r"(irr\w*|g?poa|g)[\s_.-]*(rear|back)(\b|_)|einstr\w*[\s_.-]*rue?ck",
    ),
    "poa_global": (
        r"^(?!.*temp).*(poa|gti|gpoa|tilt|inclin|plane|modulebene|(^|_)g[\s_.-]*front|"
        r"^glob_inc$|duzlem\w*[\s_.-]*[iı]s[iı]n|傾斜\w*日射)",
        # and not the temperature of its sensor
        r"^(?!.*temp).*(irr|einstrahl|insol|^g$|^g_?i$|pyran|global|solar_?rad|"
        r"strahlung|rayonn|ensoleil|eclairement|promieniowan|[iı]s[iı]n[iı]m|日射)",
    ),
    "temp_module": (
        r"(mod(ul\w*)?|pan(el|neau)|array|back(sheet)?|bom|pv|cell|zell)[\s_.-]*(\d+[\s_.-]*)?"
        r"t(?!ilt|ot|yp|ime|rack)|"
        r"t(emp\w*)?[\s_.-]*(mod|pan(el|neau)|array|back|bom|pv|cell|zell)|"
        r"(^|_)t\d+[\s_.-]*(mod|panel|array|back|bom|pv|cell|zell)",
        # without the marks of ジ and パ, which are accents here
        r"(panel|modul\w*|hucre)[\s_.-]*s[iı]cakl|(モシュール|ハネル)\w*温度",
        r"^bom[\s_.-]?\d*$|^tc[\s_.-]?\d|^thermoc\w*[\s_.-]*\d*$|^t_?m[\s_.-]?\d*$",
    ),
    "temp_air": (
        r"(amb(ient)?|air|outdoor|dry[\s_-]?bulb|luft|außen|umgebung\w*)[\s_.-]*t|"
        r"t(emp\w*)?[\s_.-]*(amb|air|aria|out|ext|ester|dry|luft|außen|umg|2m|otocz|"
        r"powietrz)|(ortam|hava)\w*[\s_.-]*s[iı]cakl|^(外)?気温",
        r"^ta(\b|_)|^t_?a$",
        r"^t(emp[a-z]*)?[\s_.-]*\d*(\b|_)",
    ),
    "wind_direction": (
        r"(wind|(^|[\W_])w)[\s_.-]*d(ir|\b|_|\d)|wind\w*richt|^wr(\b|_)|"
        r"dire[cz]\w*[\W_].*(vi?ent|wind)|wind[\s_.-]*vane|kierun\w*[\s_.-]*wiatr|"
        r"ruzgar\w*[\s_.-]*yon|風向",
    ),
    "wind_speed": tuple(
        rf"^(?!.*(dire[cz]|richt|(\b|_)dir(\b|_)))({pattern})"
        for pattern in (
            r"(.*wind|(.*[\W_])?w)[\s_.-]*(s(p(ee)?d)?|vel\w*)(\b|_|\d)|"
            r".*wind\w*geschw|v_?w(ind)?(\b|_)|.*vel\w*[\s_.-]*(w|(del |do )?vi?ento)|"
            r".*predk\w*[\s_.-]*wiatr|.*ruzgar\w*[\s_.-]*h[iı]z|.*風速|ff$",
            r"wind|.*anemom|.*vi?ento|(.*(\b|_))?vent(\b|_)|v$",
        )
    ),
    "relative_humidity": (
        r"(^|[\W_])r_?h(\b|_|\d)|rel\w*[\s_.-]*hum|humid|^hum(\b|_)|feucht|^hr$|^rf$|"
        r"wilgotn|bag[iı]l[\s_.-]*nem|湿度",
    ),
    "longwave_down": (r"long[\s_-]?wave|^lw|pyrgeo|^dlr|^ir_?down|infrared",),
    "precipitation": (
        r"rain|precip|regen|niederschl|neerslag|pluie|lluvia|pioggia|^rr$",
    ),
    "snow_depth": (r"snow|schnee",),
    # power by area is never guessed: a plant's would be taken for it
    "power_dc": (
        rf"^p[\s_.-]?dc|dc[\s_.-]*{POWER}|{POWER}[\s_.-]*dc|直流.*{POWER}|"
        rf"{ROMANCE}[\s_.-]*cc(\b|_)|^dc[\s_.-]+([km]?_?w|watt)$",
    ),
    "power_ac": (
        rf"{TRUE_POWER}((.*[\W_])?p[\s_.-]?ac(\b|_|\d)|.*ac[\s_.-]*{POWER}|"
        rf".*{POWER}[\s_.-]*ac|.*{ROMANCE}[\s_.-]*ca(\b|_)|ac[\s_.-]+([km]?_?w|watt)$)",
        rf"{TRUE_POWER}.*{POWER}",
        rf"{TRUE_POWER}.*(production|generation|output|erzeug|produktion|einspeis).*watt",
        # whatever its name, in kW or MW, or in W in brackets
        rf"{TRUE_POWER}(?!.*(rad|irr|light|licht)).*[\s_.-](k_?w|m_?w|watt)$",
    ),
}
#: quantity whose unit a header names in brackets, as a word of its name
UNIT_WORDS = {"temp_air": "temp", "power_ac": "watt"}
#: drivers of effects and cross-checks: columns in addition to the usual four
DRIVERS = tuple(name for name in NAMES if name not in COLUMNS)
#: words before a name that say where its sensor is
PLACE = re.compile(r"^((met|meteo|weather|wx|env|station|site)\d*[\s_./-]+)+")
NOT = re.compile(
    r"std|stdev|(\b|_)(min|max|sd\d*|mv|daily|cum\w*)(\b|_)|gust|ghi|dni|dhi|horiz|"
    r"poziom|yatay|水平|全天|"
    r"diffus|dire[ck]?t+(?!ion)|beam|clear|status|flag|albedo|dew|chill|wet[\s_-]?bulb|azimuth|"
    r"(tracker|axis|module|panel|array|surface)[\s_.-]*tilt|tilt[\s_.-]*(angle|deg)|^tilt$",
    re.IGNORECASE,
)


FEWEST_RISES = 10  # of a counter; a flag that is set once is none


def mapped(
    data: dict,
    columns: dict,
    names: tuple,
    doubts: list,
    units: Mapping | None = None,
) -> dict[str, str]:
    """
    The map with the columns that look like a name that none has yet.

    Parameters
    ----------
    data : dict of Series
        Columns by the file's names.
    columns : dict of str
        Package's name to the file's, of those that are mapped already.
    names : tuple of str
        Package's names that are looked for.
    doubts : list of str
        Takes what a person should look at.
    units : dict of str, optional
        Units that a line below the header gives, by the file's names.

    Returns
    -------
    dict of str
        ``columns``, and package's name to the file's of those that are found.
    """
    numeric = [c for c in data if pd.api.types.is_numeric_dtype(data[c])]
    there = {ALIASES.get(column, column) for column in data}
    free = [c for c in numeric if c not in (*columns.values(), *QUANTITIES, *ALIASES)]
    free = [c for c in free if not NOT.search(without_unit(c))]
    columns, units = dict(columns), units or {}
    for name in NAMES:
        if name not in names or name in columns or name in there:
            continue
        for sure, pattern in enumerate(NAMES[name]):
            matching = [c for c in free if looks_like(pattern, c)]
            matching = [
                c for c in matching if not in_other_unit(name, c, units.get(c, ""))
            ]
            if matching:
                columns[name] = matching[0]
                free.remove(matching[0])
                add_doubts(name, matching, sure, doubts)
                break
    return columns


def add_doubts(name: str, matching: list, sure: int, doubts: list) -> None:
    """Add what the user has to check in a guessed column."""
    if len(matching) > 1:
        doubts.append(
            f"{name} may also be {', '.join(repr(c) for c in matching[1:4])}"
            + (f" or {len(matching) - 4} others" if len(matching) > 4 else "")
        )
    if name == "poa_global" and sure > 0:
        doubts.append(
            f"{matching[0]!r} has to be in the plane of the module, not horizontal"
        )


def looks_like(pattern: str, column: str) -> bool:
    """Whether a name has a pattern, by itself or with the word of its unit."""
    name = spelled_name(column)
    units = " ".join(re.findall(r"[\[({].*?[\])}]", str(column)))
    words = [
        word
        for n, word in UNIT_WORDS.items()
        # energy is mostly counted on, or of a day
        if named_unit(n, units) not in (None, *AMOUNTS["power"])
    ]
    return any(re.search(pattern, " ".join([name, *w])) for w in ([], words))


def spelled_name(column: str) -> str:
    """
    A column's name without its unit, accents and place, in small letters, words apart.

    Parameters
    ----------
    column : str

    Returns
    -------
    str
        Such as ``"wind_speed"`` of ``"Met WindSpeed (m/s)"``.
    """
    bare = re.sub(r"([a-z])([A-Z])", r"\1_\2", without_unit(column))
    return PLACE.sub("", without_accents(bare.strip().lower()))


def without_accents(text: str) -> str:
    apart = unicodedata.normalize("NFKD", text)
    return "".join(letter for letter in apart if not unicodedata.combining(letter))


def without_unit(column: str) -> str:
    """
    A column's name without what stands in brackets.

    Parameters
    ----------
    column : str

    Returns
    -------
    str
    """
    return re.sub(r"[\[({].*?[\])}]", "", str(column))


def usual_name(column: str) -> str | None:
    """
    The package's name that a column's name looks like.

    Parameters
    ----------
    column : str

    Returns
    -------
    str or None
        None where it looks like none, or names another quantity, such as a minimum.
    """
    if NOT.search(without_unit(column)):
        return None
    for name, patterns in NAMES.items():
        like = any(looks_like(pattern, column) for pattern in patterns)
        if like and not in_other_unit(name, str(column)):
            return name
    return None


def is_own(column: str) -> bool:
    """
    Whether a column has a name that the package knows.

    Parameters
    ----------
    column : str

    Returns
    -------
    bool
        True also for names of second sensors, of power and of angles of the sun.
    """
    return column in (*ALIASES, *GEOMETRY) or usual_name_of(column) is not None


def unmapped(columns: dict) -> dict[str, str]:
    """
    Columns that look like the driver of an effect, or like power.

    Parameters
    ----------
    columns : dict
        By the file's names.

    Returns
    -------
    dict of str
        The file's name to the package's name that it looks like.
    """
    usual_names = {c: usual_name(c) for c in columns if not is_own(c)}
    return {column: name for column, name in usual_names.items() if name in DRIVERS}


def unused_columns(columns: dict, taken: set) -> dict[str, list[str]]:
    """
    Why columns are not used, by reason.

    Parameters
    ----------
    columns : dict of Series
        Names that are not mapped.
    taken : collection of str
        The package's names that have a column.

    Returns
    -------
    dict of list
    """
    by_reason = {}
    for column, values in columns.items():
        if not is_own(column):
            by_reason.setdefault(why_unused(column, values, taken), []).append(
                str(column)
            )
    return by_reason


def why_unused(column: str, values: pd.Series, taken: set) -> str:
    """Why a column is not used, in words."""
    if values.isna().all():
        return "no value"
    if not pd.api.types.is_numeric_dtype(values):
        return "not numeric"
    if values.min() == values.max():
        return "constant"
    if (step := values.diff().dropna()).min() == step.max() != 0:
        return "a count of the rows"
    if step.min() >= 0 and (step > 0).sum() >= FEWEST_RISES:
        return "a counter, since it never falls"
    if word := NOT.search(without_unit(column)):
        return f"another quantity, by {word[0].strip('_')!r} in the name"
    if (name := usual_name(column)) in taken:
        second = f", a second sensor is {name}_2" if name in COLUMNS else ""
        return f"{name} has a column already{second}"
    return "no known name"
