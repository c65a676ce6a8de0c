"""Results on disk: a file for each system, and tables made from them."""

import hashlib
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from pvlib_fem._stored import as_json, replacing, saved, stamped
from pvlib_fem.fleet._systems_table import System, labels_of, systems_of
from pvlib_fem.fleet._tasks import COEFFICIENT, FINDING, ROW
from pvlib_fem.types import FilePath

if TYPE_CHECKING:
    from pyarrow import Schema

NONE = stamped("pvlib_fem fleet, failed", {})  # a file without a result
GROUP = 1000  # systems of a row group of a table
TABLES = ("systems", "coefficients", "findings")
STATE = ("task", "state", "message")  # columns of a system without a result, too


def name_of(identity: str) -> str:
    """A unique name for a system's files that is valid on any disk."""
    code = hashlib.sha256(identity.encode("utf-8", "surrogatepass")).hexdigest()
    plain = re.sub(r"[^A-Za-z0-9_-]+", "-", identity)[:60]
    return f"{code[:2]}/{plain}-{code[:12]}"  # 256 folders


def result_path(out: FilePath, identity: str) -> Path:
    """
    File of a system's result.

    Parameters
    ----------
    out : path-like
        Folder of the fleet's results.
    identity : str
        Identity of the system.

    Returns
    -------
    Path
        It need not exist.
    """
    return Path(out, "results", f"{name_of(identity)}.json")


def page_path(out: FilePath, identity: str) -> Path:
    """
    File of a system's page.

    Parameters
    ----------
    out : path-like
        Folder of the fleet's results.
    identity : str
        Identity of the system.

    Returns
    -------
    Path
        It need not exist.
    """
    return Path(out, "pages", f"{name_of(identity)}.html")


def write_result(
    out: FilePath,
    identity: str,
    head: Mapping[str, Any],
    result: Mapping[str, Any] | None = None,
) -> None:
    """
    Write a system's result; a failed write leaves no file.

    Parameters
    ----------
    out : path-like
    identity : str
    head : dict
        ``key``, ``state``, ``message``, ``row``, ``coefficients``, ``findings``.
    result : dict, optional
        Content that ``to_json`` writes, so that ``from_json`` reads the file.
    """
    path = result_path(out, identity)
    content = {**as_json({"fleet": {"id": identity, **head}}), **(result or NONE)}
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        saved(json_text(content) + "\n", path)
    except OSError as error:
        raise OSError(
            f"the result of system {identity} cannot be written to {out} "
            f"({error.strerror or error}); earlier results are kept: make room, and "
            "run the same again to go on"
        ) from error


def stored_content(out: FilePath, identity: str) -> dict[str, Any] | None:
    """
    Content of a system's file.

    Parameters
    ----------
    out : path-like
        Folder of the fleet's results.
    identity : str
        Identity of the system.

    Returns
    -------
    dict or None
        The content; ``"fleet"`` has the head that `keep` wrote. None without a file
        that `keep` wrote.
    """
    try:
        path = result_path(out, identity)
        content = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, ValueError):
        return None
    head = content.get("fleet") if isinstance(content, dict) else None
    whole = isinstance(head, dict) and {"key", "state", "message"} <= {*head}
    return content if whole else None


def put_page(out: FilePath, identity: str, html: str | None) -> None:
    """
    Write a system's page, or remove that of an older result.

    Parameters
    ----------
    out : path-like
        Folder of the fleet's results.
    identity : str
        Identity of the system.
    html : str or None
        The page; None removes the file.
    """
    path = page_path(out, identity)
    if html is None:
        path.unlink(missing_ok=True)
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    saved(html, path)


def check_labels(table: pd.DataFrame) -> None:
    """
    Refuse labels of which the results have a column with that name.

    Parameters
    ----------
    table : DataFrame
        An opened table of systems.

    Raises
    ------
    ValueError
        If a result would replace a label.
    """
    labels = labels_of(table)
    if taken := [name for name in (*STATE, *ROW, "json") if name in labels]:
        raise ValueError(
            f"the table of systems has a column {taken[0]!r}, and so have the results; "
            f"call it otherwise, such as {f'{taken[0]}_label'!r}"
        )


