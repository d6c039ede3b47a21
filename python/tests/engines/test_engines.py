"""One fleet on every engine, calm and with processes killed in the middle: one SHA-256.

``pytest tests/engines --engine executor,dask,ray,spark --kill worker`` asks for engines by name, which
then have to be there; else those are tried that are installed. ``threads`` of the driver itself
give the answer that all others are held against.
"""

from __future__ import annotations

import shutil
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from sesc.fleet import _trials as trials

#: Logs of the fleet, and rows in the store when a process is killed.
LOGS, KILLED = 12, 3
#: A run takes some seconds, s.
TIMEOUT = 240
#: What each engine needs.
NEEDS = {"executor": "sesc", "dask": "distributed", "ray": "ray", "spark": "pyspark"}


def is_there(engine: str) -> bool:
    return find_spec(NEEDS[engine]) is not None and (engine != "spark" or shutil.which("java") is not None)


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    option = metafunc.config.getoption
    if "engine" in metafunc.fixturenames:
        named = [name for name in str(option("engine")).split(",") if name]
        metafunc.parametrize("engine", named or [name for name in NEEDS if is_there(name)])
    if "kill" in metafunc.fixturenames:
        metafunc.parametrize("kill", [name for name in str(option("kill")).split(",") if name])


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Logs of 60 postures; one is cut in the middle of a row, one came twice."""
    folder = tmp_path_factory.mktemp("logs")
    trials.make(folder, LOGS, 60, days=3, end="csv")
    whole = (folder / "robot=r0001/day=02/log.csv").read_text()
    (folder / "robot=r0001/day=02/log.csv").write_text(whole[: len(whole) // 2 + 3])
    for end in ("", ".toml"):
        shutil.copy(
            folder / f"robot=r0000/day=01/log.csv{end}", folder / f"robot=r0000/day=01/again.csv{end}"
        )
    # Younger logs are read again.
    time.sleep(2.1)
    return str(folder / "robot=*/day=*/*.csv")


@pytest.fixture(scope="module")
def expected(logs: str, tmp_path_factory: pytest.TempPathFactory) -> str:
    found = trials.driven(logs, None, tmp_path_factory.mktemp("calm") / "fleet.csv", ("threads", "", "2"))
    assert (found["groups"], found["failed"], found["twice"]) == (LOGS, 1, 1)
    print(f"threads: {found['sha256']}")
    return str(found["sha256"])


def test_calm_and_a_second_run(engine: str, logs: str, expected: str, tmp_path: Path) -> None:
    def run() -> dict[str, Any]:
        return trials.driven(logs, tmp_path / "store", tmp_path / "fleet.csv", (engine, "", "2"), timeout=TIMEOUT)

    first, second = run(), run()
    for found in (first, second):
        assert found["sha256"] == expected
        assert (found["groups"], found["failed"], found["twice"]) == (LOGS, 1, 1)
    assert (first["from_store"], first["logs_read"]) == (0, LOGS + 1)
    assert (second["from_store"], second["logs_read"]) == (LOGS, 0)
    print(f"{engine}, calm, {first['seconds']:.1f} s: {first['sha256']}; second run reads 0 logs")


def test_killed_in_the_middle(engine: str, kill: str, logs: str, expected: str, tmp_path: Path) -> None:
    store, out = tmp_path / "store", tmp_path / "fleet.csv"
    found = trials.driven(logs, store, out, (engine, "", "2"), kill, KILLED, timeout=TIMEOUT)
    assert found["killed"], "nothing was killed"
    made = trials.rows_in(store)
    if kill == "driver":
        assert KILLED <= made < LOGS
        found = trials.driven(logs, store, out, (engine, "", "2"), timeout=TIMEOUT)
        # Rows that were made are not made anew.
        assert found["from_store"] == made
        text = f"driver killed at {made} of {LOGS} rows and started again"
    else:
        assert found["rows_when_killed"] < LOGS
        text = f"worker {found['killed']} killed at {found['rows_when_killed']} of {LOGS} rows"
    assert found["sha256"] == expected
    assert trials.rows_in(store) == LOGS
    print(f"{engine}, {text}: {found['sha256']}")
