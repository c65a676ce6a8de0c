"""The page is the printed report with pictures, and nothing that harms."""

import hashlib
import html
import re
from dataclasses import replace
from html.parser import HTMLParser

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from pvlib.location import Location

import pvlib_fem
from pvlib_fem import datasets, simulator
from pvlib_fem._fit import fit_fem
from pvlib_fem._loop.close import close_loop
from pvlib_fem._loop.preparation.file_clock import zone_of_the_sun
from pvlib_fem._loop.ranking.ranking_table import Ranking
from pvlib_fem._loop.results.loop_result import Loop
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.file_summary import digest
from pvlib_fem._report import next_measurement as advice, page_pictures
from pvlib_fem._report.fit_page import fit_call
from pvlib_fem._report.formatting import with_error
from pvlib_fem._report.loop_page import first_model, loop_call
from pvlib_fem.plotting._vector import PAGE
from pvlib_fem.reasons import Reason, because

VOID = {"meta", "br"}


class Page(HTMLParser):
    """Elements, texts and the rows of tables of a page whose tags are in balance."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.attributes, self.texts = [], [], [], []
        self.rows, self.cell = [], None
        self.feed(text)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data

    @property
    def text(self):
        return "\n".join(self.texts)


SCRIPT = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def record():
    """A site with a colder sky, weekends of its own and a column of a bad name."""
    effects = simulator.PHYSICS | {"sky_radiation": 1.0, "weekend_exhaust": 1.0}
    data = simulator.record(effects=effects, days=150, step=900)
    data = data.drop(columns=["longwave_down", "snow_depth", "p_dc_per_area"])
    hours = np.random.default_rng(0).uniform(size=len(data) // 8) > 0.7
    data[SCRIPT] = np.repeat(hours, 8).astype(float)
    data["temp_module"] += 3.0 * data[SCRIPT]
    return data.assign(note="<b>")


@pytest.fixture(scope="module")
def place():
    site = simulator.RHINE
    where = Location(site.latitude, site.longitude, tz=site.tz)
    return {"location": where, "surface_tilt": 35.0, "surface_azimuth": 180.0}


@pytest.fixture(scope="module")
def closed(record, place):
    return close_loop(record, **place)


@pytest.fixture(scope="module")
def page(closed):
    return Page(closed.to_html())


def test_it_has_every_row_of_the_table(closed, page):
    rows = {row[0].replace("+ ", "+", 1): row for row in page.rows}
    assert len(closed.table)
    for name, line in closed.table.iterrows():
        keys = ("rmse_test", "rmse_test_day", "rmse_test_night", "mbe_test")
        shown = [float(value) for value in rows[name][1:5]]
        np.testing.assert_allclose(shown, line[list(keys)], atol=0.00501)


def test_it_has_every_finding_and_what_is_not_testable(closed, page):
    verdicts = {finding.verdict for finding in closed.finding_objects}
    assert len(verdicts) > 1
    for finding in closed.finding_objects:
        assert f"{finding.gain:.2f}" in page.text
        names = (
            finding.where if finding.verdict == "unexplained" else finding.candidates
        )
        assert names
        for name in names:
            assert name in page.text
    assert closed.untestable
    for name, why in closed.untestable.items():
        assert name in page.text
        if why.reason is Reason.DETECTABLE:
            assert f"{name} below {why.values['gain']:.2g} K" in page.text
        else:
            assert str(why) in page.text
    assert closed.notes
    for note in closed.notes:
        assert note in page.text


def test_it_has_the_months_of_a_long_record(closed, page):
    assert "Monthly coefficients" in page.text
    table = closed.fit.through_time()
    own = closed.fit.thermal_model
    names = ["r_eq", *own.steady_model.parameters, "tau", "bias"]
    assert [*table.index.unique("coefficient")] == names
    for name in names[1:]:  # months lie about the whole
        rows = table.loc[name].dropna(subset="value")
        assert rows["lower"].min() < closed.fit.coefficients[name] < rows["upper"].max()


def test_it_has_every_coefficient(closed, page):
    rows = {row[0]: row for row in page.rows}
    assert closed.fit.coefficients
    for name, value in closed.fit.coefficients.items():
        error = closed.fit.stderr[name]
        shown, around = rows[name][1:3]
        if name in closed.fit.at_bound:
            assert float(shown) == pytest.approx(value)
            assert "at its bound" in rows[name]
            continue
        # both to the same place, the second digit of the error
        assert abs(float(shown) - value) <= 0.05 * error
        assert float(around) == pytest.approx(error, rel=0.05)
        assert len(shown.partition(".")[2]) == len(around.partition(".")[2])


def test_it_has_the_printed_report_to_the_letter(closed, page):
    assert closed.report() in page.texts


def test_it_begins_with_what_was_found(closed, page):
    error = closed.table["rmse_test"]
    before = error[closed.base]
    heading = (
        f"Module temperature: {before:.2f} K before, {error[closed.last]:.2f} K after"
    )
    assert heading in page.texts
    first = page.text.index("Error by step")
    statements = closed.statements.set_index("cause")
    assert closed.effects and len(closed.conclusion)
    for name in closed.effects:
        assert statements["text"][name] in page.text[:first]
    for sentence in closed.conclusion:
        assert sentence in page.text[: page.text.index("What to do")]


def test_names_of_columns_are_text_and_nothing_else(closed, page):
    assert f"driver:{SCRIPT}" in closed.effects
    assert any(SCRIPT in text for text in page.texts)
    assert not {"script", "iframe", "object", "link"} & set(page.tags)
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert html.escape(SCRIPT) in closed.to_html()


def test_it_needs_nothing_from_outside(page):
    assert page.attributes
    for name, value in page.attributes:
        if name in ("href", "src", "xlink:href"):
            assert value.startswith(("#", "data:image/png;base64"))
    style = page.texts[page.tags.index("style")]
    assert "url(" not in style
    assert "@import" not in style


def test_identifiers_are_unique_and_used(closed):
    text = closed.to_html()
    names = re.findall(r'\bid="([^"]+)"', text)
    assert len(names) == len(set(names))
    assert set(names) == set(re.findall(r'(?:url\(|href=")#([^")]+)', text))


def test_the_same_data_give_the_same_bits(closed, record, place, tmp_path):
    """Whatever the style of the user's own pictures is."""
    path, figures = tmp_path / "loop.html", plt.get_fignums()
    with plt.style.context(["dark_background", {"font.size": 20, "axes.grid": True}]):
        text = close_loop(record.copy(), **place).to_html(path)
    assert text == closed.to_html()
    assert path.read_bytes() == text.encode("utf-8")
    assert plt.get_fignums() == figures  # none is left open


