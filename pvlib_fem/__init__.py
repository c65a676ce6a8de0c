"""The temperature of photovoltaic modules, second by second, for pvlib users."""

import lazy_loader

__version__ = "0.1.0"

# what there is stands in __init__.pyi, and is loaded when it is first asked for
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
