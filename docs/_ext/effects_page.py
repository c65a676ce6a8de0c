"""The pages of effects, written from the registry and its docstrings before a build.

What an effect's file and its line in the registry say is all that its page needs.
"""

import inspect
import re
from functools import partial
from pathlib import Path

from pvlib_fem import drivers, effects
from pvlib_fem._record.column_names import GEOMETRY

INTRO = """
The catalogue has one effect a page. All add to the columns of one equation,
``capacity · dT/dt = heat − loss · (T − T_air)``. A sensor reads
``measured = T + gain · (T − T_air) + offset``. The columns are ``heat`` [W/m²],
``loss`` [W/(m² K)], ``capacity`` [J/(m² K)], ``offset`` [K] and ``gain`` [-].
Names in the equations are those of the columns and the parameters. All parameters
are 0 at the start of a fit, where an effect adds nothing. A fit keeps them in their
range. :doc:`effects/drivers` has the drivers, :doc:`/study` how often each effect is
found, and :doc:`/adding_an_effect` how to add one.
"""
GROUPS = {
    "Drivers of their own": """
Each has a driver of its own: a column, the years, or one window of the sky. So the loop
can identify it, unless another effect explains as much.
""",
    "Confounders": """
Functions of the usual inputs alone: irradiance, air temperature, wind, sun and date.
Several look alike, so the loop reports them as ambiguous, with the measurement that
would decide.
""",
}
CHANGES = """
Faults of sensors and mountings. Each has a time profile, such as
``module_sensor_contact_step`` or ``irradiance_sensor_drift``. The loop estimates the
dates; ``{'name': 'module_sensor_contact_step', 'at': '2012-04-01'}`` sets them. A fault
of constant size is in the coefficients of the steady model.
"""
DRIVERS = """
Inputs of effects: measured columns, and quantities computed from them.
"""
MEASURED = """
Effects need columns with these names. Irradiance, air temperature and wind speed are
always there.
"""
DERIVED = """
Computed from measured columns and times if an effect needs them.
"""
SECTION = re.compile(r"\n+^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)


def words(function):
    """First line of a docstring, what follows it, and its sources."""
    text, *sections = SECTION.split(inspect.getdoc(function) or "")
    text = re.sub(r"\s*\[\d+\]_", "", text)
    first, _, body = text.partition("\n\n")
    references = dict(zip(sections[::2], sections[1::2])).get("References", "")
    entries = re.split(r"^\.\. \[\d+\] ", references, flags=re.MULTILINE)
    # an initial in front would number a list
    sources = [re.sub(r"^(?=\w\.)", r"\\", " ".join(e.split())) for e in entries[1:]]
    return " ".join(first.split()), body, sources


def forms(effect):
    """Functions of the effect's file that have an equation, its own first."""
    own = effect.terms.func if isinstance(effect.terms, partial) else effect.terms
    if own in [sensor_fault.terms for sensor_fault in effects.SENSOR_FAULTS]:
        return [own]
    module = inspect.getmodule(own)
    others = [
        f
        for f in vars(module).values()
        if inspect.isfunction(f) and f.__module__ == module.__name__ and f is not own
    ]
    return [own, *(f for f in others if ".. math::" in (f.__doc__ or ""))]


def behind(name):
    """Measured columns that a driver is made of, each once."""
    if name not in drivers.DERIVED:
        return [name]
    found = [n for needed in drivers.DERIVED[name][0] for n in behind(needed)]
    return list(dict.fromkeys(found))


def needs(effect):
    """What has to be measured besides the usual three, in words."""
    names = drivers.needed_for(effect.drivers)
    columns = [f"``{name}``" for name in names if name not in GEOMETRY]
    if len(columns) < len(names):
        columns.append("sun and module")
    return ", ".join(columns) or "nothing"


def number(value):
    return f"{value:g}".replace("-", "−")


def literal(names):
    return ", ".join(f"``{name}``" for name in names)


def to_driver(name):
    kind = "column" if name in drivers.MEASURED else "driver"
    known = {*drivers.DERIVED, *drivers.MODELLED, *drivers.MEASURED}
    return f":ref:`{name} <{kind}-{name}>`" if name in known else f"``{name}``"


def to_drivers(names, nothing="the times"):
    return ", ".join(map(to_driver, names)) or nothing


def linked(text):
    """References to drivers, as a docstring has them, as links to their rows."""
    return re.sub(r":func:`(\w+)`", lambda found: to_driver(found[1]), text)


def meaning(name):
    if name in drivers.DERIVED:
        return linked(words(drivers.DERIVED[name][1])[0])
    return (drivers.MEASURED | drivers.MODELLED).get(name, "")


def table(header, rows, widths, kind="stacked"):
    """Lines of a list-table; on a phone the cells of one that is stacked are lines."""
    yield ".. list-table::"
    yield "   :header-rows: 1"
    yield f"   :class: {kind}"
    yield f"   :widths: {widths}"
    yield ""
    for row in (header, *rows):
        for cell, mark in zip(row, ["* -", *["  -"] * len(row)]):
            lines = cell.split("\n") or [""]
            yield f"   {mark} {lines[0]}".rstrip()
            yield from (f"       {line}".rstrip() for line in lines[1:])
    yield ""


def overview(chosen):
    """Rows of a table of effects."""
    for effect in chosen:
        lead = words(inspect.getmodule(forms(effect)[0]))[0].rstrip(".")
        best, *others = effect.forms
        wanted = needs(best) + ("; or other sources" if others else "")
        link = f":ref:`{effect.name} <effect-{effect.name}>`"
        yield link, lead, wanted


def titled(title, text="", line="="):
    return title, line * len(title), text


def described(effect):
    """Lines of one effect's page."""
    own, *others = forms(effect)
    yield from (f".. _effect-{effect.name}:", "", *titled(effect.name))
    sources = []
    for form in (own, *others):
        first, body, entries = words(form)
        sources += entries
        yield from (f"**{first}**", "", body, "")
    header = ("Parameter", "Unit", "Range")
    yield from table(header, parameter_rows(effect), "40 30 30", kind="parameters")
    yield from drivers_of(effect)
    yield from settings(effect)
    known = {
        *effects.PHYSICS,
        *(sensor_fault.name for sensor_fault in effects.SENSOR_FAULTS),
    }
    alike = "; ".join(
        f":ref:`{name} <effect-{name}>`" if name in known else name
        for name in effect.confused_with
    )
    yield f":Looks like: {alike}"
    yield f":Would decide: {effect.decided_by}"
    yield from (f":Source: {source}" for source in sources)
    yield ""


def parameter_rows(effect):
    """Rows of all sources, each that differs once."""
    seen = {}
    for variant in (effect, *effect.forms):
        for name, row in variant.rows().items():
            bounds = f"{number(row.lower)} to {number(row.upper)}"
            unit = row.unit.replace("-", "\\-")  # else a list
            seen[f"``{name}``", unit, bounds] = None
    return list(seen)


def drivers_of(effect):
    """Table of its drivers, with where they come from if there is a choice."""
    rows = []
    for variant in effect.forms:
        source = variant.source or "the columns alone"
        if variant.confounder and not effect.confounder:
            source += " (reported as ambiguous)"
        for name in variant.drivers:
            rows.append((source, to_driver(name), meaning(name), made_of(name)))
            source = ""
    header = ("Source, the best first", "Driver", "Meaning", "Computed from")
    if effect.variants:
        yield from table(header, rows, "20 22 33 25", "stacked made")
    else:
        rows = [row[1:] for row in rows]
        yield from table(header[1:], rows, "25 45 30", "stacked made")


def made_of(name):
    """What has to be measured for a driver, in words."""
    if name not in drivers.DERIVED:
        return "measured" if name in drivers.MEASURED else "the fit without effects"
    columns = behind(name)
    place = [n for n in columns if n in GEOMETRY]
    if len(place) < len(GEOMETRY):
        return to_drivers(columns)
    others = [n for n in columns if n not in place]
    sun = f":ref:`place of sun and module <column-{GEOMETRY[0]}>`"
    return ", ".join([*map(to_driver, others), sun])


def settings(effect):
    """What it can be made with besides its name."""
    if effect.variants:
        made = next(v.spec for v in effect.forms if v.settings)
        yield "By its name alone it takes the first source whose columns are there, by"
        yield from (f"``{made}`` that one.", "")
    elif effect.make:
        made = inspect.signature(effect.make).parameters.values()
        given = ", ".join(f"{p.name!r}: …" for p in made)
        summary = words(effect.make)[0]
        yield f"With settings, ``{{'name': {effect.name!r}, {given}}}``: {summary}"
        yield ""
    taken = {n: v for form in effect.forms for n, v in form.constants.items()}
    if taken := {n: v for n, v in taken.items() if isinstance(v, float)}:
        values = ", ".join(f"``{name}`` ({value:g})" for name, value in taken.items())
        yield f"Constants that can be set by name, with their usual values: {values}."
        yield ""
    if effect.prepare:
        summary = words(effect.prepare)[0]
        yield f"In the loop: {summary[:1].lower()}{summary[1:]}"
        yield ""
    if effect.scan:
        summary = words(getattr(effect.scan, "func", effect.scan))[0]
        yield f"In the loop a scan looks for {summary[:1].lower()}{summary[1:]}"
        yield ""


def driver_table():
    for name, (columns, compute) in drivers.DERIVED.items():
        anchored = f".. _driver-{name}:\n\n``{name}``"
        what = "\n\n".join([meaning(name), *sources(compute)])
        yield anchored, what, to_drivers(columns)
    for name, what in drivers.MODELLED.items():
        yield f".. _driver-{name}:\n\n``{name}``", what, made_of(name)


def sources(compute):
    """Sources of a driver, and of functions that it names and that are no drivers."""
    own = words(compute)[2]
    for name in re.findall(r":func:`(\w+)`", inspect.getdoc(compute)):
        if name not in drivers.DERIVED:
            own += words(named(compute, name))[2]
    return own


def named(compute, name):
    """What a function's docstring refers to, in the file that it is in."""
    return getattr(inspect.getmodule(compute), name)


def measured_table():
    for name, what in drivers.MEASURED.items():
        yield f".. _column-{name}:\n\n``{name}``", what


def index():
    """Lines of the page that leads to all others."""
    chosen = effects.PHYSICS.values()
    header = ("Effect", "Meaning", "Further columns")
    yield from titled("Effects", INTRO)
    for confounder, (group, text) in zip((False, True), GROUPS.items()):
        yield from titled(group, text, "-")
        alike = [effect for effect in chosen if effect.confounder == confounder]
        yield from table(header, overview(alike), "25 45 30", "stacked needs")
    yield from titled("Instruments and mountings", CHANGES, "-")
    yield from table(("Fault", "Meaning"), sensor_faults(), "25 75", "stacked needs")
    yield from table(
        ("Time profile", "Meaning"), time_profiles(), "25 75", "stacked needs"
    )
    yield from (".. toctree::", "   :hidden:", "")
    yield from (
        f"   effects/{name}"
        for name in (*effects.PHYSICS, *names(effects.SENSOR_FAULTS), "drivers")
    )


def names(chosen):
    return [effect.name for effect in chosen]


def sensor_faults():
    """Rows of what can change."""
    for sensor_fault in effects.SENSOR_FAULTS:
        link = f":ref:`{sensor_fault.name} <effect-{sensor_fault.name}>`"
        yield link, words(sensor_fault.terms)[0].rstrip(".")


def time_profiles():
    """Rows of how it can."""
    for time_profile in effects.TIME_PROFILES:
        given = ", ".join(inspect.signature(time_profile.weight).parameters)
        yield (
            f"``{time_profile.name}``",
            f"{words(time_profile.weight)[0]} Dates: ``{given}``.",
        )


def columns():
    """Lines of the page of what effects follow."""
    yield from titled("Columns and drivers", DRIVERS)
    yield from titled("Measured columns", MEASURED, "-")
    yield from table(("Column", "Meaning"), measured_table(), "30 70")
    yield from titled("Derived drivers", DERIVED, "-")
    header = ("Driver", "Meaning and source", "Computed from")
    yield from table(header, driver_table(), "24 48 28", "stacked made")


def pages():
    """All pages in reStructuredText, by their paths."""
    found = {"effects": index(), "effects/drivers": columns()}
    for effect in (*effects.PHYSICS.values(), *effects.SENSOR_FAULTS):
        found[f"effects/{effect.name}"] = described(effect)
    return {f"{path}.rst": "\n".join(lines) + "\n" for path, lines in found.items()}


def write(folder):
    """Write the pages into a folder, those that are others than are there."""
    wanted = {Path(folder, path): text for path, text in pages().items()}
    for path in set(Path(folder, "effects").glob("*.rst")).difference(wanted):
        path.unlink()
    for path, text in wanted.items():
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")


def setup(app):
    app.connect("builder-inited", lambda app: write(Path(app.srcdir) / "generated"))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
