"""The RC stack against the paper's table of a glass-Tedlar module."""

import pytest

from pvlib_fem import layers


@pytest.fixture(scope="module")
def table():
    return layers.stack(*layers.glass_tedlar())


@pytest.mark.parametrize(
    ("row", "r", "c", "tau"),  # mK/(W/m²), kJ/(m²K), s: the paper's first table
    [
        ("air film, front", 65.22, 0.0, 0.1),
        ("frame, front", 0.01, 4.9, 0.0),
        ("glass", 1.78, 4.8, 8.5),
        ("Tedlar", 1.50, 0.5, 0.7),
        ("front", 3.22, 10.8, 34.8),
        ("back", 2.94, 6.5, 19.0),
        ("front + air", 68.43, 10.8, 740.6),
        ("back + air", 68.16, 6.5, 441.2),
        ("total", 1.54, 17.3, 26.5),
        ("total + air", 34.15, 17.3, 590.6),
    ],
)
def test_the_papers_table_comes_out(table, row, r, c, tau):
    assert 1e3 * table.loc[row, "r"] == pytest.approx(r, abs=0.006)
    assert 1e-3 * table.loc[row, "c"] == pytest.approx(c, abs=0.06)
    assert table.loc[row, "tau"] == pytest.approx(tau, abs=0.06)


def test_the_papers_mass_comes_out(table):
    assert table.loc["total", "mass"] == pytest.approx(21.42, abs=0.01)


def test_without_the_frame_the_time_constant_is_less_than_half():
    """The paper: tau_0 of about 259 s."""
    table = layers.stack(*layers.glass_tedlar(frame=0.0))
    assert table.loc["total + air", "tau"] == pytest.approx(259, abs=0.5)


def test_the_papers_frame_counts_by_its_own_area(table):
    """By the module's area the figures in the docstring come out."""
    frame = table.loc[["frame, front", "frame, back"], "c"].sum()
    c = table.loc["total", "c"] - frame * (1.0 - 0.296 / 1.6)
    assert 1e-3 * c == pytest.approx(9.4, abs=0.05)
    assert c * table.loc["total + air", "r"] == pytest.approx(320, abs=1)


def test_a_thick_back_film_is_a_module_on_a_roof():
    """The paper: a film of 4.2 mm gives 50 mK/(W/m²), U0 = 20.0 as in PVsyst."""
    table = layers.stack(*layers.glass_tedlar(back_film=4.2e-3))
    r = table.loc["total + air", "r"]
    assert 1e3 * r == pytest.approx(50.0, abs=0.05)
    assert 1 / r == pytest.approx(20.0, abs=0.05)


def test_a_layer_must_be_of_something():
    with pytest.raises(ValueError, match="glass: conductivity = 0 must be positive"):
        layers.Layer("glass", 3e-3, 0, 3000, 500)
    for thickness in (-1, float("nan")):
        with pytest.raises(ValueError, match=f"thickness = {thickness} must be 0 or"):
            layers.Layer("glass", thickness, 1.8, 3000, 500)
    film = layers.Layer("film", 1e-3, 0.023, 1.2, 1000, is_film=True)
    glass = layers.Layer("glass", 3e-3, 1.8, 3000, 500)
    with pytest.raises(ValueError, match="front has no layer other than its air film"):
        layers.stack([film], [glass])


def test_layers_may_come_one_by_one(table):
    front, back = layers.glass_tedlar()
    assert layers.stack(iter(front), iter(back)).equals(table)
