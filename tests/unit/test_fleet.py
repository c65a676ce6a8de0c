"""Many systems: the same on any engine, and nothing is lost when something ends."""

import errno
import itertools
import json
import os
import re
import shutil
import string
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

import pandas as pd
import psutil
import pytest
from click.testing import CliRunner
from hypothesis import given, strategies as st
from pvlib.location import Location

import pvlib_fem as fem
from pvlib_fem import _cli as cli, _stored as stored, datasets, fleet, simulator
from pvlib_fem._record.column_names import COLUMNS
from pvlib_fem._record.layout import layout_of
from pvlib_fem.fleet import _store as store
from pvlib_fem.fleet._report import unnamed_columns
from pvlib_fem.fleet._shared import few_names, shared_causes
from pvlib_fem.fleet._store import TABLES, page_path, result_path
from pvlib_fem.fleet._systems_table import opened_table, systems_of

SITE = fem.simulator.RHINE


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Files of five systems: one holds no table, and one is missing."""
    folder = tmp_path_factory.mktemp("plants")
    rows = []
    for seed, name in enumerate(("east", "west/2", "roof 3", "ß")):
        data = fem.datasets.synthetic(12, 900, seed=seed)[list(COLUMNS)]
        file = folder / f"logger {seed}.csv"
        data.rename(columns={"poa_global": "Irr"}).to_csv(file)
        rows.append({"id": name, "file": file.name, "site": "A", "poa_global": "Irr"})
    (folder / "poison.csv").write_bytes(b"\x00\xff;\n" * 50)
    rows.append({"id": "poison", "file": "poison.csv", "site": "B"})
    rows.append({"id": "gone", "file": "gone.csv", "site": "B"})
    pd.DataFrame(rows).assign(mounting="rack").to_csv(
        folder / "systems.csv", index=False
    )
    return folder


@pytest.fixture
def table(folder):
    return pd.read_csv(folder / "systems.csv", dtype=str).assign(
        file=lambda rows: [str(folder / name) for name in rows["file"]]
    )


@pytest.fixture(scope="module")
def cluster():
    """A scheduler and two workers, each a process of its own."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address="127.0.0.1:0",
        silence_logs=50,
    ) as found:
        yield found


def bits(out):
    return {name: Path(out, f"{name}.parquet").read_bytes() for name in TABLES}


def seen():
    """The answers so far, and a function that collects them."""
    answers = []
    return answers, answers.append


def test_two_workers_write_the_bits_of_a_bare_loop(table, cluster, tmp_path):
    bare = fleet.run(table, tmp_path / "bare", "fit", workers=0)
    shuffled = table.sample(frac=1.0, random_state=1)
    address = cluster.scheduler_address
    many = fleet.run(shuffled, tmp_path / "many", "fit", client=address)
    assert bits(bare.out) == bits(many.out)
    assert list(many.systems["id"]) == sorted(table["id"])


def test_every_system_is_a_row_and_a_bad_file_one_with_its_message(table, tmp_path):
    results = fleet.run(table, tmp_path, "fit", workers=0, model="faiman")
    rows = results.systems.set_index("id")
    assert rows["state"].value_counts().to_dict() == {"done": 4, "failed": 2}
    assert "4 done, 2 failed" in str(results)
    assert "gone.csv" in rows.loc["gone", "message"]
    assert "poison.csv" in rows.loc["poison", "message"]
    assert (rows["mounting"] == "rack").all()
    data = fem.read_file(table["file"].iloc[0], {"poa_global": "Irr"})
    fit = fem.fit_fem(*(data[name] for name in COLUMNS), model="faiman")
    # the stored result equals that of the function, to the bit
    assert results.result("east").to_json() == fit.to_json()
    whole = results.table("systems", json=True).set_index("id")
    assert json.loads(whole.loc["east", "json"]) == json.loads(fit.to_json())
    found = results.coefficients.query("id == 'east'").set_index("coefficient")
    assert found["value"].to_dict() == fit.coefficients
    assert rows.loc["east", "rmse_after"] == fit.scores["rmse_test"].iloc[-1]
    with pytest.raises(ValueError, match="system gone failed: "):
        results.result("gone")


