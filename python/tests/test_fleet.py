"""A fleet on one machine: one row a robot and day, whatever runs it and in whatever order."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import shutil
import subprocess
from concurrent.futures import BrokenExecutor, Executor, Future
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

import sesc
from sesc import fleet

from conftest import POLE, running


@pytest.fixture(scope="module")
def robot() -> sesc.Robot:
    return sesc.Robot(POLE)


@pytest.fixture(scope="module")
def logs(robot: sesc.Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three robots on two days; the hip of the third is off; one file is cut, one came twice."""
    folder = tmp_path_factory.mktemp("logs")
    for name in ("a", "b", "c"):
        for day in ("1", "2"):
            hide = {"joint_offset:hip": 0.05} if name == "c" else {}
            place = folder / f"robot={name}" / f"day={day}"
            place.mkdir(parents=True)
            seed = 10 * ord(name) + int(day)
            sesc.simulate(robot.on("foot"), 60, noise=2e-4, seed=seed, hide=hide).save(place / "log.csv")
    whole = (folder / "robot=b/day=1/log.csv").read_text()
    (folder / "robot=b/day=1/log.csv").write_text(whole[: len(whole) // 2 + 3])
    shutil.copy(folder / "robot=a/day=1/log.csv", folder / "robot=a/day=1/again.csv")
    shutil.copy(folder / "robot=a/day=1/log.csv.toml", folder / "robot=a/day=1/again.csv.toml")
    return folder


def glob(logs: Path) -> str:
    return str(logs / "robot=*/day=*/*.csv")


@pytest.fixture(scope="module")
def table(robot: sesc.Robot, logs: Path) -> fleet.Fleet:
    return fleet.run(robot, glob(logs))


def digest(found: fleet.Fleet, folder: Path) -> str:
    """SHA-256 of the table's file."""
    found.save(folder / "fleet.csv")
    return hashlib.sha256((folder / "fleet.csv").read_bytes()).hexdigest()


def test_each_robot_and_day_is_a_row(robot: sesc.Robot, table: fleet.Fleet, logs: Path) -> None:
    assert [(row["robot"], row["day"]) for row in table] == [(r, d) for r in "abc" for d in "12"]
    assert tuple(table.columns()) == fleet.COLUMNS
    for row in table:
        cut = (row["robot"], row["day"]) == ("b", "1")
        assert (row["error"] is not None) == cut
        if cut:
            assert row["error"].startswith("log ") and "/" not in row["error"]
            continue
        assert row["postures"] == 60 and len(row["inputs"]) == 1 and row["urdf_hash"] == robot.hash
        assert len(row["params"]) == len(row["std"]) == 5
        shifted = [step["target"] for step in json.loads(row["effects"])["explanation"]]
        assert bool(shifted) == (row["robot"] == "c") == (row["verdict"] != "none")
    about = table.to_dict()
    assert about["groups"] == 6 and about["shared"] == [] and about["changes"] == []
    (failed,) = table.failed
    assert failed["input"] == str(logs / "robot=b/day=1/log.csv")
    (twice,) = table.twice
    assert twice["counted_once"]
    assert table.look_first[0] == "c"


class Backwards(Executor):
    """Runs everything twice, the last first."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.set_result((fn(*args), fn(*args))[1])
        return future


def test_rows_depend_on_contents_alone(
    robot: sesc.Robot, logs: Path, table: fleet.Fleet, tmp_path: Path
) -> None:
    elsewhere = tmp_path / "deep" / "elsewhere"
    shutil.copytree(logs, elsewhere)
    expected = digest(table, tmp_path)
    assert digest(fleet.run(robot, glob(elsewhere), engine=Backwards()), tmp_path) == expected
    paths = sorted(elsewhere.glob("robot=*/day=*/*.csv"), reverse=True)
    assert digest(fleet.run(robot, paths), tmp_path) == expected
    manifest = {
        "path": [str(path) for path in paths],
        "robot": [path.parts[-3][-1] for path in paths],
        "day": [path.parts[-2][-1] for path in paths],
    }
    assert digest(fleet.run(robot, manifest), tmp_path) == expected


def test_the_table_and_the_page_are_those_of_the_command(
    logs: Path, table: fleet.Fleet, tmp_path: Path, robot: sesc.Robot
) -> None:
    command = os.environ.get("SESC_COMMAND")
    if command is None:
        pytest.skip("SESC_COMMAND names no program")
    (tmp_path / "pole.urdf").write_text(POLE)
    for end in ("csv", "parquet"):
        out = tmp_path / f"command.{end}"
        words = [command, "fleet", str(tmp_path / "pole.urdf"), "--data", glob(logs), "--out", str(out)]
        done = subprocess.run([*words, "--json"], check=True, capture_output=True, text=True)
        assert json.dumps(table.to_dict()) == json.dumps(json.loads(done.stdout))
        assert str(table).rstrip() == subprocess.run(words, check=True, capture_output=True, text=True).stdout.rstrip()
        table.save(tmp_path / f"ours.{end}")
        assert (tmp_path / f"ours.{end}").read_bytes() == out.read_bytes()
    table.report(tmp_path / "fleet.html")
    assert "Look at these first" in (tmp_path / "fleet.html").read_text()
    assert sorted(page.name for page in (tmp_path / "fleet").iterdir()) == ["a.html", "b.html", "c.html"]
    assert "joint_offset:hip" in (tmp_path / "fleet" / "c.html").read_text()


def test_parquet_is_read_by_others(table: fleet.Fleet, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    table.save(tmp_path / "fleet.parquet")
    read = parquet.read_table(tmp_path / "fleet.parquet").to_pylist()
    assert read == table.rows


def test_a_second_run_makes_nothing_anew(
    robot: sesc.Robot, logs: Path, table: fleet.Fleet, tmp_path: Path
) -> None:
    store = tmp_path / "store"
    first = fleet.run(robot, glob(logs), store=store)
    assert first.to_dict()["from_store"] == 0
    for engine in (None, Backwards()):
        again = fleet.run(robot, glob(logs), store=store, engine=engine)
        assert again.to_dict()["from_store"] == 6
        assert digest(again, tmp_path) == digest(first, tmp_path) == digest(table, tmp_path)


def test_days_of_a_week_are_put_together(robot: sesc.Robot, tmp_path: Path) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    for seed, day in enumerate(("2031-05-01", "2031-05-04", "2031-05-05")):
        sesc.simulate(robot.on("foot"), 30, noise=2e-4, seed=seed).save(logs / f"a_{day}.csv")
    found = fleet.run(robot, logs, by=("robot", "week"))
    assert [(row["day"], row["postures"]) for row in found] == [("2031-W18", 60), ("2031-W19", 30)]
    days = [datetime(2031, 5, day) for day in (1, 4, 5)]
    table = {"path": sorted(logs.glob("*.csv")), "robot": ["a"] * 3, "day": days}
    assert fleet.run(robot, table, by="robot,week").rows == found.rows
    with pytest.raises(sesc.SescError, match="`week`"):
        fleet.run(robot, ["a_day.csv"], by="robot,week")
    found.report(tmp_path / "none.html", pages=0)
    assert not list((tmp_path / "none").iterdir())


@pytest.mark.parametrize("engine", ["executor", "dask"])
def test_engines_give_the_bytes_of_threads(
    engine: str, robot: sesc.Robot, logs: Path, table: fleet.Fleet, tmp_path: Path
) -> None:
    if engine == "dask":
        pytest.importorskip("distributed")
    expected = digest(table, tmp_path)
    with running(engine) as pool:
        for made in (0, 6):
            found = fleet.run(robot, glob(logs), store=tmp_path / "store", engine=pool)
            assert (found.to_dict()["from_store"], digest(found, tmp_path)) == (made, expected)


class Broken(Backwards):
    """Loses a worker after the second group."""

    left = 2

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        self.left -= 1
        if self.left < 0:
            raise BrokenExecutor("a process died")
        return super().submit(fn, *args, **kwargs)


def test_groups_that_a_broken_pool_leaves_are_done_here(
    robot: sesc.Robot, logs: Path, table: fleet.Fleet, tmp_path: Path
) -> None:
    with pytest.warns(RuntimeWarning, match="lost a worker"):
        found = fleet.run(robot, glob(logs), engine=Broken())
    assert digest(found, tmp_path) == digest(table, tmp_path)


def test_a_broken_log_does_not_take_its_day_along(robot: sesc.Robot, logs: Path, tmp_path: Path) -> None:
    place = tmp_path / "robot=a" / "day=2"
    shutil.copytree(logs / "robot=a/day=2", place)
    (place / "bad.csv").write_text("pose,hip,cop_x,cop_y\n0,two,0,0\n")
    (place / "bad.csv.toml").write_text("support = 'foot'\n")
    found = fleet.run(robot, glob(tmp_path))
    (row,) = found
    assert row["postures"] == 60 and "two" in row["error"] and len(row["inputs"]) == 2
    assert [failed["input"] for failed in found.failed] == [str(place / "bad.csv")]


def test_parameters_alone_and_what_they_say_of_the_next_robot(
    robot: sesc.Robot, table: fleet.Fleet, tmp_path: Path
) -> None:
    # The mass is some millimetres before or behind where CAD has it, robot by robot.
    logs = tmp_path / "logs"
    logs.mkdir()
    offsets = [-0.004, -0.002, 0.0, 0.002, 0.004, 0.001, -0.001, 0.003]
    for k, offset in enumerate(offsets):
        own = sesc.Robot(POLE.replace("xyz='0 0 1'", f"xyz='{offset} 0 1'")).on("foot")
        sesc.simulate(own, 60, noise=2e-4, seed=k + 1).save(logs / f"r{k}_1.csv")
    found = fleet.run(robot, logs, only="parameters", information=True)
    assert {row["verdict"] for row in found} == {""} and all(row["params"] for row in found)
    assert tuple(found.columns()) == fleet.COLUMNS
    found.save_prior(tmp_path / "population.toml")
    next_one = sesc.simulate(robot.on("foot"), 4, noise=2e-4, seed=99)
    by_cad, by_fleet = (
        sesc.fit(robot, next_one, prior=prior, noise=2e-4) for prior in ("cad", tmp_path / "population.toml")
    )
    before, after = (found.to_dict()["parameters"] for found in (by_cad, by_fleet))
    for cad, known, true in zip(before, after, robot.on("foot").params):
        assert known["std"] <= cad["std"] + 1e-12 and abs(known["value"] - true) <= 3 * known["std"] + 1e-9
    assert sum(known["std"] for known in after) < 0.8 * sum(cad["std"] for cad in before)
    with pytest.raises(sesc.SescError, match="needs 5"):
        table.save_prior(tmp_path / "none.toml")


def test_a_worker_reads_a_urdf_once(robot: sesc.Robot) -> None:
    jobs = [fleet.Job(robot, "{}", group) for group in "ab"]
    there = [pickle.loads(pickle.dumps(job)) for job in jobs]
    assert [job[1:] for job in there] == [job[1:] for job in jobs]
    assert there[0].robot is there[1].robot and there[0].robot.urdf == robot.urdf
    # Another reading of right angles is another robot.
    exact = fleet.Job(sesc.Robot(POLE, snap=False), "{}", "a")
    assert pickle.loads(pickle.dumps(exact)).robot.snap is False


DAY = datetime(2031, 5, 1)


def manifest(kind: str) -> Any:
    """Two logs: the second has no robot and no day of its own."""
    rows: list[dict[str, Any]] = [
        {"path": "x_9.csv", "robot": "a", "day": DAY},
        {"path": "b_2.csv", "robot": None, "day": None},
    ]
    columns = {name: [row[name] for row in rows] for name in rows[0]}
    if kind == "rows":
        return rows
    if kind == "dict":
        return {**columns, "robot": ["a", float("nan")]}
    if kind == "lazy polars":
        return pytest.importorskip("polars").DataFrame(columns).lazy()
    if kind == "duckdb":
        text = "select * from (values ('x_9.csv', 'a', timestamp '2031-05-01'), ('b_2.csv', null, null)) t(path, robot, day)"
        return pytest.importorskip("duckdb").sql(text)
    library = pytest.importorskip(kind)
    return library.table(columns) if kind == "pyarrow" else library.DataFrame(columns)


@pytest.mark.parametrize("kind", ["dict", "rows", "pandas", "polars", "lazy polars", "pyarrow", "duckdb"])
def test_a_manifest_is_any_table(robot: sesc.Robot, kind: str) -> None:
    found = fleet.run(robot, manifest(kind))
    assert [(row["robot"], row["day"]) for row in found] == [("a", "2031-05-01"), ("b", "2")]
    assert [failed["input"] for failed in found.failed] == ["b_2.csv", "x_9.csv"]


@pytest.mark.parametrize("nothing", [None, float("nan"), ""])
def test_a_row_of_a_table_without_a_path_is_named(robot: sesc.Robot, nothing: Any) -> None:
    with pytest.raises(ValueError, match="row 1 .* has no path"):
        fleet.run(robot, {"path": ["a_1.csv", nothing]})


def test_keys_in_one_text_are_split_at_commas(robot: sesc.Robot) -> None:
    (row,) = fleet.run(robot, ["a_1.csv"], by="robot")
    assert (row["robot"], row["day"]) == ("a_1", "")
    (row,) = fleet.run(robot, ["a_1.csv"], by="robot,day")
    assert (row["robot"], row["day"]) == ("a", "1")


def test_what_is_no_fleet_is_said(robot: sesc.Robot, tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="glob"):
        fleet.run(robot, 3)
    with pytest.raises(ValueError, match="path"):
        fleet.run(robot, {"file": ["a"]})
    with pytest.raises(TypeError, match="engine"):
        fleet.run(robot, [tmp_path / "a.csv"], engine="spark")
    with pytest.raises(sesc.SescError, match="no file has such a name"):
        fleet.run(robot, str(tmp_path / "*.csv"))
    (row,) = fleet.run(robot, [tmp_path / "none.csv"])
    assert row["error"].startswith("cannot read none.csv")
