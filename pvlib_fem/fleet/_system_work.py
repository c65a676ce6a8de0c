"""The work on one system, from its files to its result."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import pandas as pd

from pvlib_fem._loop.threads import one_blas_thread
from pvlib_fem._record.layout import layout_of
from pvlib_fem._record.logger_files import frame
from pvlib_fem._spelling import written_argument
from pvlib_fem._stored import as_json, stamped
from pvlib_fem.drivers._record_site import in_local_days, site_of
from pvlib_fem.fleet._store import page_path, put_page, stored_content, write_result
from pvlib_fem.fleet._systems_table import PLACE, System
from pvlib_fem.fleet._tasks import TASKS

if TYPE_CHECKING:
    from fsspec import AbstractFileSystem

#: attributes of a file by which a change is detected, if its file system has them
MARKS = ("size", "mtime", "ETag", "etag", "LastModified", "last_modified", "updated")


#: for each logger of a system: the file system of its files, and their paths
Groups = list[tuple["AbstractFileSystem", list[str]]]


@dataclass(frozen=True)
class Work:
    """Function that a worker calls with each system of a run."""

    out: str
    task: str
    resume: bool = True
    pages: bool = False
    options: dict[str, Any] = field(default_factory=dict)

    def __call__(self, system: System) -> dict:
        """
        Process one system, unless its result is there, and write the result.

        Returns
        -------
        dict
            ``id``, ``state`` (``"done"`` or ``"failed"``), ``message`` and whether
            it was ``kept`` from an earlier run.

        Raises
        ------
        OSError
            If the result cannot be written. Other errors are stored in the result.
        """
        head: dict[str, Any] = {"key": "", "task": self.task}
        content = page = None
        with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            try:
                groups = [matching_paths(file) for file in system.files]
                head["key"] = self.key(system, groups)
                if self.resume and (before := self.before(system, head["key"])):
                    return answer_of_worker(system, before, True)
                head |= {"state": "done", "message": ""}
                with one_blas_thread():
                    result = self.result(system, groups, folder)
                task = TASKS[self.task]
                head["row"] = as_json(task.row(result))
                head["coefficients"] = task.coefficients(result)
                head["findings"] = task.findings(result)
                content = stamped(task.format, result.content())
                if self.pages:
                    page = result.to_html(
                        title=title_of(system.id, system.labels["site"])
                    )
            except Exception as error:  # an error of one system stops no other
                head, content = failure(head, error), None
        put_page(self.out, system.id, page)
        write_result(self.out, system.id, head, content)
        return answer_of_worker(system, head)

    def ended(self, system: System, error: Exception) -> dict:
        """The answer of a system that ended every worker that took it."""
        words = (
            "it ended each worker that took it, probably because its data need more "
            f"memory than a worker has: {' '.join(str(error).split())}"
        )
        head = {"key": "", "task": self.task, "state": "failed", "message": words}
        write_result(self.out, system.id, head)
        return answer_of_worker(system, head)

    def before(self, system: System, key: str) -> dict[str, Any] | None:
        """The stored result with this key, if its page is there, too."""
        content = stored_content(self.out, system.id)
        if content is None or content["fleet"]["key"] != key:
            return None
        head = content["fleet"]
        paged = not self.pages or page_path(self.out, system.id).exists()
        return head if paged or head["state"] == "failed" else None

    def key(self, system: System, groups: Groups) -> str:
        """Hash of the files, row, task, options and version."""
        from pvlib_fem import __version__

        options = {
            name: written_argument(value) for name, value in self.options.items()
        }
        marks = [
            {"name": path, **{n: str(info[n]) for n in MARKS if n in info}}
            for disk, paths in groups
            for path in paths
            for info in [disk.info(path)]
        ]
        whole = [asdict(system), marks, self.task, options, __version__]
        words = json.dumps(as_json(whole), sort_keys=True, default=str)
        return hashlib.sha256(words.encode("utf-8", "surrogatepass")).hexdigest()

    def result(self, system: System, groups: Groups, folder: str) -> Any:
        """The result of the task."""
        data = frame_of_system(system, groups, folder)
        place = [system.place.get(name) for name in PLACE]
        data = in_local_days(data, place[1], system.layout.get("tz"))
        site = site_of(pd.DatetimeIndex(data.index), *place, **system.tracker)
        checked = system.reading.get("check_units", True)
        options = {"check_units": checked, **self.options}
        if system.steady_model:
            options["model"] = system.steady_model
        return TASKS[self.task].run(data, **site, **options)


def title_of(identity: str, site: str) -> str:
    """
    The title of a system's page.

    Parameters
    ----------
    identity : str
        Identity of the system.
    site : str
        Name of its site; may be empty.

    Returns
    -------
    str
    """
    return ", ".join(filter(None, [site, identity]))


def failure(head: Mapping[str, Any], error: Exception) -> dict[str, Any]:
    """The stored result of a failed system; without a key if it is tried again."""
    words = " ".join(str(error).split())
    if isinstance(error, FileNotFoundError):
        words = f"there is no file {error.filename or words}"
    sure = isinstance(error, ValueError)  # other errors may not occur again
    if not sure and not isinstance(error, OSError):
        words = f"{type(error).__name__}: {words}"
    key = head["key"] if sure else ""
    return {"key": key, "task": head["task"], "state": "failed", "message": words}


def answer_of_worker(
    system: System, head: Mapping[str, Any], kept: bool = False
) -> dict[str, Any]:
    """The answer of a worker."""
    state = {name: head[name] for name in ("state", "message")}
    return {"id": system.id, **state, "kept": kept}


def matching_paths(file: str) -> "tuple[AbstractFileSystem, list[str]]":
    """The file system of a path, pattern or URL, and the paths that match."""
    from fsspec.core import url_to_fs

    disk, path = url_to_fs(file)
    if not any(sign in path for sign in "*?[") or disk.exists(path):
        return disk, [path]
    if not (paths := sorted(disk.glob(path))):
        raise FileNotFoundError(f"there is no file {file}")
    return disk, paths


def frame_of_system(system: System, groups: Groups, folder: str) -> pd.DataFrame:
    """The frame of a system; remote files are copied to this machine."""
    local = []
    for i, (disk, paths) in enumerate(groups):
        folders = [Path(folder, f"{i}-{j}") for j in range(len(paths))]
        local.append([local_path(disk, *both) for both in zip(paths, folders)])
    layout = layout_of(system.layout)
    reading = dict(system.reading)
    data = frame(
        [one if len(one) > 1 else one[0] for one in local],
        [layout] * len(local),
        system.columns,
        reading.pop("convert_units", False),
        system.units,
        reading.pop("check_units", True),
        reading.pop("module_area", None),
    )
    data.attrs = {}
    return data


def local_path(disk: "AbstractFileSystem", path: str, folder: Path) -> Path:
    """Path of a file on this machine; a remote file is copied to ``folder``."""
    from fsspec.implementations.local import LocalFileSystem

    if isinstance(disk, LocalFileSystem):
        return Path(path)
    folder.mkdir(exist_ok=True)
    place = folder / path.rstrip("/").rpartition("/")[2]
    disk.get_file(path, str(place))
    return place
