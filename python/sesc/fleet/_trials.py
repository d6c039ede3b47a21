"""Fleets to try an engine on: virtual logs, engines by name, and processes that are killed.

A fleet is made of simulated OP2s. The run is a process of its own, the driver, which counts its
memory; a watching thread kills it, or one of its workers, when the store has some of the rows.
Workers are the descendants of the driver that have the library loaded (Linux).
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any

import sesc

from ._run import run

__all__ = ["ENGINES", "SETTLED", "driven", "engine", "make", "rows_in"]

#: Engines by name.
ENGINES = ("threads", "executor", "dask", "ray", "spark")
#: Noise of a posture's mean reading, m.
NOISE = 1e-4
#: A log that changed less than this before it was read is read again, s.
SETTLED = 2.1


def make(folder: Path, logs: int, postures: int, days: int = 10, end: str = "parquet") -> None:
    """Write virtual logs, ``robot=r0001/day=01/log.parquet``, of robots on ``days`` days each."""
    model = sesc.Robot(sesc.OP2_URDF).on("r_sole")

    def one(k: int) -> None:
        place = folder / f"robot=r{k // days:04}" / f"day={k % days + 1:02}"
        place.mkdir(parents=True, exist_ok=True)
        sesc.simulate(model, postures, range=0.5, noise=NOISE, seed=k + 1).save(place / f"log.{end}")

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        for _ in pool.map(one, range(logs)):
            pass


@contextmanager
def engine(name: str, workers: int = 2) -> Iterator[Any]:
    """An engine on this machine, as :func:`sesc.fleet.run` takes it."""
    if name == "threads":
        yield None
    elif name == "executor":
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            yield pool
    elif name == "dask":
        distributed: Any = import_module("distributed")
        with distributed.Client(
            n_workers=workers, threads_per_worker=1, dashboard_address=None
        ) as client:
            yield client.get_executor()
    elif name == "ray":
        ray: Any = import_module("ray")
        ray.init(num_cpus=workers, include_dashboard=False, log_to_driver=False)
        try:
            yield "ray"
        finally:
            ray.shutdown()
    elif name == "spark":
        # Workers have to find this package.
        os.environ.setdefault("PYSPARK_PYTHON", sys.executable)
        sql: Any = import_module("pyspark.sql")
        # Four tries a task; local[N] alone has one.
        session = sql.SparkSession.builder.master(f"local[{workers},4]").getOrCreate()
        try:
            yield session
        finally:
            session.stop()
    else:
        raise sesc.ArgumentError(f"no engine `{name}`; there are {', '.join(ENGINES)}")


def rows_in(store: Path) -> int:
    """How many rows a store has."""
    return sum(1 for folder in store.glob("??") for _ in folder.glob("*.json"))


def driven(
    logs: str,
    store: Path | None,
    out: Path,
    options: Sequence[str] = (),
    kill: str = "",
    after: int = 0,
    timeout: float | None = None,
) -> dict[str, Any]:
    """Run a fleet in a process of its own; what it says of itself.

    ``kill`` is ``driver`` or ``worker``: the driver, or one of its workers, is killed by its
    process id when the store has ``after`` rows. Of a driver that was killed nothing is known
    but ``killed``. Whatever the driver began is ended with it.
    """
    words = [sys.executable, "-m", __name__, logs, str(store or ""), str(out), kill, str(after), *options]
    # Files, not pipes: a worker that outlives its driver would keep a pipe open.
    with TemporaryFile() as said, TemporaryFile() as errors:
        # The installed package, not a folder of its source where this is called.
        env = os.environ | {"PYTHONSAFEPATH": "1"}
        process = subprocess.Popen(words, stdout=said, stderr=errors, start_new_session=True, env=env)
        try:
            process.wait(timeout)
        finally:
            for other in _of_session(process.pid):
                os.kill(other, signal.SIGKILL)
            process.wait()
        if process.returncode == -signal.SIGKILL:
            return {"killed": process.pid}
        said.seek(0)
        errors.seek(0)
        if process.returncode != 0:
            raise RuntimeError(errors.read().decode()[-4000:])
        found: dict[str, Any] = json.loads(said.read().decode().strip().splitlines()[-1])
        return found


def _of_session(session: int) -> list[int]:
    """Processes of a session that :func:`driven` began."""
    return [process for process, (_, own) in _processes().items() if own == session]


def _processes() -> dict[int, tuple[int, int]]:
    """Parent and session of every process."""
    found = {}
    for place in Path("/proc").glob("[0-9]*"):
        try:
            fields = (place / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        found[int(place.name)] = (int(fields[1]), int(fields[3]))
    return found


def _driver(words: Sequence[str]) -> None:
    """The driver: logs, store, table, whom to kill after how many rows, engine, what alone."""
    logs, store, out, kill, after, name, only, workers = words
    robot = sesc.Robot(sesc.OP2_URDF)
    about: dict[str, Any] = {"killed": None}
    with engine(name, int(workers)) as running:
        if kill:
            watch = threading.Thread(target=_killer, args=(Path(store), kill, int(after), about), daemon=True)
            watch.start()
        start = time.perf_counter()
        found = run(robot, logs, store=store or None, engine=running, only=only or None)
        about["seconds"] = time.perf_counter() - start
    found.save(out)
    own, others = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    about["memory_mb"] = own.ru_maxrss / 1024
    # The largest of the workers that have ended.
    about["worker_mb"] = others.ru_maxrss / 1024
    # Of workers, too, once they have ended.
    about["cpu_seconds"] = sum(usage.ru_utime + usage.ru_stime for usage in (own, others))
    about["sha256"] = hashlib.sha256(Path(out).read_bytes()).hexdigest()
    about.update({key: found.to_dict()[key] for key in ("groups", "from_store", "logs_read")})
    about["failed"], about["twice"] = len(found.failed), len(found.twice)
    print(json.dumps(about))


def _killer(store: Path, kill: str, after: int, about: dict[str, Any]) -> None:
    while rows_in(store) < after:
        time.sleep(0.02)
    victims = [os.getpid()] if kill == "driver" else _workers()
    if victims:
        about["killed"], about["rows_when_killed"] = victims[0], rows_in(store)
        os.kill(victims[0], signal.SIGKILL)


def _workers() -> list[int]:
    """Descendants of this process that have the library loaded."""
    parents = {process: parent for process, (parent, _) in _processes().items()}
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


if __name__ == "__main__":
    _driver(sys.argv[1:])
