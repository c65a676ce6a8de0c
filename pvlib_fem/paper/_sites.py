"""The paper's results at its sites: its Table 3, with the mountings of its Table 2."""

import pandas as pd

#: record, mounting, step [s], r_eq,max, r_M, r_film [mK m²/W], c_eq,max, c_M, c_film
#: [kJ/(m² K)], tau_0, tau [s], f [m/s]
ROWS = """\
KUL roof 1 s, flat roof, 1, 35.4, 15.3, 20.1, 37.7, 26.9, 10.8, 576, 410, 11.8
KUL roof 1 min, flat roof, 60, 34.8, 15.3, 19.5, 37.4, 23.8, 13.6, 572, 364, 15.53
KUL roof 5 min, flat roof, 300, 35.4, 15.6, 19.8, 37.5, 22.6, 14.9, 584, 352, 13.82
KUL roof 15 min, flat roof, 900, 31.2, 16.3, 14.9, 53.7, 27.8, 25.9, 874, 453, 10.64
KUL roof 1 h, flat roof, 3600, 31.4, 17.0, 14.4, 211.8,,,,,
KUL tracker, tracker, 60, 12.2, 5.3, 6.9, 102.8, 16.6, 86.2, 545, 87, 2.74
NIST ground 4 10 s, ground, 10, 31.3, 14.0, 17.3, 36.4, 23.6, 12.8, 510, 330, 16.16
NIST ground 4 1 min, ground, 60, 31.2, 14.0, 17.2, 36.5, 23.9, 12.6, 510, 334, 16.56
NIST ground 4 5 min, ground, 300, 32.7, 14.0, 18.7, 35.5, 23.7, 11.8, 497, 332, 14.91
NIST ground 4 15 min, ground, 900, 28.0, 15.1, 12.9, 56.4, 31.0, 25.4, 851, 468, 10.02
NIST ground 4 1 h, ground, 3600, 28.2, 15.3, 12.9, 235.3,,,,,
NIST ground 8 10 s, ground, 10, 36.2, 16.8, 19.4, 30.5, 21.5, 9.0, 513, 361, 19.98
NIST canopy east 10 s, canopy, 10, 41.6, 17.2, 24.4, 27.1, 14.0, 13.1, 465, 241, 12.17
NIST canopy west 10 s, canopy, 10, 38.2, 18.5, 19.7, 27.6, 16.0, 11.6, 511, 295, 14.57
DOE c10hov6, ground, 60, 35.0, 18.5, 16.5, 40.7, 22.3, 18.4, 753, 412, 16.57
DOE t3pg1sv, ground, 60, 34.9, 18.8, 16.1, 39.9, 22.7, 17.2, 750, 426, 17.73
DOE wca0c5m, ground, 60, 30.7, 18.6, 12.1, 31.5, 25.5, 6.0, 586, 474, 33.14
DOE z0aygry, ground, 60, 30.1, 18.0, 12.1, 32.4, 25.4, 7.0, 583, 456, 28.63
DOE lwcb907, ground, 60, 37.2, 19.1, 18.1, 29.7, 20.0, 9.7, 567, 382, 20.24
DOE luemkoy, ground, 60, 35.8, 17.7, 18.1, 32.1, 21.6, 10.5, 567, 381, 20.18
NREL Sanyo, ground, 60, 32.2, 16.3, 15.9, 40.2, 25.7, 14.5, 655, 418, 11.17
Heidelberg 1, ground, 60, 31.5, 19.9, 11.6, 37.8, 16.4, 21.4, 751, 326, 4.8
Heidelberg 2A, ground, 60, 32.2, 16.4, 15.8, 32.4, 28.8, 3.6, 532, 472, 33.76
Heidelberg 2B, sloped roof, 60, 23.1, 16.4, 6.7, 31.8, 25.9, 5.9, 522, 425, 24.33
"""
NUMBERS = (
    *("step", "r_eq_max", "r_m", "r_film", "c_eq_max", "c_m", "c_film"),
    *("tau_0", "tau", "f"),
)
MILLI, KILO = 1e-3, 1e3
FINE = 300.0  # s, longest step of the records in the paper's mean of tau


def table_3() -> pd.DataFrame:
    """
    The paper's Table 3: resistances, capacities and time constants of 24 records [1]_.

    Values are as printed, in SI units.

    Returns
    -------
    DataFrame
        By record: ``mounting``; ``step``, ``tau_0``, ``tau`` [s]; ``r_eq_max``,
        ``r_m``, ``r_film`` [K m²/W]; ``c_eq_max``, ``c_m``, ``c_film`` [J/(m² K)];
        ``f`` [m/s]. NaN where the paper has none.

    Notes
    -----
    Its tau is that of :func:`time_constant`, which decreases as the true time constant
    increases. For the three Heidelberg systems Barry et al. [2]_ found 589, 509 and
    547 s, as quoted in the caption. The paper has 326, 472 and 425 s, in the opposite
    order.

    References
    ----------
    .. [1] B. Herteleer et al., "Investigating methods to improve photovoltaic
       thermal models at second-to-minute timescales", 2022, Tables 2 and 3.
       :doi:`10.22541/au.166922866.68736478`
    .. [2] J. Barry et al., "Dynamic model of photovoltaic module temperature as a
       function of atmospheric conditions", Adv. Sci. Res. 17, 165 (2020).
       :doi:`10.5194/asr-17-165-2020`

    Examples
    --------
    >>> print(*table_3().loc["NIST canopy east 10 s", ["mounting", "tau"]])
    canopy 241.0
    """
    rows = [[cell.strip() for cell in row.split(",")] for row in ROWS.splitlines()]
    table = pd.DataFrame(rows, columns=["record", "mounting", *NUMBERS])
    table = table.set_index("record")
    table[list(NUMBERS)] = table[list(NUMBERS)].apply(pd.to_numeric)
    for names, unit in (("r_eq_max r_m r_film", MILLI), ("c_eq_max c_m c_film", KILO)):
        table[names.split()] *= unit
    return table


def tau_by_mounting() -> pd.DataFrame:
    """
    The paper's time constants by mounting, of records up to 5 min.

    Returns
    -------
    DataFrame
        By mounting: ``mean``, ``lowest`` and ``highest`` tau [s], and ``records``.

    See Also
    --------
    table_3 : the rows, and a remark on them.

    Examples
    --------
    >>> tau_by_mounting().round()["mean"].astype(int).to_dict()
    ... # doctest: +NORMALIZE_WHITESPACE
    {'canopy': 268, 'flat roof': 375, 'ground': 393, 'sloped roof': 425,
     'tracker': 87}
    """
    table = table_3()
    tau = table[table["step"] <= FINE].groupby("mounting")["tau"]
    return pd.DataFrame(
        tau.agg(mean="mean", lowest="min", highest="max", records="count")
    )
