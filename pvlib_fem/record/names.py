"""What a column may be, by its name."""

import re

import pandas as pd

from pvlib_fem.record.columns import ALIASES
from pvlib_fem.record.units import QUANTITIES

#: column: names that loggers have for it, the surest first
NAMES = {
    "poa_global": (
        r"poa|gti|gpoa|tilt|inclin|plane|modulebene",
        r"irr|einstrahl|insol|^g$|^g_?i$|pyran|global|solar_?rad|strahlung",
    ),
    "temp_module": (
        r"(mod(ul\w*)?|panel|back(sheet)?|bom|pv|cell|zell)[\s_.-]*t|"
        r"t(emp\w*)?[\s_.-]*(mod|panel|back|bom|pv|cell|zell)",
    ),
    "temp_air": (
        r"(amb(ient)?|air|outdoor|dry_?bulb|luft|außen|umgebung\w*)[\s_.-]*t|"
        r"t(emp\w*)?[\s_.-]*(amb|air|out|dry|luft|außen|umg|2m)",
        r"^ta(\b|_)|^t_?a$",
        r"^t(emp[a-z]*)?[\s_.-]*\d*(\b|_)",
    ),
    "wind_direction": (r"w(ind)?[\s_.-]*d(ir|\b|_)|wind\w*richt|^wr(\b|_)",),
    "wind_speed": (
        r"w(ind)?[\s_.-]*(s(p(ee)?d)?|vel\w*)(\b|_)|wind\w*geschw|^v_?w(ind)?(\b|_)|"
        r"vel\w*[\s_.-]*(w|vi?ento)",
        r"^wind|anemom|vi?ento|^v$",
    ),
    "relative_humidity": (r"^rh(\b|_|\d)|rel\w*[\s_.-]*hum|humid|feucht|^hr$|^rf$",),
    "longwave_down": (r"long[\s_-]?wave|^lw|pyrgeo|^dlr|^ir_?down|infrared",),
    "precipitation": (r"rain|precip|regen|niederschl|^rr$",),
    "p_dc": (r"^p[\s_.-]?dc|dc[\s_.-]*(power|leist)|(power|leist\w*)[\s_.-]*dc",),
    "snow_depth": (r"snow|schnee",),
}
NOT = re.compile(
    r"std|stdev|(\b|_)(min|max|sd|mv|daily|cum\w*)(\b|_)|gust|ghi|dni|dhi|horiz|"
    r"diffus|direct|beam|clear|status|flag|albedo",
    re.IGNORECASE,
)


def mapped(data, columns, names, doubts):
    """The map with the columns that look like a name that none has yet."""
    numeric = [c for c in data if pd.api.types.is_numeric_dtype(data[c])]
    there = {ALIASES.get(column, column) for column in data}
    free = [c for c in numeric if c not in (*columns.values(), *names, *ALIASES)]
    free = [c for c in free if not NOT.search(without_unit(c))]
    columns = dict(columns)
    for name in NAMES:
        if name not in names or name in columns or name in there:
            continue
        for sure, pattern in enumerate(NAMES[name]):
            matching = [c for c in free if re.search(pattern, spelled(c))]
            if matching:
                columns[name] = matching[0]
                free.remove(matching[0])
                told(name, matching, sure, doubts)
                break
    return columns


def told(name, matching, sure, doubts):
    """What a person should look at."""
    if len(matching) > 1:
        doubts.append(
            f"{name} may also be {', '.join(repr(c) for c in matching[1:4])}"
            + (f" or {len(matching) - 4} others" if len(matching) > 4 else "")
        )
    if name == "poa_global" and sure > 0:
        doubts.append(
            f"{matching[0]!r} has to be in the plane of the module, not horizontal"
        )


def spelled(column):
    """A column's name without its unit, in small letters, words apart."""
    bare = re.sub(r"([a-z])([A-Z])", r"\1_\2", without_unit(column))
    return bare.strip().lower()


def without_unit(column):
    return re.sub(r"[\[({].*?[\])}]", "", str(column))


def unmapped(data, columns=(), names=tuple(QUANTITIES)):
    """Columns that look like a usual driver and are not mapped to it."""
    found = mapped({name: data[name] for name in data}, {}, names, [])
    return {name: column for name, column in found.items() if name not in columns}