def test_the_hash_is_that_of_the_users_own_columns(closed, record):
    found = hashlib.sha256(record.index.as_unit("ns").asi8.tobytes())
    for name in closed.fit.summary.measured:
        found.update(name.encode())
        found.update((record[name].to_numpy(dtype="<f8") + 0.0).tobytes())
    assert digest(closed.fit.record) == found.hexdigest()
    assert found.hexdigest() in closed.to_html()


def test_a_record_too_short_says_so(week):
    loop = close_loop(week.iloc[:1440])
    page = Page(loop.to_html())
    assert "The record is too short to weigh any effect." in page.texts
    assert "nan" not in page.text
    assert page.tags.count("figure") == 5  # no effect, and no wind direction


def test_without_an_effect_there_is_no_before():
    data = datasets.synthetic(60, 1800)[list(COLUMNS)]
    loop = close_loop(data)
    page = Page(loop.to_html())
    assert loop.effects == []
    assert any(
        "No effect of the catalogue and no column" in text for text in page.texts
    )
    assert not any("Before" in text for text in page.texts)


def test_what_was_done_to_the_data_is_counted():
    data = datasets.synthetic(60, 1800)[list(COLUMNS)]
    data.iloc[100:150, 1] = np.nan
    data.iloc[200:203, 3] = 400.0
    data.iloc[:8, 0] = -4.0  # at night
    data.attrs["notes"] = [f"met.csv: 7 rows {SCRIPT} left out"]
    loop = close_loop(data)
    rows = [row for row in Page(loop.to_html()).rows if len(row) == 4]
    assert ["given", "all", f"{len(data):,}", "rows of the data"] in rows
    assert ["reading", "", "–", data.attrs["notes"][0]] in rows
    assert ["screening", "temp_air", "50", "missing"] in rows
    assert ["screening", "temp_module", "3", "impossible, not used"] in rows
    assert ["screening", "poa_global", "8", "below zero, set to 0"] in rows
    assert loop.week_rows
    for name, count in loop.week_rows.items():
        assert ["rows", "all", f"{count:,}", f"in {name} weeks"] in rows
    unknown = int(loop.fit.residual.isna().sum())
    (row,) = [row for row in rows if row[3].startswith("without a residual")]
    assert row[2] == f"{unknown:,}" and unknown >= 53


