"""
A fit's thermal parameters in the conventions of pvlib, PVsyst, SAM and the IEC.

``fit.thermal_parameters()`` makes the table (``parameter_table.py``).
``steady_parameters.py`` has the parameters from the coefficients alone; ``nmot.py``,
``unit_mass.py`` and ``t98.py`` have parameters that need the record.
"""