def write_tables(out: FilePath, table: pd.DataFrame, task: str) -> None:
    """
    Make the tables of all results; a failed write leaves the old tables.

    Parameters
    ----------
    out : path-like
    table : DataFrame
        An opened table of systems: its rows are the rows of the result, in order.
    task : str
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    schemas = schemas_of(table)
    rows: dict[str, list[dict[str, Any]]] = {name: [] for name in TABLES}
    paths = [replacing(Path(out, f"{name}.parquet")) for name in TABLES]
    with paths[0] as a, paths[1] as b, paths[2] as c:
        files = dict(zip(TABLES, (a, b, c)))
        writers = {
            name: pq.ParquetWriter(files[name], schemas[name], compression="zstd")
            for name in TABLES
        }

        def flush() -> None:
            for name, writer in writers.items():
                typed = [with_infinities(row, schemas[name]) for row in rows[name]]
                batch = pa.Table.from_pylist(typed, schema=schemas[name])
                writer.write_table(batch)
                rows[name].clear()

        try:
            for i, system in enumerate(systems_of(table), 1):
                append_result(rows, system, stored_content(out, system.id), task)
                if i % GROUP == 0:
                    flush()
            flush()
        finally:
            for writer in writers.values():
                writer.close()


def schemas_of(table: pd.DataFrame) -> "dict[str, Schema]":
    """Names and types of the tables' columns."""
    import pyarrow as pa

    kinds = {str: pa.string(), float: pa.float64(), int: pa.int64(), bool: pa.bool_()}
    head = {"id": str, **dict.fromkeys(labels_of(table), str)}
    place = ("latitude", "longitude", "surface_tilt", "surface_azimuth", "pdc0")
    state = dict.fromkeys(("file", *STATE), str)
    columns = {
        "systems": {**head, **dict.fromkeys(place, float), **state, **ROW},
        "coefficients": {"id": str, **COEFFICIENT},
        "findings": {"id": str, "site": str, **FINDING},
    }
    return {
        name: pa.schema(
            [(column, kinds[kind]) for column, kind in wanted.items()]
            + [("json", pa.string())] * (name != "coefficients")
        )
        for name, wanted in columns.items()
    }


def append_result(
    rows: Mapping[str, list[dict[str, Any]]],
    system: System,
    content: dict[str, Any] | None,
    task: str,
) -> None:
    """Append the content of a system's file to the tables."""
    head: dict[str, Any] = {"state": "not run", "message": ""}
    if content:
        head = content["fleet"]
    if head.get("task", task) != task:  # from another run into the same folder
        content, head = None, {"state": "not run", "message": ""}
    files = " | ".join(system.files)
    row = {"id": system.id, **system.labels, **system.place, "pdc0": system.pdc0}
    row |= {"file": files, "task": task, **head.get("row", {})}
    row |= {name: head[name] for name in ("state", "message")}
    if content and head["state"] == "done":
        result = {name: part for name, part in content.items() if name != "fleet"}
        row["json"] = json_text(result)
    rows["systems"].append(row)
    for one in head.get("coefficients", ()):
        rows["coefficients"].append({"id": system.id, **one})
    for one in head.get("findings", ()):
        json_ = json_text(one["content"]) if "content" in one else None
        head_ = {"id": system.id, "site": system.labels["site"], "json": json_}
        rows["findings"].append({**one, **head_})


def with_infinities(row: Mapping[str, Any], schema: "Schema") -> dict[str, Any]:
    """A row with infinities as numbers instead of texts."""
    kinds = {name: str(schema.field(name).type) for name in schema.names}
    return {
        name: float(row[name])
        if kind == "double" and row.get(name) == "inf"
        else row.get(name)
        for name, kind in kinds.items()
    }


def json_text(content: Any) -> str:
    return json.dumps(content, ensure_ascii=False, allow_nan=False)
