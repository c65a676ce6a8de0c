"""
A fit's thermal parameters in the conventions of pvlib, PVsyst, SAM and the IEC.

``fit.thermal_parameters()`` makes the table (``table.py``). ``steady.py`` has the
parameters from the coefficients alone; ``nmot.py``, ``unit_mass.py`` and
``hottest.py`` have parameters that need the record.
"""
