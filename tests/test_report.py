"""The page is the printed report with pictures, and nothing that harms."""

import hashlib
import html
import re
from html.parser import HTMLParser

import matplotlib.pyplot as plt
import numpy as np
import pytest
from pvlib.location import Location

from pvlib_fem import datasets, simulator
from pvlib_fem.loop.close import close_loop
from pvlib_fem.reasons import Reason
from pvlib_fem.record.columns import COLUMNS
from pvlib_fem.record.summary import digest
from pvlib_fem.report import advice

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
    data = data.drop(columns=["longwave_down", "snow_depth", "p_dc"])
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
    for name, line in closed.table.iterrows():
        keys = ("rmse_test", "rmse_test_day", "rmse_test_night", "mbe_test")
        shown = [float(value) for value in rows[name][1:5]]
        np.testing.assert_allclose(shown, line[list(keys)], atol=0.00501)


def test_it_has_every_finding_and_what_is_not_testable(closed, page):
    verdicts = {finding.verdict for finding in closed.findings}
    assert len(verdicts) > 1
    for finding in closed.findings:
        assert f"{finding.gain:.2f} K" in page.text
        names = finding.where if finding.verdict == "unknown" else finding.candidates
        for name in names:
            assert name in page.text
    for name, why in closed.untestable.items():
        assert name in page.text
        if why.reason is Reason.DETECTABLE:
            assert f"{name} below {why.values['gain']:.2g} K" in page.text
        else:
            assert str(why) in page.text
    for note in closed.notes:
        assert note in page.text


def test_it_has_every_coefficient(closed, page):
    rows = {row[0]: row for row in page.rows}
    for name, value in closed.fit.coefficients.items():
        assert float(rows[name][1]) == pytest.approx(value, rel=1e-4)


def test_it_has_the_printed_report_to_the_letter(closed, page):
    assert str(closed) in page.texts


def test_it_begins_with_what_was_found(closed, page):
    error = closed.table["rmse_test"]
    before = error["fem" if closed.fit.dynamics == "ewm" else "balance"]
    heading = f"Module temperature: {before:.2f} K before, {error.iloc[-1]:.2f} K after"
    assert heading in page.texts
    first = page.text.index("Errors by step")
    for name in closed.effects:
        assert name in page.text[:first]


def test_names_of_columns_are_text_and_nothing_else(closed, page):
    assert f"driver:{SCRIPT}" in closed.effects
    assert any(SCRIPT in text for text in page.texts)
    assert not {"script", "iframe", "object", "link"} & set(page.tags)
    assert not [name for name, _ in page.attributes if name.startswith("on")]
    assert html.escape(SCRIPT) in closed.to_html()


def test_it_needs_nothing_from_outside(page):
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
    assert page.tags.count("figure") == 4  # no effect, and no wind direction


def test_without_an_effect_there_is_no_before():
    data = datasets.synthetic(60, 1800)[list(COLUMNS)]
    loop = close_loop(data)
    page = Page(loop.to_html())
    assert loop.effects == []
    assert any("Nothing in the record asks for" in text for text in page.texts)
    assert not any("Before" in text for text in page.texts)


def test_what_is_missing_is_counted():
    data = datasets.synthetic(60, 1800)[list(COLUMNS)]
    data.iloc[100:150, 1] = np.nan
    data.iloc[200:203, 3] = 400.0
    rows = Page(close_loop(data).to_html()).rows
    assert ["temp_air", "50", "0"] in rows
    assert ["temp_module", "0", "3"] in rows


def test_its_sections_are_in_order(page):
    titles = [title for title in SECTIONS if title in page.texts]
    assert titles == list(SECTIONS)
    places = [page.texts.index(title) for title in titles]
    assert places == sorted(places)


SECTIONS = (
    "Errors by step",
    "Pictures",
    "Coefficients",
    "What the record cannot tell",
    "What is left unexplained",
    "What to measure next",
    "Not testable",
    "The state of the data",
    "How to reproduce it",
)


def test_what_to_measure_next_is_what_is_open_the_largest_first(closed, page):
    items = advice.to_measure(closed)
    start = page.texts.index("What to measure next")
    shown = [page.texts.index(what, start) for what, _ in items]
    assert shown == sorted(shown)
    decided = ("class", "suggestive", "unknown")
    open_ = [f.gain for f in closed.findings if f.verdict in decided]
    sizes = [re.search(r"([\d.]+) K$", why) for _, why in items]
    sizes = [float(size[1]) for size in sizes if size]
    assert sizes == [round(gain, 2) for gain in sorted(open_, reverse=True)]
    hours = "a column that follows hour 9–16 × weekend"
    assert hours in [what for what, _ in items]
    # the columns that were taken away, each with what it is for
    assert ("p_dc", "would test electrical_output") in items[len(sizes) :]
    assert ("snow_depth", "would test snow") in items[len(sizes) :]


def test_columns_that_test_most_come_first(record, place):
    bare = close_loop(record[list(COLUMNS)])
    items = [item for item in advice.to_measure(bare) if "would test" in item[1]]
    counts = [why.count(",") for _, why in items]
    assert counts == sorted(counts, reverse=True)
    told = dict(items)
    assert told["precipitation"] == "would test rain, soiling"
    assert told["relative_humidity"] == "would test sky_radiation"
    given = next(what for what in told if what.startswith("location"))
    assert "incidence_angle" in told[given]
    useless = record[list(COLUMNS)].assign(p_dc=100.0)
    told = dict(advice.to_measure(close_loop(useless, **place)))
    assert told["p_dc"] == "would test electrical_output; here p_dc is constant"
    assert not any(what.startswith("location") for what in told)


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
    shown = [text for text in Page(loop.to_html()).texts if "wind comes from" in text]
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
    assert "none that was weighed" in page