def test_what_is_done_stays_and_what_has_changed_is_done_again(folder, tmp_path):
    table = pd.read_csv(folder / "systems.csv", dtype=str)[:2]
    files = []
    for name in table["file"]:
        files.append(tmp_path / name)
        files[-1].write_bytes((folder / name).read_bytes())
    table["file"] = list(map(str, files))

    def kept(**options):
        answers, tell = seen()
        fleet.run(table, tmp_path, "fit", workers=0, progress=tell, **options)
        return {answer["id"]: answer["kept"] for answer in answers}

    again = {"east": True, "west/2": True}
    assert kept() == dict.fromkeys(again, False)
    before = bits(tmp_path)
    assert kept() == again
    assert bits(tmp_path) == before
    assert kept(resume=False) == dict.fromkeys(again, False)
    assert kept(model="faiman") == dict.fromkeys(again, False)
    assert kept(model="faiman") == again
    os.utime(files[0], ns=(1, 1))
    assert kept(model="faiman") == again | {"east": False}
    table.loc[0, "site"] = "another"
    assert kept(model="faiman") == again | {"east": False}
    other = ("{", "[]", '{"fleet": []}', '{"fleet": {}}', '{"fleet": {"key": ""}}')
    for text in other:  # half a file, and a file that no fleet wrote
        result_path(tmp_path, "east").write_text(text, "utf-8")
        assert kept(model="faiman") == again | {"east": False}, text
        assert pd.read_parquet(tmp_path / "systems.parquet")["state"].eq("done").all()


def test_data_that_are_wrong_stay_so_and_a_lost_disk_is_tried_again(table, tmp_path):
    fleet.run(table[4:], tmp_path, "fit", workers=0)
    answers, tell = seen()
    fleet.run(table[4:], tmp_path, "fit", workers=0, progress=tell)
    kept = {answer["id"]: answer["kept"] for answer in answers}
    assert kept == {"poison": True, "gone": False}


def test_a_worker_that_is_killed_loses_nothing(table, cluster, tmp_path):
    from distributed import Client

    fleet.run(table, tmp_path / "bare", "fit", workers=0)
    with Client(cluster) as client:
        pids = list(client.run(os.getpid).values())

        def kill(answer):
            if pids:
                psutil.Process(pids.pop()).kill()
                pids.clear()

        fleet.run(table, tmp_path / "hurt", "fit", client=client, progress=kill)
        assert not pids
    assert bits(tmp_path / "bare") == bits(tmp_path / "hurt")


def test_a_full_disk_is_said_and_what_was_done_is_kept(table, tmp_path, monkeypatch):
    """The disk is full from the third file on, and then emptied."""
    answers, tell = seen()

    def saved(*arguments):
        if len(answers) == 2:
            raise OSError(errno.ENOSPC, "No space left on device")
        return stored.saved(*arguments)

    monkeypatch.setattr(store, "saved", saved)
    with pytest.raises(OSError, match="No space left"):
        fleet.run(table, tmp_path, "fit", workers=0, progress=tell)
    monkeypatch.undo()
    assert len(answers) == 2
    again, tell = seen()
    fleet.run(table, tmp_path, "fit", workers=0, progress=tell)
    done = {one["id"] for one in answers if one["state"] == "done"}
    assert {one["id"] for one in again if one["kept"]} == done
    fleet.run(table, tmp_path / "bare", "fit", workers=0)
    assert bits(tmp_path) == bits(tmp_path / "bare")


DISK = """set -e
run() { "$1" -m pvlib_fem fleet "$2" --out "$3" --task fit --model faiman --workers 2; }
mount -t tmpfs -o size=12k tmpfs "$1"
! run "$0" "$2" "$1/run"
mount -o remount,size=50m "$1"
find "$1/run" -name '*.json' | wc -l
run "$0" "$2" "$1/run"
cp "$1/run/"*.parquet "$3"
"""