def test_rows_of_a_clock_are_counted_and_kept_in_the_file(tmp_path):
    data = simulator.record(days=60, step=1800.0, start="2023-05-01")[list(COLUMNS)]
    data["temp_module"] = data["temp_module"].shift(2)
    loop = close_loop(data.dropna(), effects=[])
    (correction,) = loop.corrections
    (row,) = [r for r in Page(loop.to_html()).rows if r[:2] == ["clock", "temp_module"]]
    known = loop.fit.record["temp_module"]
    assert row[2] == f"{np.isfinite(known).sum():,}" and row[3] == correction.why
    loop.to_json(path := tmp_path / "loop.json")
    again = Loop.from_json(path)
    assert again.reading == loop.reading == {"rows": len(data) - 2, "notes": []}
    (row,) = [
        r for r in Page(again.to_html()).rows if r[:2] == ["clock", "temp_module"]
    ]
    assert row[2] == "–"


def test_the_site_is_at_the_top(closed, page):
    record = closed.fit.summary
    (line,) = [text for text in page.texts if text.startswith("49.400° N, 8.700° E")]
    assert "tilt 35°, azimuth 180°" in line and "time step 15 min" in line
    assert f"{record.start:%Y-%m-%d} to {record.end:%Y-%m-%d}" in line
    assert f"{record.rows:,} rows" in line
    assert page.texts.index(line) < page.texts.index("What to do")
    nowhere = replace(closed, place=dict.fromkeys(closed.place))
    assert "location not given · plane not given" in nowhere.to_html()


def test_its_sections_are_in_order(page):
    titles = [title for title in SECTIONS if title in page.texts]
    assert titles == list(SECTIONS)
    places = [page.texts.index(title) for title in titles]
    assert places == sorted(places)


SECTIONS = (
    "What to do",
    "Error by step",
    "Evidence",
    "What was done to the data",
    "Remaining error",
    "What could not be tested",
    "What to measure next",
    "Annex: coefficients",
    "Annex: ambiguous findings and hints",
    "Annex: remaining error by time scale",
    "Annex: checks",
    "Annex: terms",
    "Annex: how to reproduce this report",
)


def test_words_beside_the_panels_of_a_fit_do_not_overlap(closed, monkeypatch):
    drawn = []
    monkeypatch.setattr(page_pictures, "svg", lambda *_, **how: drawn.append((_, how)))
    page_pictures.pictures_of_fit(closed.fit)
    ((draw, _), how), *_ = drawn
    with plt.style.context(["default", PAGE]):
        figure = Figure(figsize=how.get("size", (4.2, 2.9)), layout="constrained")
        draw(figure.subplots())
        figure.draw_without_rendering()
    labels = [axes.yaxis.label.get_window_extent() for axes in figure.axes]
    # the page's font may be wider than that of matplotlib
    left = [one.expanded(1.0, 1.1) for one in labels if one.x0 < figure.bbox.x1 / 2]
    upper, lower = sorted(left, key=lambda one: -one.y1)
    assert upper.y1 <= figure.bbox.y1 and lower.y0 >= 0.0 and lower.y1 < upper.y0


@pytest.mark.parametrize(
    "how", [{"model": "ross"}, {"effects": ["sky_radiation", "wind_direction"]}]
)
def test_the_call_of_a_fit_makes_it_again(how):
    data = simulator.record(days=20, step=1800)
    data = data.drop(columns=["wind_speed"] if how.get("model") == "ross" else [])
    fit, names = fit_fem(data, **how), {"pvlib_fem": pvlib_fem, "data": data}
    exec(fit_call(fit), names)
    assert names["fit"].coefficients == fit.coefficients


def test_one_test_day_is_one_day():
    loop = close_loop(simulator.record(days=2, step=900, start="2023-06-01"))
    assert loop.fit.test_days == 1
    assert "on 1 test day: " in str(loop) and "1 test day ·" in loop.report()


