"""The temperature of photovoltaic modules, second by second, for pvlib users."""

import warnings
from typing import Any

import lazy_loader

# the public names are in __init__.pyi; each is loaded at its first use
_attribute, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

#: names that are valid until 0.2, and their replacements
_RENAMED = {
    "compare": "compare_models",
    "recover": "recover_effects",
    "screen": "screen_record",
    "translate": "translate_coefficients",
}


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    if name not in _RENAMED:
        return _attribute(name)
    warnings.warn(
        f"pvlib_fem.{name} is called {_RENAMED[name]} now, and 0.2 will not know the "
        f"old name: write pvlib_fem.{_RENAMED[name]}",
        FutureWarning,
        stacklevel=2,
    )
    return _attribute(_RENAMED[name])


def _version() -> str:
    """The version of the tag from which the package was built."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(__name__)
    except PackageNotFoundError:  # not installed, only on the path
        return "0.0"
