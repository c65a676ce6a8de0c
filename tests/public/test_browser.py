"""The loop's page in a browser: on a desk and on a phone, by day and by night."""

import os
import re
import shutil

import pytest
from pvlib.location import Location

from pvlib_fem import close_loop, simulator

REQUIRED = os.environ.get("PVLIB_FEM_BROWSER") == "required"
NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
# it runs in containers, without a card, and asks nobody for updates
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
WIDTHS = {"desktop": (1280, 800), "phone": (390, 844)}
SMALLEST = 10  # px, of letters in a picture
READABLE = 4.5  # contrast of text, WCAG 2.1 success criterion 1.4.3


def without_browser(reason):
    """Skip, or fail where a browser is required."""
    (pytest.fail if REQUIRED else pytest.skip)(f"no browser: {reason}")


@pytest.fixture(scope="module")
def browser():
    try:
        from playwright.sync_api import Error, sync_playwright
    except ImportError:
        without_browser("Playwright is not installed: pip install playwright")
    with sync_playwright() as playwright:
        # without one at hand, that which `playwright install chromium` brings
        path = next(filter(None, map(shutil.which, NAMES)), None)
        try:
            started = playwright.chromium.launch(executable_path=path, args=FLAGS)
        except Error as error:
            why = str(error).splitlines()[0]
            without_browser(f"{path or 'that of Playwright'}: {why}")
        yield started
        started.close()


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The page of a loop that finds effects and leaves something open."""
    effects = simulator.PHYSICS | {"wind_direction": 1.0, "weekend_exhaust": 1.0}
    data = simulator.record(effects=effects, days=100, step=300, start="2023-04-01")
    data = data.drop(columns=["longwave_down", "p_dc_per_area"])
    site = simulator.RHINE
    place = {
        "location": Location(site.latitude, site.longitude, tz=site.tz),
        "surface_tilt": 35.0,
        "surface_azimuth": 180.0,
    }
    loop = close_loop(data, **place)
    assert "wind_direction" in loop.effects
    assert loop.unexplained
    path = tmp_path_factory.mktemp("page") / "report.html"
    loop.to_html(path)
    return path


CASES = [(place, scheme) for place in WIDTHS for scheme in ("light", "dark")]


@pytest.fixture(scope="module", params=CASES, ids="-".join)
def shown(request, browser, report, tmp_path_factory):
    """The opened page, with all that it says and asks for; a screenshot of it."""
    place, scheme = request.param
    size = dict(zip(("width", "height"), WIDTHS[place]))
    context = browser.new_context(viewport=size, color_scheme=scheme)
    page = context.new_page()
    page.scheme, page.said, page.asked = scheme, [], []
    page.on("console", lambda message: page.said.append(message.text))
    page.on("pageerror", lambda error: page.said.append(str(error)))
    page.on("request", lambda request: page.asked.append(request.url))
    page.goto(report.as_uri())
    name = f"{place}-{scheme}.png"
    page.screenshot(path=tmp_path_factory.mktemp("screen") / name, full_page=True)
    yield page
    context.close()


def test_it_says_nothing_on_the_console_and_asks_nothing_of_the_net(shown, report):
    assert shown.said == []
    assert shown.asked == [report.as_uri()]


def test_nothing_is_wider_than_the_screen(shown):
    width = shown.viewport_size["width"]
    assert shown.evaluate("document.documentElement.scrollWidth") <= width


def test_a_table_that_goes_on_shows_it(shown):
    """By a shade at its edge, which a table that fits does not need."""
    wide = shown.locator(".wide:has(table:not(.text))").first
    held, whole = wide.evaluate("e => [e.clientWidth, e.scrollWidth]")
    assert (whole > held) == (shown.viewport_size["width"] < 500)
    behind = wide.evaluate("e => getComputedStyle(e).backgroundImage")
    assert behind.count("linear-gradient") == 4
    wide.evaluate("e => e.focus({preventScroll: true})")  # by keys, too
    assert wide.evaluate("e => document.activeElement === e")


def test_the_verdict_is_in_the_first_screen(shown):
    heading = shown.locator("h1")
    assert re.fullmatch(r"Module temperature: .+ K after", heading.inner_text())
    box, size = heading.bounding_box(), shown.viewport_size
    assert box["y"] >= 0
    assert box["y"] + box["height"] <= size["height"]
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= size["width"]


def test_every_picture_has_a_size_and_a_caption(shown):
    figures = shown.locator("figure").all()
    assert len(figures) == shown.locator("svg").count() > 5
    for figure in figures:
        box = figure.locator("svg").bounding_box()
        assert box["width"] > 250
        assert 150 < box["height"] < 1.2 * box["width"]
        assert len(figure.locator("figcaption").inner_text()) > 20


def test_letters_of_pictures_are_large_enough(shown):
    """Without a need to enlarge what is seen, and the whole picture on the screen."""
    figures = shown.locator("figure svg").all()
    assert figures
    for figure in figures:
        sizes = figure.evaluate(LETTERS)
        assert min(sizes) >= SMALLEST, sizes
        held, width = figure.bounding_box(), shown.viewport_size["width"]
        assert held["x"] >= 0 and held["x"] + held["width"] <= width


#: sizes of all letters of a picture as they are seen
LETTERS = """svg => {
  const scale = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
  return [...svg.querySelectorAll("text")].map(
    text => scale * parseFloat(getComputedStyle(text).fontSize));
}"""


def test_no_words_of_a_picture_are_on_others(shown):
    """Dates and numbers on an axis, labels of bars, and legends."""
    pictures = shown.locator("figure svg").all()
    assert pictures
    for svg in pictures:
        boxes = svg.evaluate(BOXES)
        assert len(boxes) > 3
        for i, (words, *box) in enumerate(boxes):
            for other, *place in boxes[i + 1 :]:
                assert apart(box, place), (words, other)


def apart(one, other):
    """Whether two boxes (left, top, right, bottom) share no more than an edge."""
    near = [
        min(a, b) - max(c, d)
        for a, b, c, d in zip(one[2:], other[2:], one[:2], other[:2])
    ]
    return min(near) <= 1.0


#: words of a picture and where they are
BOXES = """svg => [...svg.querySelectorAll("text")].map(text => {
  const box = text.getBoundingClientRect();
  return [text.textContent, box.left, box.top, box.right, box.bottom];
})"""


def test_a_table_of_words_needs_no_scrolling(shown):
    """On a phone each row is a list, whose items have the heads of the columns."""
    table = shown.locator("table.text").first
    held, whole = table.locator("xpath=..").evaluate(
        "e => [e.clientWidth, e.scrollWidth]"
    )
    assert whole <= held
    cell = table.locator("td[data-label='device']").first
    label = cell.evaluate("e => getComputedStyle(e, '::before').content")
    assert ("device" in label) == (shown.viewport_size["width"] < 500)


def test_it_is_printed_on_a4(browser, report, tmp_path):
    """Nothing is wider than the page, and it is light."""
    context = browser.new_context(
        viewport={"width": 690, "height": 1000}, color_scheme="dark"
    )
    page = context.new_page()
    page.goto(report.as_uri())
    page.emulate_media(media="print")
    wide = "[...document.querySelectorAll('*')].filter(e => !e.closest('svg') && "
    wide += "e.getBoundingClientRect().right > 691).map(e => e.tagName)"
    assert page.evaluate(wide) == []
    assert luminance(page.evaluate(BACKGROUND, "body")) > 0.9
    page.pdf(path=tmp_path / "report.pdf", format="A4")
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")
    context.close()


def test_text_can_be_read(shown):
    """All of it, that of pictures included, on the colour that lies behind it."""
    page_is_dark = luminance(shown.evaluate(BACKGROUND, "body")) < 0.1
    assert page_is_dark == (shown.scheme == "dark")
    texts = shown.evaluate(TEXTS)
    assert {kind for kind, *_ in texts} >= {"H1", "P", "TD", "FIGCAPTION", "text"}
    for kind, words, ink, behind in texts:
        assert contrast(ink, behind) >= READABLE, (kind, words, ink, behind)


#: background of an element of that name
BACKGROUND = "name => getComputedStyle(document.querySelector(name)).backgroundColor"
#: name, words, colour and background of all elements that hold text themselves
TEXTS = """() => {
  const found = [];
  for (const e of document.querySelectorAll("body *")) {
    const own = [...e.childNodes].filter(n => n.nodeType === 3 && n.data.trim());
    if (!own.length || e.matches("style")) continue;
    const inside = e.closest("svg");
    const style = getComputedStyle(e);
    const ink = inside ? style.fill : style.color;
    let at = inside ? inside.parentElement : e, behind;
    while ((behind = getComputedStyle(at).backgroundColor) === "rgba(0, 0, 0, 0)")
      at = at.parentElement;
    const patch = inside && e.previousElementSibling?.querySelector("path");
    if (patch) behind = getComputedStyle(patch).fill;
    found.push([e.tagName, own[0].data.trim().slice(0, 30), ink, behind]);
  }
  return found;
}"""


def luminance(colour):
    """Relative luminance of ``rgb(…)``, WCAG 2.1."""
    sensor_faults = [int(c) / 255 for c in re.findall(r"\d+", colour)[:3]]
    linear = [
        c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4
        for c in sensor_faults
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    """From 1, the same, to 21, black on white."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)
