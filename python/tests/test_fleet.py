"""A fleet on one machine: one row a robot and day, whatever runs it and in whatever order."""

from __future__ import annotations

import json
import multiprocessing
import shutil
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from pathlib import Path
from typing import Any

import pytest

import sesc
from sesc import fleet

from conftest import POLE


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


def test_each_robot_and_day_is_a_row(robot: sesc.Robot, table: fleet.Fleet) -> None:
    assert [(row["robot"], row["day"]) for row in table] == [(r, d) for r in "abc" for d in "12"]
    assert list(table.columns()) == ["robot", "day", *fleet.COLUMNS]
    for row in table:
        cut = (row["robot"], row["day"]) == ("b", "1")
        assert (row["error"] is not None) == cut
        if cut:
            assert row["error"].startswith("LogError") and "/" not in row["error"]
            continue
        assert row["postures"] == 60 and len(row["inputs"]) == 1 and row["urdf_hash"] == robot.hash
        assert len(row["params"]) == len(row["std"]) == 5
        shifted = [step["target"] for step in json.loads(row["effects"])]
        assert bool(shifted) == (row["robot"] == "c") == (row["verdict"] != "none")
    assert table.to_dict()["groups"] == 6 and len(table.to_dict()["failed"]) == 1


class Backwards(Executor):
    """Runs everything twice, the last first."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, Any, Future[Any]]] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        future.result = lambda timeout=None: (fn(*args), fn(*args))[1]  # type: ignore[method-assign]
        return future


def test_rows_depend_on_contents_alone(
    robot: sesc.Robot, logs: Path, table: fleet.Fleet, tmp_path: Path
) -> None:
    elsewhere = tmp_path / "deep" / "elsewhere"
    shutil.copytree(logs, elsewhere)
    assert fleet.run(robot, glob(elsewhere), engine=Backwards()).rows == table.rows
    paths = sorted(elsewhere.glob("robot=*/day=*/*.csv"), reverse=True)
    assert fleet.run(robot, paths).rows == table.rows
    manifest = {
        "path": [str(path) for path in paths],
        "robot": [path.parts[-3][-1] for path in paths],
        "day": [path.parts[-2][-1] for path in paths],
    }
    assert fleet.run(robot, manifest).rows == table.rows
    table.save(tmp_path / "rows.json")
    assert len((tmp_path / "rows.json").read_text().splitlines()) == len(table)


def test_processes_give_the_same_rows(robot: sesc.Robot, logs: Path, table: fleet.Fleet) -> None:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=context) as pool:
        assert fleet.run(robot, glob(logs), engine=pool).rows == table.rows


def test_a_second_run_reads_nothing(
    robot: sesc.Robot, logs: Path, table: fleet.Fleet, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = tmp_path / "store"
    assert fleet.run(robot, glob(logs), store=store).rows == table.rows
    from sesc.fleet import _run

    def refuse(*_: object) -> None:
        raise AssertionError("read again")

    monkeypatch.setattr(_run, "analyse", refuse)
    monkeypatch.setattr(_run, "content_hash", refuse)
    assert fleet.run(robot, glob(logs), store=store).rows == table.rows


def test_a_broken_log_does_not_take_its_day_along(robot: sesc.Robot, logs: Path, tmp_path: Path) -> None:
    place = tmp_path / "robot=a" / "day=2"
    shutil.copytree(logs / "robot=a/day=2", place)
    (place / "bad.csv").write_text("pose,hip,cop_x,cop_y\n0,two,0,0\n")
    (place / "bad.csv.toml").write_text("support = 'foot'\n")
    (row,) = fleet.run(robot, glob(tmp_path))
    assert row["postures"] == 60 and "LogError" in row["error"] and len(row["inputs"]) == 2


def test_what_is_no_fleet_is_said(robot: sesc.Robot) -> None:
    with pytest.raises(TypeError, match="glob"):
        fleet.run(robot, 3)
    with pytest.raises(ValueError, match="path"):
        fleet.run(robot, {"file": ["a"]})
    (row,) = fleet.run(robot, ["none.csv"])
    assert "LogError" in row["error"] or "FileNotFoundError" in row["error"]
