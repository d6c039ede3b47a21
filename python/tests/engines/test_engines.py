"""One fleet on Ray and Spark, calm, from the store, and with a worker killed in the middle: one SHA-256."""

from __future__ import annotations

import hashlib
import os
import shutil
import signal
import threading
import time
from pathlib import Path

import pytest

import sesc
from sesc import fleet

from conftest import running

#: Logs of the fleet, and rows in the store when a worker is killed.
LOGS, KILLED = 12, 3


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Logs of 60 postures; one is cut in the middle of a row, one came twice."""
    folder = tmp_path_factory.mktemp("logs")
    model = sesc.Robot(sesc.OP2_URDF).on("r_sole")
    for k in range(LOGS):
        log = sesc.simulate(model, 60, range=0.5, noise=1e-4, seed=k + 1)
        log.save(folder / f"r{k // 3}_{k % 3}.csv")
    whole = (folder / "r1_2.csv").read_text()
    (folder / "r1_2.csv").write_text(whole[: len(whole) // 2 + 3])
    for end in ("", ".toml"):
        shutil.copy(folder / f"r0_1.csv{end}", folder / f"r0_again.csv{end}")
    return folder


def run(logs: Path, store: Path | None, engine: object, out: Path) -> tuple[int, str]:
    """Rows from the store, and the SHA-256 of the table."""
    found = fleet.run(sesc.Robot(sesc.OP2_URDF), logs, store=store, engine=engine)
    assert (len(found), len(found.failed), len(found.twice)) == (LOGS + 1, 1, 1)
    found.save(out)
    return found.to_dict()["from_store"], hashlib.sha256(out.read_bytes()).hexdigest()


def workers() -> list[int]:
    """Descendants of this process that have the library loaded (Linux)."""
    parents = {}
    for place in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(place.name)] = int((place / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
    found = []
    for process in sorted(parents):
        above = parents[process]
        while above in parents and above != os.getpid():
            above = parents[above]
        try:
            if above == os.getpid() and "_sesc" in Path(f"/proc/{process}/maps").read_text():
                found.append(process)
        except OSError:
            continue
    return found


@pytest.mark.parametrize("engine", ["ray", "spark"])
def test_an_engine_gives_the_bytes_of_threads(engine: str, logs: Path, tmp_path: Path) -> None:
    pytest.importorskip({"spark": "pyspark"}.get(engine, engine))
    out, killed = tmp_path / "fleet.csv", []
    _, expected = run(logs, None, None, out)

    def kill() -> None:
        while len(list((tmp_path / "killed").glob("*/*.json"))) < KILLED:
            time.sleep(0.02)
        for process in workers()[:1]:
            killed.append(process)
            os.kill(process, signal.SIGKILL)

    with running(engine) as session:
        for made in (0, LOGS + 1):
            assert run(logs, tmp_path / "store", session, out) == (made, expected)
        threading.Thread(target=kill, daemon=True).start()
        _, found = run(logs, tmp_path / "killed", session, out)
    assert killed and found == expected
