"""
A fit's thermal parameters in the conventions of pvlib, PVsyst, SAM and the IEC.

``fit.thermal_parameters()`` makes the table (``table.py``). ``steady.py`` has what
follows from the coefficients alone; ``nmot.py``, ``unit_mass.py`` and ``hottest.py``
what needs the record.
"""