def test_the_call_of_a_loop_has_the_altitude_that_was_given(closed):
    """Clear skies are of it; that of pvlib's map is another."""
    high = Location(49.4, 8.7, "Etc/GMT-1", altitude=1500)
    loop = replace(closed, place=closed.place | {"location": high})
    where = re.search(r"location=(Location\(.*\))", loop_call(loop))[1]
    assert repr(eval(where)) == repr(high)


SHOWN = (("rain", 0.31), ("season", 0.12))


def test_what_to_measure_next_is_what_is_open_the_largest_first(closed, page):
    items = advice.to_measure(closed)
    start = page.texts.index("What to measure next")
    # one measurement may decide on two findings
    once = dict.fromkeys(what for what, _ in items)
    shown = [page.texts.index(what, start) for what in once]
    assert shown == sorted(shown)
    decided = ("ambiguous", "hint", "unexplained")
    open_ = [f.gain for f in closed.finding_objects if f.verdict in decided]
    sizes = [re.search(r"([\d.]+) K$", why) for _, why in items]
    sizes = [float(size[1]) for size in sizes if size]
    assert sizes == [round(gain, 2) for gain in sorted(open_, reverse=True)]
    hours = "a column that records what happens between 9 and 16 h at weekends"
    assert hours in [what for what, _ in items]
    # the columns that were taken away, each with what it is for
    by_power = "electrical_output, modules_covered, sensor_covered, outage"
    assert ("p_dc_per_area", f"would test {by_power}") in items[len(sizes) :]
    assert ("snow_depth", "would test snow") in items[len(sizes) :]


def test_columns_that_test_most_come_first(record, place):
    bare = close_loop(record[list(COLUMNS)])
    items = [item for item in advice.to_measure(bare) if "would test" in item[1]]
    counts = [why.count(",") for _, why in items]
    assert counts == sorted(counts, reverse=True)
    told = dict(items)
    assert told["precipitation"] == "would test rain, soiling"
    assert told["relative_humidity"].startswith("would test air_elsewhere")
    given = next(what for what in told if what.startswith("location"))
    assert "incidence_angle" in told[given]
    useless = record[list(COLUMNS)].assign(p_dc_per_area=100.0)
    told = dict(advice.to_measure(close_loop(useless, **place)))
    assert told["p_dc_per_area"] == (
        "would test electrical_output, modules_covered, sensor_covered, outage; here "
        "p_dc_per_area is constant"
    )
    assert not any(what.startswith("location") for what in told)


def test_no_column_is_asked_for_by_an_effect_that_was_tested():
    """Power of one kind tests what power of another would."""
    for name in ("electrical_output", "modules_covered", "sensor_covered", "outage"):
        assert ("power_dc",) in advice.column_sets(name, COLUMNS)
        assert advice.column_sets(name, (*COLUMNS, "power_ac")) == []
    # an estimate from the usual inputs is no test
    sky = advice.column_sets("sky_radiation", COLUMNS)
    assert sky == [("longwave_down",), ("relative_humidity",)]


def test_more_days_are_for_what_more_days_would_show(closed):
    hidden = {name: because(Reason.DETECTABLE, gain=gain) for name, gain in SHOWN}
    alike = {"wind_shape": because(Reason.COLLINEAR)}
    (item,) = advice.longer_record(replace(closed, untestable={**hidden, **alike}))
    assert item == (
        "more days",
        "would show season, rain, here from 0.12 to 0.31 K only",
    )
    assert not [*advice.longer_record(replace(closed, untestable=alike))]


def test_the_first_error_names_the_dynamics_of_its_model(closed):
    """Also where what every module has is in it, or an effect that is held."""
    words = first_model(closed)
    form = {"ewm": "the paper's form", "balance": "heat balance"}[closed.fit.dynamics]
    assert closed.base == "+radiative_loss"
    assert f"dynamics ({form}) and longwave exchange of every module; without" in words
    table = closed.table.rename(index={"+radiative_loss": "+rain"})
    assert f"dynamics ({form}) and rain; without" in first_model(
        replace(closed, base="+rain", table=table)
    )


def test_where_nothing_could_be_weighed_days_come_first():
    data = datasets.synthetic(6, 1800)[list(COLUMNS)]
    (what, why), *_ = advice.to_measure(close_loop(data))
    assert what == "more days"
    assert why == "this record has too few to leave any out"


