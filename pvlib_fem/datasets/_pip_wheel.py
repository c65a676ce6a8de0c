"""Two records from the wheel of another package, which pip downloads."""

import io
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from typing import Any

import pandas as pd

from pvlib_fem.datasets._download import FOLDER, cache, has_hash, in_folder

REQUIREMENT = "pvcopilot==0.1.1"
WHEEL = "pvcopilot-0.1.1-py3-none-any.whl"
SHA256 = "13912b239422b20e797ec1b2646ca98d13653e4ac3d89065cd56fce8c8a1507c"

#: the only files of the wheel that are read
MEMBERS = {
    "eurac_bolzano": "pvcopilot/data/examples/eurac_bolzano_pcSi6_hourly.parquet",
    "nrel_stf": "pvcopilot/data/examples/nrel_stf_golden_hourly.parquet",
}

# the package itself is neither installed nor run; its requirements are outdated
DOWNLOAD = ("pip", "download", "--no-deps", "--ignore-requires-python")
DOWNLOAD += ("--only-binary", ":all:")
# a network that does not answer is given up after half a minute
PATIENCE = ("--timeout", "10", "--retries", "1", "--no-input", "--quiet")
PATIENCE += ("--disable-pip-version-check",)
LONGEST = 600.0  # s, for 17 MB


def record_table(name: str) -> pd.DataFrame:
    """
    The table of a record, as in its file.

    Parameters
    ----------
    name : str
        ``"eurac_bolzano"`` or ``"nrel_stf"``.

    Returns
    -------
    pandas.DataFrame, shape (hours, columns)
        With the names and units of the file.

    Raises
    ------
    ImportError
        If pyarrow is missing.
    OSError
        If the wheel is not at hand and cannot be downloaded.
    ValueError
        If the wheel has another hash.
    """
    try:
        import pyarrow  # noqa: F401
    except ImportError as error:
        raise ImportError(
            f"the record {name} is a Parquet file, which needs pyarrow: "
            "pip install 'pvlib_fem[parquet]'"
        ) from error
    with zipfile.ZipFile(fetch_wheel()) as wheel:
        return pd.read_parquet(io.BytesIO(wheel.read(MEMBERS[name])), engine="pyarrow")


def fetch_wheel() -> Path:
    """Path of the wheel: in the user's folder, in the cache, or downloaded."""
    if path := in_folder(WHEEL, SHA256):
        return path
    path = cache() / WHEEL
    if path.is_file() and has_hash(path, SHA256):
        return path
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        # in the same folder, so that the rename is atomic
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            os.replace(download(Path(folder)), path)
    except OSError as error:
        raise OSError(
            f"{WHEEL}, a public file with this record, is not at hand and pip did not "
            f"get it ({error}). Go online once, or download it elsewhere with "
            f"'{' '.join(DOWNLOAD)} {REQUIREMENT}', put it into a folder and name that "
            f"in the environment variable {FOLDER}."
        ) from None
    return path


def download(folder: Any) -> Path:
    """Download the wheel with pip and its own configuration into a folder."""
    command = [sys.executable, "-m", *DOWNLOAD, *PATIENCE, "--dest", str(folder)]
    try:
        done = subprocess.run(
            [*command, REQUIREMENT],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=LONGEST,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise OSError(f"not done within {LONGEST:.0f} s") from None
    path = folder / WHEEL
    if done.returncode or not path.is_file():
        said = done.stderr.strip().rpartition("\n")[-1].removeprefix("ERROR: ")
        raise OSError(said or f"exit code {done.returncode}")
    if not has_hash(path, SHA256):
        raise ValueError(
            f"the {WHEEL} that pip got is not the pinned file: its sha256 differs"
        )
    return path
