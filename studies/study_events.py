"""
How many outages and covers of 3 K are found in two measured records of years.

Run as
``python studies/study_events.py [--draws 40] [--size 3] [--hours 6]``. Events are
put into power and module temperature, or into the irradiance, on drawn days of each
record (:func:`pvlib_fem.recover_events`).
"""

import argparse

from pvlib.location import Location

from pvlib_fem import datasets, recover_events

RECORDS = ("eurac_bolzano", "nrel_stf")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=40)
    parser.add_argument("--size", type=float, default=3.0)
    parser.add_argument("--hours", type=int, default=6)
    options = vars(parser.parse_args())
    for name in RECORDS:
        data = datasets.load(name)
        site = [data.attrs[part] for part in ("latitude", "longitude", "tz")]
        found = recover_events(data, location=Location(*site), **options)
        shares = found.groupby("effect")["found"].agg(["size", "mean"])
        print(name, shares.round(3).to_string(), found.attrs, sep="\n")


if __name__ == "__main__":
    main()