@pytest.mark.parametrize(
    ("columns", "strength", "roses"),
    [
        ([], 1.5, []),
        (["wind_direction"], 0.0, [""]),
        (["wind_direction"], 1.5, ["B", "A"]),
    ],
)
def test_a_rose_for_each_wind_that_has_a_direction(columns, strength, roses):
    """Before and after, where the direction tells something."""
    effects = simulator.PHYSICS | {"wind_direction": strength}
    data = simulator.record(effects=effects, days=84, step=900, start="2023-04-01")
    loop = close_loop(data[[*COLUMNS, *columns]])
    assert ("wind_direction" in loop.effects) == (len(roses) == 2)
    shown = [
        text for text in Page(loop.to_html()).texts if "wind direction and" in text
    ]
    shown = [text for text in shown if "mean residual by" in text.lower()]
    assert len(shown) == len(roses)
    assert all(text.startswith(first) for text, first in zip(shown, roses))


def test_a_picture_says_what_it_is(page):
    named = [value for name, value in page.attributes if name == "aria-label"]
    assert len(named) == page.tags.count("figure") == page.tags.count("svg")
    assert set(named) <= set(page.texts)


def test_a_long_record_with_nothing_to_weigh_is_not_called_short(record, place):
    page = close_loop(record, effects=[], **place).to_html()
    assert "too short" not in page and "too few" not in page
    assert "No effect of the catalogue and no column" in page


@pytest.fixture(scope="module")
def shifted(place):
    """A file whose times are in another zone than they say, by two hours."""
    effects = simulator.PHYSICS | {"file_shift": 120.0}
    data = simulator.record(effects=effects, days=70, step=1800, start="2023-04-01")
    return close_loop(data, **place)


def test_a_wrong_clock_stands_first(shifted):
    page = Page(shifted.to_html())
    said = [text for text in page.texts if "Timestamps of the file run" in text]
    assert "120 min ahead of the sun" in said[0]
    heading = next(text for text in page.texts if text.startswith("Module temp"))
    assert page.texts.index(said[0]) < page.texts.index(heading)
    assert shifted.report().splitlines()[1].startswith("NOT CORRECTED")
    assert "file_shift" not in page.text + shifted.report()
    assert "(the sun fits Etc/GMT-3)" in said[0]


FITTING = [
    (None, 2.0, "Etc/GMT-3"),
    (None, -5.1, "Etc/GMT+4"),
    (None, 0.5, ""),
    ("UTC", -7.0, "Etc/GMT+7"),
    ("Asia/Kolkata", -5.5, "Etc/GMT+0"),
    ("Asia/Kolkata", 2.0, ""),
    ("UTC", -15.0, ""),
]


@pytest.mark.parametrize("tz, late, zone", FITTING)
def test_the_zone_that_fits_the_sun_is_named(tz, late, zone):
    """In whole hours: times without a zone are those of the location, UTC+1."""
    index = pd.date_range("2023-06-01", periods=3, freq="D", tz=tz)
    location = Location(49.0, 8.4, tz="Europe/Berlin")
    assert zone_of_the_sun(index, 3600.0 * late, location) == zone


def test_nothing_later_contradicts_a_wrong_clock(shifted):
    """The place was given: it is reported, and neither missing nor requested."""
    (clock,) = shifted.corrections
    assert clock.fault == "file_shift" and not clock.applied
    assert clock.values["late"] == pytest.approx(120.0, abs=15.0)
    page = Page(shifted.to_html())
    assert "no location" not in page.text + shifted.report()
    for name in ("shading", "incidence_angle"):
        assert shifted.untestable[name].reason is Reason.OFF_THE_SUN
    items = dict(advice.to_measure(shifted))
    assert (
        "shading" in items["the clock of the file, set right (to mend, not to measure)"]
    )
    assert not any(what.startswith("location") for what in items)
    assert any("location=Location(" in text for text in page.texts)
    assert any("surface_tilt=35.0" in text for text in page.texts)


def test_a_column_is_asked_for_once_by_each_effect(record, place):
    """Rain has two forms without the same column."""
    there = record[[*COLUMNS, "relative_humidity"]]
    told = dict(advice.to_measure(close_loop(there, **place)))
    assert told["precipitation"] == "would test rain, soiling"


def test_a_title_stands_on_every_page_as_text(closed, shifted):
    named = Location(49.4, 8.7, tz="Etc/GMT-1", name=SCRIPT)
    loop = replace(closed, place={**closed.place, "location": named})
    for html_ in (closed.to_html(title=SCRIPT), loop.to_html(), fit_html(loop, SCRIPT)):
        page = Page(html_)
        assert SCRIPT in page.texts
        assert "script" not in page.tags
        assert page.text.index(SCRIPT) < page.text.index("Module temperature")


