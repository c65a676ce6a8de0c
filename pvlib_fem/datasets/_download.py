"""Public files, taken from a user's folder or downloaded once."""

import os
from pathlib import Path

import pooch

FOLDER = "PVLIB_FEM_DATA"  # environment variable: a folder that holds the files

GITHUB = "https://raw.githubusercontent.com"
PVLIB = f"{GITHUB}/pvlib/pvlib-python/7cf4cdbfcb305db0ef2b61d7a5f06d18cc2f9d46"
PECOS = f"{GITHUB}/sandialabs/pecos/19fb849ea0635f84b1aec38bd336de63d47af5ed"

#: file: its public address and sha256
FILES = {
    "sandia_week_1min.csv": (
        f"{PVLIB}/pvlib/data/tmod_sample_data_subset.csv",
        "9687906e1f7fe6608b80b6e89bc09a511a8d359738fb3127f8018f0181f7a528",
    ),
    "MET_2015_11_11.dat": (
        f"{PECOS}/examples/pv/MET_2015_11_11.dat",
        "81fba5fc6c14ecd6d923d7c5da073293273520ed7fe257bfb9fd26fd7d8df224",
    ),
    "Baseline6kW_2015_11_11.dat": (
        f"{PECOS}/examples/pv/Baseline6kW_2015_11_11.dat",
        "724a7b426feae8d5c1718bbe2ff96125906232ebea15334535c27ae7e81acb35",
    ),
}


def fetch(file: str) -> Path:
    """
    Path of a file with the right hash: in the user's folder, or downloaded.

    Parameters
    ----------
    file : str
        Key of ``FILES``.

    Returns
    -------
    pathlib.Path
        In the user's folder or the cache.

    Raises
    ------
    OSError
        If the file is in neither and cannot be downloaded.
    ValueError
        If the file in the user's folder, or the downloaded one, has another hash.
    """
    url, sha256 = FILES[file]
    if path := in_folder(file, sha256):
        return path
    try:
        downloaded = pooch.retrieve(url, f"sha256:{sha256}", fname=file, path=cache())
    except OSError as error:  # no network, or no folder to keep it
        raise OSError(
            f"{file} is not at hand and cannot be downloaded from {url} "
            f"({type(error).__name__}); go online once, or download it elsewhere, put "
            f"it into a folder and name that in the environment variable {FOLDER}"
        ) from None
    return Path(downloaded)


def in_folder(file: str, sha256: str) -> Path | None:
    """
    Path of a file in the user's folder.

    Parameters
    ----------
    file : str
        Name of the file.
    sha256 : str
        Its hash, as hexadecimal digits.

    Returns
    -------
    pathlib.Path or None
        None if the environment variable names no folder, or it has no such file.

    Raises
    ------
    ValueError
        If the file has another hash.
    """
    folder = os.environ.get(FOLDER)
    if not folder or not (path := Path(folder) / file).is_file():
        return None
    if not has_hash(path, sha256):
        raise ValueError(
            f"{path} is not the pinned file (its sha256 differs); remove it, or "
            f"unset {FOLDER}"
        )
    return path


def cache() -> Path:
    """
    Folder of downloaded files.

    Returns
    -------
    pathlib.Path
        In the user's cache; it may not exist yet.
    """
    return Path(pooch.os_cache("pvlib_fem"))


def has_hash(path: Path, sha256: str) -> bool:
    """
    Whether a file has the pinned hash.

    Parameters
    ----------
    path : pathlib.Path
        The file.
    sha256 : str
        Its hash, as hexadecimal digits.

    Returns
    -------
    bool
        False for another hash.
    """
    return pooch.file_hash(str(path)) == sha256
