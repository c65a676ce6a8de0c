"""A logger's file as a frame in the package's names."""

import pandas as pd


def read_file(file, mapped, tz, time_format="ISO8601", **csv):
    """A logger file as a frame with a DatetimeIndex and the package's names."""
    if file.suffix.lower() in (".parquet", ".pq"):
        try:
            data = pd.read_parquet(file)
        except ImportError as error:
            raise ValueError(
                "reading Parquet needs pyarrow: pip install pyarrow"
            ) from error
    else:
        try:
            data = pd.read_csv(file, na_values=["NAN"], **csv)  # as TOA5 writes it
        except UnicodeDecodeError as error:
            raise ValueError(
                f"{file.name} is not in {error.encoding} ({error.reason} at byte "
                f"{error.start}); give --encoding, such as latin-1"
            ) from error
        if data.shape[1] == 1:
            raise ValueError(
                f"{file.name} has the one column {data.columns[0]!r}; give --sep, such "
                "as ';'"
            )
    if (
        isinstance(data.index, pd.DatetimeIndex)
        and mapped.get("time") == data.index.name
    ):
        mapped = {name: column for name, column in mapped.items() if name != "time"}
    absent = [column for column in mapped.values() if column not in data]
    if absent:
        raise ValueError(
            f"{file.name} has no column {', '.join(absent)}; it has "
            f"{', '.join(map(str, data.columns))}"
        )
    if "time" in mapped or not isinstance(data.index, pd.DatetimeIndex):
        time = mapped.get("time", data.columns[0])
        index = times(data[time], time, time_format)
        data = data.drop(columns=time).set_index(index)
    if tz is not None:
        data.index = zoned(data.index, tz)
    # a mapped column takes the name, whatever else the file calls by it, and leaves
    # its own, under which it would be one more driver
    taken = {name: column for name, column in mapped.items() if name != "time"}
    named = {name: data[column] for name, column in taken.items()}
    return data.drop(columns=list(dict.fromkeys(taken.values()))).assign(**named)


def times(column, name, time_format):
    """Times of a column of text; the first bad entry is named."""
    if pd.api.types.is_numeric_dtype(column):
        raise ValueError(
            f"column {name!r} should hold the times and holds numbers; name the "
            "right one with --map time=COLUMN"
        )
    how = {"format": time_format, "errors": "coerce"}
    try:
        parsed = pd.to_datetime(column, **how)
        mixed = parsed.dtype == object  # as older pandas says it
    except ValueError:
        mixed = True
    if mixed:  # offsets that change, as with daylight saving time
        parsed = pd.to_datetime(column, utc=True, **how)
    if parsed.isna().any():
        row = int(parsed.isna().to_numpy().argmax())
        raise ValueError(
            f"column {name!r} holds no time of the format {time_format} in row {row}: "
            f"{column.iloc[row]!r}; give --time-format, such as '%d/%m/%Y %H:%M', or "
            "name the column of times with --map time=COLUMN"
        )
    return pd.DatetimeIndex(parsed, name="time")


def zoned(index, tz):
    """Times in a zone: naive ones are taken as local in it."""
    try:
        if index.tz is None:
            # the hour that an autumn has twice is told by the order of its rows
            return index.tz_localize(tz, ambiguous="infer")
        return index.tz_convert(tz)
    except Exception as error:  # an unknown zone, or an hour that a clock skips
        raise ValueError(
            f"--tz {tz}: {error}; loggers mostly keep standard time, for example "
            "--tz Etc/GMT-1 for one hour east of Greenwich"
        ) from error