def fit_html(loop, title):
    return loop.fit.to_html(title=title)


def test_kelvins_are_told_as_yield(closed):
    """At the given coefficient; absolute as in the table of errors."""
    rows = {row[0]: row for row in Page(closed.to_html()).rows}
    points = closed.table["energy_error_test"]
    for name, step in (("before", closed.base), ("after", closed.last)):
        share, both, much, little, net = map(float, rows[name][1:])
        assert share == pytest.approx(points[step], abs=0.02)
        assert both == pytest.approx(much - little, abs=0.011)
        assert net == pytest.approx(much + little, abs=0.011)
    twice = {row[0]: row for row in Page(closed.to_html(gamma=-0.007)).rows}
    assert float(twice["after"][2]) == pytest.approx(2 * both, abs=0.011)
    assert float(twice["steady"][5]) == pytest.approx(2 * points["steady"], abs=0.006)
    assert "-0.7 %/K" in closed.to_html(gamma=-0.007)


def test_it_says_what_before_is(closed):
    steady = closed.table.loc["steady", "rmse_test"]
    words = f"without dynamics it is {steady:.2f} K"
    assert any(words in text for text in Page(closed.to_html()).texts)


@pytest.fixture(scope="module")
def fit():
    data = datasets.synthetic(12, 900, seed=3)
    usual = [data[name] for name in COLUMNS]
    return fit_fem(*usual, model="faiman", fixed={"u1": 6.84})


def test_a_fit_has_a_page_as_a_loop_has(fit, tmp_path):
    path = tmp_path / "fit.html"
    page = Page(fit.to_html(path, title="Plant 7"))
    assert path.read_text("utf-8") == fit.to_html(title="Plant 7")
    assert "Plant 7" in page.texts
    assert page.tags.count("figure") == page.tags.count("svg") == 3
    rows = {row[0]: row for row in page.rows}
    assert len(fit.scores)
    for name, line in fit.scores.iterrows():
        assert float(rows[name][1]) == pytest.approx(line["rmse_test"], abs=0.006)
    assert rows["u1"][1:3] == ["6.84", "held"]
    assert float(rows["this fit"][1]) > 0
    assert str(fit) in page.texts and fit.summary.sha256 in page.text
    titles = [title for title in SECTIONS if title in page.texts]
    assert titles == [SECTIONS[i] for i in (1, 2, 3, 7, 12)]
    assert not {"script", "link", "iframe"} & {*page.tags}


def test_notebooks_get_a_table_of_escaped_text(closed, fit):
    for result, words in ((closed, f"driver:{SCRIPT}"), (fit, "u0")):
        brief = Page(result._repr_html_())
        assert "table" in brief.tags and "script" not in brief.tags
        assert any(words in row[0] for row in brief.rows)
        assert len(result._repr_html_()) < 20_000
    ranking = Page(closed.ranking._repr_html_())
    assert {row[0] for row in ranking.rows[1:]} == {*closed.ranking.index}


@pytest.mark.parametrize(
    ("value", "error", "words"),
    [
        (0.020446, 0.036, "0.020 ± 0.036"),
        (1234.5, 340.0, "1230 ± 340"),
        (0.1055, 0.007, "0.1055 ± 0.0070"),
        (-0.0004, 0.0996, "0.00 ± 0.10"),
        (21.934, np.nan, "21.93"),
    ],
)
def test_numbers_have_the_digits_of_their_error(value, error, words):
    assert with_error(value, error) == words


def test_nothing_that_steers_a_terminal_is_printed(closed, fit):
    """Names of columns come from files."""
    evil = "\x1b[2J\x07\x9b31m\r\udc80"
    loop = replace(closed, notes=(evil,), place={**closed.place, "location": None})
    ranked = Ranking(closed.ranking.rename(index={"rain": evil[:-1]}))
    texts = [
        loop.report(),
        loop.to_html(title=evil),
        repr(ranked),
        ranked._repr_html_(),
    ]
    for text in [*texts, str(replace(fit, notes=(evil,)))]:
        assert "�[2J" in text
        assert not {*"\x1b\x07\x9b\r\udc80"} & {*text}
        text.encode("utf-8")
