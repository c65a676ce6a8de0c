"""Windows of the sky: an obstacle is found at any place, and no other is found."""

import numpy as np
import pandas as pd
import pytest
from pvlib.location import Location

from pvlib_fem._statistics.extremes import rounded_argmax
from pvlib_fem._statistics.leastsquares import orthonormal
from pvlib_fem.drivers import sun
from pvlib_fem.effects import _windows as windows
from pvlib_fem.effects._windows import find_windows
from pvlib_fem.effects.catalogue.shading import within_any

LEAST = 0.1  # K, that each window has to take
#: obstacles with edges anywhere, the transmitted share of beam, and the module's site
OBSTACLES = {
    "a house": (50.0, [(112.6, 141.3, 0.0, 26.4)]),
    "in the west": (35.0, [(222.7, 251.3, 0.0, 33.3)]),
    "a branch": (50.0, [(117.7, 150.2, 13.6, 31.4)]),
    "two houses": (50.0, [(103.4, 127.2, 0.0, 28.4), (226.1, 257.5, 0.0, 23.2)]),
    "a skyline": (
        35.0,
        [(91, 100.5, 0, 17.3), (100.5, 113.2, 0, 37.5), (113.2, 124, 0, 25.4)],
    ),
    "in the north": (-33.0, [(338.4, 24.7, 0.0, 44.6)]),
}


class Scene:
    """Two hundred days of sun and clouds on a module, in steps of five minutes."""

    def __init__(self, latitude, seed=0):
        random = np.random.default_rng(seed)
        index = pd.date_range("2023-04-01", periods=200 * 288, freq="5min", tz="UTC")
        place = sun(index, Location(latitude, 0.0))
        self.azimuth = place["solar_azimuth"].to_numpy()
        self.elevation = 90.0 - place["solar_zenith"].to_numpy()
        self.weeks = np.arange(len(index)) // (7 * 288)
        up = np.maximum(np.sin(np.radians(self.elevation)), 0.0)
        sky = np.repeat(random.uniform(size=len(index) // 6) < 0.5, 6)
        # K that all of the beam is worth
        self.tangent = -25.0 * up**0.5 * (up > 0) * sky
        self.noise = random.normal(0, 0.5, len(index))
        self.nuisance = [self.tangent, up, up * sky * up, np.ones(len(index))]

    def rest(self, windows, share):
        """Residual of a fit that has the other columns and not the windows."""
        inside = within_any(windows, self.azimuth, 90.0 - self.elevation)
        whole = share * self.tangent * inside + self.noise
        known = np.column_stack(self.nuisance)
        return whole - known @ np.linalg.lstsq(known, whole, rcond=None)[0]

    def find(self, rest, sign=1.0, tangent=None):
        return find_windows(
            rest,
            self.tangent if tangent is None else tangent,
            orthonormal(self.nuisance),
            (self.azimuth, self.elevation),
            self.weeks,
            sign,
            LEAST,
        )

    def share(self, rest, windows):
        """Fit of a share for some windows."""
        inside = within_any(windows, self.azimuth, 90.0 - self.elevation)
        columns = np.column_stack([self.tangent * inside, *self.nuisance])
        return np.linalg.lstsq(columns, rest, rcond=None)[0][0]


@pytest.mark.parametrize("name", OBSTACLES)
@pytest.mark.parametrize("share", [0.8, 0.4])
def test_the_share_of_an_obstacle_is_found_wherever_its_edges_are(name, share):
    latitude, obstacle = OBSTACLES[name]
    scene = Scene(latitude)
    rest = scene.rest(obstacle, share)
    gain, windows = scene.find(rest)
    assert gain > 0
    assert scene.share(rest, windows) == pytest.approx(share, rel=0.1)
    true, found = (
        within_any(some, scene.azimuth, 90.0 - scene.elevation)
        for some in (obstacle, windows)
    )
    beam = scene.tangent**2
    assert beam[true != found].sum() < 0.15 * beam[true].sum()


def test_what_the_sensor_does_not_see_is_found_with_the_other_sign():
    scene, obstacle = Scene(50.0), OBSTACLES["a house"][1]
    rest = scene.rest(obstacle, -0.8)
    assert scene.find(rest, sign=1.0)[0] < 0.1 * scene.find(rest, sign=-1.0)[0]
    windows = scene.find(rest, sign=-1.0)[1]
    assert scene.share(rest, windows) == pytest.approx(-0.8, rel=0.1)


@pytest.mark.parametrize("seed", range(10))
def test_where_nothing_stands_nothing_is_found(seed):
    """Nor where a fault of one day looks like an obstacle."""
    scene = Scene(50.0, seed)
    assert scene.find(scene.rest([], 0.0)) == (0.0, ())
    once = scene.tangent * (np.arange(len(scene.tangent)) // 288 == 90)
    assert scene.find(scene.rest([], 0.0) + 0.8 * once) == (0.0, ())


def test_what_lasts_for_some_days_is_no_obstacle(monkeypatch):
    """Snow of ten days in spring, at heights of the noon sun that no other has."""
    scene = Scene(50.0)
    scene.noise[50 * 288 :] = 0.0
    days = np.arange(len(scene.noise)) // 288
    first = (days < 10) & (abs(scene.azimuth - 180.0) < 20.0)
    for column in (scene.tangent, *scene.nuisance[:1]):
        column[days >= 50] = 0.0  # a record of winter and spring
    whole = 0.8 * scene.tangent * first + scene.noise
    known = np.column_stack(scene.nuisance)
    rest = whole - known @ np.linalg.lstsq(known, whole, rcond=None)[0]
    assert scene.find(rest) == (0.0, ())
    monkeypatch.setattr(windows, "as_normal", lambda errors, draws: errors)
    assert scene.find(rest)[1]


def test_a_record_without_sun_has_no_window():
    scene = Scene(50.0)
    dark = np.zeros(len(scene.tangent))
    assert scene.find(scene.noise, tangent=dark) == (0.0, ())


def test_rounding_does_not_say_where_an_edge_stands():
    """Edges in a part of the sky without sun gain the same but for the last bits."""
    gains = np.array([[0.0, 2.0, 3.0], [3.0, 1.0, 3.0]])
    for noise in (0.0, 1e-13, -1e-13):
        assert rounded_argmax(gains * (1.0 + noise * np.arange(6).reshape(2, 3))) == 2
    assert rounded_argmax(gains * [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0 + 1e-6]]) == 5
    assert rounded_argmax([-2.0, -1.0, -1.0]) == 1 and rounded_argmax([0.0, 0.0]) == 0
