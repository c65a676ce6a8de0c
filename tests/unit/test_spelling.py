"""One message, as Python and as a shell spell it."""

import copy
import pickle

import pytest

import pvlib_fem as fem
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.header_units import ForeignUnit
from pvlib_fem._spelling import ShellText, argument, in_shell, refusal
from pvlib_fem.quality._unit_checks import foreign

PARTS = "give ", argument("module_area", 120), ", or ", ShellText("None", ""), "{it}"
PYTHON, SHELL = "give module_area=120, or None{it}", "give --module-area 120, or {it}"


def same(error):
    return error


@pytest.mark.parametrize(
    "way", [same, copy.deepcopy, lambda error: pickle.loads(pickle.dumps(error))]
)
def test_an_error_keeps_both_spellings(way):
    """Also on its way from another process."""
    error = way(refusal(*PARTS))
    assert type(error) is ValueError
    assert (str(error), in_shell(error)) == (PYTHON, SHELL)
    odd = way(foreign("°F", "it is hot", "temp_air", "temp_module").error())
    assert type(odd) is ForeignUnit and str(odd).endswith("(--no-unit-check)")
    assert (odd.columns, odd.unit, odd.why) == (
        ("temp_air", "temp_module"),
        "°F",
        "it is hot",
    )
    assert "Give --unit temp_air=°F --unit temp_module=°F to convert" in in_shell(odd)


@pytest.mark.parametrize(
    "error",
    [OSError(2, "No such file", "a.csv"), ValueError(), ValueError(3), "a text"],
)
def test_what_has_one_spelling_is_said_as_it_is(error):
    assert in_shell(error) == str(error)


def test_a_unit_is_told_without_its_sentence():
    """Both temperatures in °F, as the columns that have to be converted."""
    data = fem.datasets.synthetic(2, 600, seed=1)
    fahrenheit = {n: 1.8 * data[n] + 32 for n in ("temp_air", "temp_module")}
    with pytest.raises(ForeignUnit) as odd:
        fem.fit_fem(**data.assign(**fahrenheit)[[*COLUMNS]])
    assert odd.value.columns == tuple(fahrenheit) and odd.value.unit == "°F"