def test_a_small_disk_is_full_in_mid_run_and_then_larger(folder, table, tmp_path):
    """A file system of three pages, of a machine that lets one be mounted."""
    own = ["unshare", "--map-root-user", "--mount"]
    try_ = ["mount", "-t", "tmpfs", "tmpfs", str(tmp_path)]
    if not shutil.which("unshare") or subprocess.run(own + try_).returncode:
        pytest.skip("no file system can be mounted here")
    disk, after = tmp_path / "disk", tmp_path / "after"
    for place in (disk, after):
        place.mkdir()
    words = ["sh", "-c", DISK, sys.executable, disk, folder / "systems.csv", after]
    ran = subprocess.run([*own, *map(str, words)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert "No space left on device" in ran.stderr and "to go on" in ran.stderr
    assert 0 < int(ran.stdout.split()[0]) < len(table)
    assert "6 systems: 4 done, 2 failed" in ran.stdout
    bare = tmp_path / "bare"
    fleet.run(folder / "systems.csv", bare, "fit", workers=0, model="faiman")
    assert bits(after) == bits(bare)


def test_an_interrupt_leaves_tables_of_what_was_done(table, tmp_path):
    answers = []

    def stop(answer):
        answers.append(answer)
        if len(answers) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fleet.run(table, tmp_path, "fit", workers=0, progress=stop)
    states = fleet.Results(tmp_path).systems["state"].value_counts()
    assert states["not run"] == len(table) - 3
    fleet.run(table, tmp_path, "fit", workers=0)
    fleet.run(table, tmp_path / "bare", "fit", workers=0)
    assert bits(tmp_path) == bits(tmp_path / "bare")


def test_an_interrupt_leaves_nothing_with_the_scheduler(table, cluster, tmp_path):
    def stop(answer):
        raise KeyboardInterrupt

    address = cluster.scheduler_address
    with pytest.raises(KeyboardInterrupt):
        fleet.run(table, tmp_path, "fit", client=address, progress=stop)
    begin = time.monotonic()
    while cluster.scheduler.tasks and time.monotonic() - begin < 30:
        time.sleep(0.05)
    assert not cluster.scheduler.tasks
    assert len(fleet.Results(tmp_path).systems) == len(table)


def test_a_system_that_ends_every_worker_is_a_row(table, cluster, tmp_path):
    """As one does whose data are larger than a worker's memory."""
    from distributed import Client

    def arm():
        import os

        from pvlib_fem.fleet import _tasks as tasks

        tasks.TASKS["fit"] = replace(
            tasks.TASKS["fit"], run=lambda *_, **__: os._exit(1)
        )

    allowed = cluster.scheduler.allowed_failures
    cluster.scheduler.allowed_failures = 0
    try:
        with Client(cluster) as client:
            client.wait_for_workers(2)  # one that was killed before may be on its way
            client.run(arm)
            results = fleet.run(table[:1], tmp_path, "fit", client=client)
    finally:
        cluster.scheduler.allowed_failures = allowed
    (row,) = results.systems.to_dict("records")
    assert row["state"] == "failed" and "ended each worker" in row["message"]


def test_a_loop_is_kept_with_its_findings_and_its_page(tmp_path):
    simulator = fem.simulator
    effects = simulator.PHYSICS | {"sky_radiation": 1.0}
    data = simulator.record(SITE, effects, 70, 3600, start="2023-05-01")
    data.to_parquet(tmp_path / "plant.parquet")
    place = ("latitude", "longitude", "surface_tilt", "surface_azimuth")
    row = {"id": "plant", "file": "plant.parquet", "pdc0": "5000"}
    row |= {name: getattr(SITE, name) for name in place}
    pd.DataFrame([row]).to_csv(tmp_path / "systems.csv", index=False)
    out = tmp_path / "out"
    results = fleet.run(tmp_path / "systems.csv", out, workers=0, pages=True)
    location = Location(SITE.latitude, SITE.longitude, tz=SITE.tz)
    loop = fem.close_loop(data, "faiman", location, 35.0, 180.0)
    assert results.result("plant").to_json() == loop.to_json()
    found = results.findings
    assert list(found["effect"]) == [finding.effect for finding in loop.finding_objects]
    assert list(found["gain"]) == [finding.gain for finding in loop.finding_objects]
    first = json.loads(results.table("findings", json=True)["json"].iloc[0])
    assert first["why"] == loop.finding_objects[0].why
    (one,) = results.systems.to_dict("records")
    errors = loop.table["energy_error_test"]
    assert one["energy_error_before"] == errors[loop.base]
    assert one["energy_error_after"] == errors[loop.last]
    years = len(data) / 8766
    sun = data["poa_global"].clip(lower=0).sum() / 1000
    assert one["insolation"] == pytest.approx(sun / years, rel=2e-3)
    assert "<svg" in page_path(out, "plant").read_text("utf-8")
    fleet.run(tmp_path / "systems.csv", out, "fit", workers=0)
    assert not page_path(out, "plant").exists()  # it was of the result before


def test_what_would_be_found_is_asked_of_each_system(tmp_path):
    """By a task of the table, with the numbers that the function gives alone."""
    data = fem.simulator.record(effects=fem.simulator.PHYSICS, days=100, step=3600)
    data.to_parquet(tmp_path / "plant.parquet")
    table = pd.DataFrame([{"id": "a", "file": str(tmp_path / "plant.parquet")}])
    how = {"effects": "sky_radiation", "sizes": [3], "draws": 1}
    results = fleet.run(table, tmp_path, "recover", workers=0, **how)
    alone = fem.recover_effects(data, **how, processes=1, progress=False)
    assert results.result("a").to_json() == alone.to_json()
    (size,) = results.coefficients.to_dict("records")
    assert size["value"] == alone.half["size"].iloc[0]
    assert "1 systems, 1 done" in fleet.report(tmp_path)
    with pytest.raises(ValueError, match="recover has no option processes"):
        fleet.run(table, tmp_path, "recover", workers=0, processes=2)
    with pytest.raises(ValueError, match="makes no pages"):
        fleet.run(table, tmp_path, "recover", workers=0, pages=True)


def test_files_come_from_where_fsspec_finds_them(folder, tmp_path):
    """As from a bucket: the months of one logger, by a pattern."""
    import fsspec

    data = fem.read_file(folder / "logger 0.csv", {"poa_global": "Irr"})
    disk = fsspec.filesystem("memory")
    for day in range(0, len(data), 300):
        with disk.open(f"/plant/{2000 - day}/month.csv", "w") as file:
            data[day : day + 300].to_csv(file)
    table = pd.DataFrame([{"id": "a", "file": "memory://plant/*/month.csv"}])
    results = fleet.run(table, tmp_path, "fit", workers=0)
    fit = fem.fit_fem(*(data[name] for name in COLUMNS))
    # a CSV keeps not quite all bits in older pandas
    assert results.result("a").coefficients == pytest.approx(fit.coefficients, rel=1e-9)
    answers, tell = seen()
    fleet.run(table, tmp_path, "fit", workers=0, progress=tell)
    assert answers[0]["kept"]


def test_two_loggers_with_units_of_their_own_are_one_system(folder, tmp_path):
    data = fem.read_file(folder / "logger 0.csv", {"poa_global": "Irr"})
    wind = (3.6 * data.pop("wind_speed")).rename("Wind")
    data.to_csv(tmp_path / "module.csv", sep=";")
    wind.to_csv(tmp_path / "weather.csv", sep=";")
    row = {"id": 7, "file": "module.csv | weather.csv", "sep": ";"}
    row |= {"wind_speed": "Wind", "wind_speed_unit": "km/h"}
    pd.DataFrame([row]).to_parquet(tmp_path / "systems.parquet")
    results = fleet.run(tmp_path / "systems.parquet", tmp_path, "fit", workers=0)
    whole = fem.read_file(folder / "logger 0.csv", {"poa_global": "Irr"})
    fit = fem.fit_fem(*(whole[name] for name in COLUMNS))
    assert results.result("7").coefficients == pytest.approx(fit.coefficients, rel=1e-6)


@pytest.mark.parametrize("lines", ["1", "1,", 1.0, "1, 3"])
def test_lines_that_are_left_out_have_the_name_of_the_option(lines):
    table = pd.DataFrame([{"id": "a", "file": "a.csv", "skip_lines": lines}])
    (system,) = systems_of(opened_table(table))
    layout = layout_of(system.layout)
    assert layout.skip_rows == ((1, 3) if lines == "1, 3" else (1,))


BAD = (
    ({"id": None}, "row 0 has no id"),
    ({"file": ""}, "system a: it has no file"),
    ({"latitude": "50"}, "system a: it has latitude and no longitude"),
    ({"latitude": "95", "longitude": "4"}, "system a: latitude is 95; it is -90 to 90"),
    ({"surface_tilt": "flat", "surface_azimuth": "0"}, "surface_tilt is 'flat'"),
    ({"tz": "Mars/Olympus"}, "system a: .*no such zone"),
    ({"wind_speed_unit": "furlong"}, "system a: .*furlong"),
    ({"skip_lines": "1", "skip_rows": "2"}, "system a: skip_rows and skip_lines"),
    ({"skip_lines": "[1]"}, r"system a: skip_lines is '\[1\]'"),
    ({"sort": "perhaps"}, "system a: sort is 'perhaps'"),
    ({"lattitude": "50"}, "'lattitude', which looks like 'latitude'"),
    ({"state": "Texas"}, "a column 'state', and so have the results.*'state_label'"),
    ({"rows": "12"}, "a column 'rows', and so have the results"),
)


@pytest.mark.parametrize("cells, words", BAD)
def test_a_wrong_cell_is_refused_before_any_work(cells, words, tmp_path):
    table = pd.DataFrame([{"id": "a", "file": "a.csv", **cells}])
    with pytest.raises(ValueError, match=words):
        fleet.run(table, tmp_path / "out", workers=0)
    assert not (tmp_path / "out").exists()


def test_a_table_needs_its_columns_and_each_id_once(tmp_path):
    with pytest.raises(ValueError, match="no column 'file'"):
        opened_table(pd.DataFrame({"id": ["a"]}))
    with pytest.raises(ValueError, match="'a' comes twice"):
        opened_table(pd.DataFrame({"id": ["a", "a "], "file": ["x", "y"]}))
    with pytest.raises(ValueError, match="no row"):
        opened_table(pd.DataFrame({"id": [], "file": []}))
    one = pd.DataFrame({"id": ["a"], "file": ["x"]})
    with pytest.raises(
        ValueError, match="unknown task 'dance'; there are fit, loop, recover"
    ):
        fleet.run(one, tmp_path, "dance")
    with pytest.raises(ValueError, match="holdout belongs to one system"):
        fleet.run(one, tmp_path, holdout=[])


def test_no_name_of_a_table_is_a_missing_value(tmp_path):
    """NA is a region as EMEA is; an empty cell has none."""
    (tmp_path / "systems.csv").write_text("id,file,region\nNA,a.csv,NA\nb,b.csv,\n")
    first, second = systems_of(opened_table(tmp_path / "systems.csv"))
    assert (first.id, first.labels["region"]) == ("NA", "NA")
    assert second.labels["region"] == ""


@pytest.mark.parametrize("words", ["", "id,file\nMünchen,a.csv\n"])
def test_a_file_that_holds_no_table_is_refused_by_name(words, tmp_path):
    path = tmp_path / "systems.csv"
    path.write_bytes(words.encode("latin-1"))
    with pytest.raises(ValueError, match=r"systems.csv is no table of .* in UTF-8"):
        opened_table(path)


def test_a_cluster_has_no_negative_number_of_workers(table, tmp_path):
    """Without a worker it would wait for ever."""
    with pytest.raises(ValueError, match="workers = -1; give 0, 1 or more"):
        fleet.run(table, tmp_path, "fit", workers=-1)


@given(st.lists(st.text(min_size=1).filter(str.strip), unique_by=str.strip, min_size=1))
def test_whatever_ids_are_each_has_a_file_of_its_own(ids):
    table = opened_table(pd.DataFrame({"id": ids, "file": "x"}))
    systems = list(systems_of(table))
    names = [store.name_of(system.id) for system in systems]
    assert len({name.casefold() for name in names}) == len(ids)
    assert all(
        set(name) <= {*string.ascii_letters, *string.digits, *"-_/"} for name in names
    )
    assert [system.id for system in systems] == sorted(system.id for system in systems)


def rows_of(*found):
    """Systems of one site, and findings: id, candidates, gain, dates or None."""
    names = sorted({one[0] for one in found} | {"a", "b", "c"})
    systems = pd.DataFrame({"id": names, "site": "S", "state": "done"})
    findings = [
        {"id": name, "site": "S", "candidates": " | ".join(candidates), "gain": gain}
        | dict(zip(("first", "last"), dates or (None, None)))
        for name, candidates, gain, dates in found
    ]
    return systems, pd.DataFrame(findings).assign(added=True)


LOSES = (
    "module_sensor_contact_step",
    "irradiance_sensor_step",
)  # of the module, and of the station
MARCH, MAY = ("2023-03-01", "2023-03-05"), ("2023-05-01", "2023-05-03")
SEES = json.dumps({name: [0.0, 0.1] for name in (*LOSES, "soiling")})


def test_what_all_have_at_one_time_is_the_stations_and_what_one_has_its_modules():
    systems, findings = rows_of(
        *((name, LOSES, 0.5, MARCH) for name in "abc"), ("b", LOSES, 0.4, MAY)
    )
    station, module = shared_causes(systems.assign(weighed=SEES), findings)
    assert station.everywhere and station.likely == ["irradiance_sensor_step"]
    assert "suspect the station" in station.words
    assert module.alone and module.likely == ["module_sensor_contact_step"]
    assert [*module.systems] == ["b"] and module.first == MAY[0]


@pytest.mark.parametrize("names", [*itertools.permutations("abc")])
def test_dates_that_no_day_has_in_common_are_not_one_cause(names):
    """Whatever the names of the systems: those of the largest gain come first."""
    spans = [("03-01", "03-10"), ("03-08", "03-20"), ("03-18", "03-30")]
    dates = [tuple(f"2023-{day}" for day in span) for span in spans]
    found = zip(names, (0.5, 0.4, 0.3), dates)
    systems, findings = rows_of(*((n, LOSES, gain, d) for n, gain, d in found))
    groups = shared_causes(systems.assign(weighed=SEES), findings)
    one, other = sorted(groups, key=lambda group: -len(group.systems))
    assert {*one.systems} == {*names[:2]} and {*other.systems} == {names[2]}
    assert (one.first, one.last) == ("2023-03-08", "2023-03-10")


def test_a_system_that_would_not_show_it_is_not_asked():
    """A gain that the other systems could not show does not single out a module."""
    systems, findings = rows_of(("a", ["soiling"], 0.3, None))
    blind = json.dumps({"soiling": [0.0, 0.5]})
    (group,) = shared_causes(systems.assign(weighed=blind), findings)
    assert not group.alone and group.words == "no other can show it"
    (group,) = shared_causes(systems.assign(weighed=[SEES, SEES, blind]), findings)
    assert group.alone and group.without == {"b"}
    weakly = json.dumps({"soiling": [0.2, 0.1]})  # there, and too small to be added
    (group,) = shared_causes(systems.assign(weighed=weakly), findings)
    assert group.everywhere and group.also == {"b", "c"}


def test_a_change_of_some_is_not_the_stations_where_others_found_no_date():
    found = [(name, LOSES, 0.5, MARCH) for name in "ab"]
    systems, findings = rows_of(*found)
    other = json.dumps({"soiling": [0.0, 0.1]})
    (group,) = shared_causes(systems.assign(weighed=other), findings)
    assert not group.everywhere and group.words == "2 of 3"


def test_a_system_that_may_have_it_under_another_name_is_not_one_without_it():
    """A class without a date that names it, or another profile at that very time."""
    found = [(name, LOSES, 0.5, MARCH) for name in "ab"]
    for named, when in (
        (("season", "module_sensor_contact_drift"), None),
        (("module_sensor_contact_episode",), MARCH),
        (("anemometer_step",), MARCH),
    ):
        systems, findings = rows_of(*found, ("c", named, 0.5, when))
        groups = shared_causes(systems.assign(weighed=SEES), findings)
        (group,) = (one for one in groups if one.have == 2)
        assert group.everywhere and group.maybe == {"c"} and not group.without
        assert group.words.startswith("2 of 3, and perhaps 1 more: suspect the station")
    # at another time, or of another instrument and without one, it is another
    for named, when in ((LOSES, MAY), (("anemometer_drift",), None)):
        systems, findings = rows_of(*found, ("c", named, 0.5, when))
        groups = shared_causes(systems.assign(weighed=SEES), findings)
        assert [group.without for group in groups if group.have == 2] == [{"c"}]
    # one system is not alone if as many may have the cause as do not have it
    systems, findings = rows_of(
        found[0], ("b", ["module_sensor_contact_episode"], 0.5, MARCH)
    )
    (group, _) = shared_causes(systems.assign(weighed=SEES), findings)
    assert (group.without, group.maybe) == ({"c"}, {"b"}) and not group.alone
    assert group.words == "1 of 3, and perhaps 1 more"
    # one system with many that may have it says nothing of the station
    others = [(name, ["module_sensor_contact_episode"], 0.5, MARCH) for name in "bc"]
    systems, findings = rows_of(found[0], *others)
    groups = shared_causes(systems.assign(weighed=SEES), findings)
    assert not any(group.everywhere and group.have == 1 for group in groups)


def test_what_may_be_of_the_station_or_of_the_modules_is_left_open():
    season = ("season", *LOSES)
    systems, findings = rows_of(*((name, season, 0.5, MARCH) for name in "abc"))
    (group,) = shared_causes(systems.assign(weighed=SEES), findings)
    assert group.words.endswith("an effect on all modules there, or the station")
    systems, findings = rows_of(*((name, LOSES[:1], 0.5, MARCH) for name in "abc"))
    (group,) = shared_causes(systems.assign(weighed=SEES), findings)
    assert group.words.endswith("a change of all modules at once")


def test_a_class_of_many_is_told_in_a_line():
    assert few_names({"b", "a"}, " or ", " or ") == "a or b"
    assert few_names("edcba", " or ", " or ") == "a or b or c or 2 more"


def test_a_site_of_one_system_shares_nothing():
    systems, findings = rows_of(("a", ["soiling"], 0.3, None))
    assert shared_causes(systems[:1].assign(weighed=SEES), findings) == []


def test_the_page_names_columns_that_the_table_of_systems_does_not():
    """A plant's power in kW under a name of its own is no cause of an error."""
    effects = ["driver:Pdc_kW", "driver:Pdc_kW", "driver:fan", "soiling"]
    findings = pd.DataFrame({"id": ["b", "a", "a", "a"], "effect": effects})
    (one,) = unnamed_columns(findings)
    assert "Pdc_kW (in a, b) as power_dc." in one.text and "fan" not in one.text
    assert unnamed_columns(findings[2:]) == [] and unnamed_columns(findings[:0]) == []
    (alone,) = unnamed_columns(findings[:1])  # a finding that is the only one
    assert "Pdc_kW (in b) as power_dc." in alone.text


def test_the_page_has_every_state_and_links_to_each_system(table, tmp_path):
    odd = table.assign(mounting=["rack", "<b>roof</b>"] * 3, pdc0=[1e3, 3e3] * 3)
    with pytest.raises(ValueError, match="holds no results"):
        fleet.report(tmp_path)
    results = fleet.run(odd, tmp_path / "out #1, 100 %", "fit", workers=0)
    html = fleet.report(results.out, tmp_path / "fleet.html", title="Plants & roofs")
    assert (tmp_path / "fleet.html").read_text("utf-8") == html
    assert "6 systems, 4 done, 2 failed" in html
    assert "Plants &amp; roofs" in html and "&lt;b&gt;roof&lt;/b&gt;" in html
    links = re.findall(r'href="(.*?)"', html)
    assert len(links) == 4
    for link in links:
        assert "<title>" in (tmp_path / unquote(link)).read_text("utf-8")
        assert "#" not in link  # after which a browser looks for a part of the page
    # by the energy that they misjudge, of which the larger have more
    rows = results.systems.query("state == 'done'").set_index("id")
    worst = rows["energy_error_after"] * rows["insolation"] * rows["pdc0"]
    order = [re.sub("<.*?>", "", cell) for cell in re.findall(r"<td><a.*?</a>", html)]
    assert order == list(worst.sort_values(ascending=False).index)
    assert "kWh a year" in html and "poison" in html
    k = results.coefficients.query("coefficient == 'k'").set_index("id")["value"]
    racks = k[rows.index[rows["mounting"] == "rack"]]
    assert f"{racks.median():.4g}" in html


def test_the_page_has_the_coefficients_of_each_model(table, tmp_path):
    """A noct of two models is not one quantity."""
    models = {"east": "sapm", "west/2": "pvsyst", "roof 3": "noct"}
    some = table[table["id"].isin(models)]
    some = some.assign(steady_model=some["id"].map(models))
    results = fleet.run(some, tmp_path, "fit", workers=0)
    html = fleet.report(results.out)
    known = [("sapm", "a"), ("sapm", "b"), ("pvsyst", "u_c"), ("pvsyst", "u_v")]
    for model, name in [*known, ("noct", "noct")]:
        assert re.search(rf"<td>{model}</td>\s*<td>{name}</td>", html)


def test_a_page_without_errors_has_a_dash_for_each(tmp_path):
    """A recovery has none, and the loop on a few days has no test weeks."""
    simulator.record(days=100, step=3600).to_csv(tmp_path / "long.csv")
    datasets.synthetic(6, 600).to_csv(tmp_path / "short.csv")
    how = dict(effects="module_offset_step", sizes=[3], draws=1)
    for file, task, more in (("long", "recover", how), ("short", "loop", {})):
        rows = pd.DataFrame({"id": ["a"], "file": [str(tmp_path / f"{file}.csv")]})
        fleet.run(rows, tmp_path / task, task, workers=0, **more)
        html = fleet.report(tmp_path / task)
        assert "<td>nan" not in html and ">nan<" not in html
        assert "no system was done" not in html and "– K before" not in html


def test_faults_of_devices_stand_first_by_the_name_of_their_system(tmp_path):
    """With a longitude of the wrong sign no other finding can be trusted."""
    site = simulator.RHINE
    data = simulator.record(days=40, step=1800.0, start="2023-04-01")
    data.tz_localize(None).to_csv(tmp_path / "plant.csv", index_label="time")
    row = {"file": "plant.csv", "latitude": site.latitude, "tz": site.tz}
    fallen = data.copy()
    off = data.index >= data.index[0] + pd.Timedelta(days=22)
    fallen.loc[off, "temp_module"] = data["temp_air"][off]
    fallen.tz_localize(None).to_csv(tmp_path / "fallen.csv", index_label="time")
    rows = [
        {"id": "right", "longitude": site.longitude, **row},
        {"id": "fallen", "longitude": site.longitude, **row, "file": "fallen.csv"},
        {"id": "mirrored", "longitude": -site.longitude, **row},
    ]
    pd.DataFrame(rows).to_csv(tmp_path / "systems.csv", index=False)
    results = fleet.run(tmp_path / "systems.csv", tmp_path / "out", workers=0)
    html = fleet.report(results.out)
    first, rest = html.split("What failed", 1)
    assert ">mirrored</a>" in first and "not corrected" in first
    assert "longitude has the wrong sign" in first and ">right</a>" not in first
    assert first.index(">mirrored</a>") < first.index(">fallen</a>")
    assert "from 2023-04-23" in first and "the sensor has come off" in first
    assert ">right</a>" in rest


def test_the_command_does_the_same(folder, tmp_path):
    out, page = tmp_path / "out", tmp_path / "out" / "page.html"
    command = ["fleet", folder / "systems.csv", "--out", out, "--task", "fit"]
    how = ["--workers", "0", "--model", "faiman", "--report", page]
    found = CliRunner().invoke(cli.main, [*map(str, command), *map(str, how)])
    assert found.exit_code == 0, found.output
    assert "6 systems: 4 done, 2 failed" in found.output
    assert "note: poison: " in found.output and "gone.csv" in found.output
    assert "4 done" in page.read_text("utf-8")
    same = fleet.run(folder / "systems.csv", tmp_path, "fit", workers=0, model="faiman")
    assert bits(out) == bits(same.out)
    refused = CliRunner().invoke(
        cli.main, [*map(str, command), "--min-rmse-reduction", "1"]
    )
    assert refused.exit_code == 1
    assert "the task fit has no option min_rmse_reduction" in refused.output


def test_a_table_of_which_nothing_can_be_done_ends_with_an_error(folder, tmp_path):
    table = pd.DataFrame([{"id": "gone", "file": "gone.csv"}])
    table.to_csv(tmp_path / "one.csv", index=False)
    command = ["fleet", tmp_path / "one.csv", "--out", tmp_path, "--workers", "0"]
    found = CliRunner().invoke(cli.main, list(map(str, command)))
    assert found.exit_code == 1 and "no system could be done" in found.output
