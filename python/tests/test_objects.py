"""A fleet whose logs and store are objects of a local server (S3, Google), behind a road that
throttles and cuts connections."""

from __future__ import annotations

import http.client
import http.server
import os
import re
import shutil
import socket
import threading
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import sesc
from sesc import fleet

from conftest import POLE

moto_server = pytest.importorskip("moto.server")
s3fs = pytest.importorskip("s3fs")

THROTTLED = b"""<?xml version="1.0" encoding="UTF-8"?><Error><Code>SlowDown</Code>
<Message>Please reduce your request rate.</Message></Error>"""


class Road(http.server.BaseHTTPRequestHandler):
    """Passes requests on to the server, and does to some of them what stores and networks do."""

    protocol_version = "HTTP/1.1"
    target: tuple[str, int]
    #: How often each request is answered by 503 SlowDown, and its answer cut in the middle.
    slow, cut = 0, 0
    seen: Counter[str] = Counter()
    done: Counter[str] = Counter()

    def log_message(self, format: str, *args: Any) -> None:
        pass

    def _pass(self) -> None:
        if self.headers.get("Expect"):
            self.send_response_only(100)
            self.end_headers()
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        request = f"{self.command} {self.path}"
        cls = type(self)
        cls.seen[request] += 1
        if cls.seen[request] <= cls.slow:
            cls.done["slow"] += 1
            self._answer(503, "application/xml", THROTTLED, len(THROTTLED))
            return
        onward = http.client.HTTPConnection(*self.target, timeout=30)
        onward.request(self.command, self.path, body, dict(self.headers))
        answer = onward.getresponse()
        data = answer.read()
        length = int(answer.headers.get("Content-Length") or len(data))
        is_object = self.command == "GET" and re.search(r"\.(csv|json|toml)(\?alt=media)?$", self.path) and len(data) > 100
        if is_object and cls.seen[request] <= cls.slow + cls.cut:
            cls.done["cut"] += 1
            data = data[: len(data) // 2]
        self.send_response_only(answer.status)
        for name, value in answer.getheaders():
            if name.lower() not in ("content-length", "connection", "transfer-encoding"):
                self.send_header(name, value)
        self.send_header("Content-Length", str(length))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(data)
        if len(data) < length and self.command != "HEAD":
            self.wfile.flush()
            self.close_connection = True
            self.connection.shutdown(2)

    def _answer(self, status: int, kind: str, data: bytes, length: int) -> None:
        self.send_response_only(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(length))
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(data)

    do_GET = do_PUT = do_POST = do_HEAD = do_DELETE = do_PATCH = _pass


class GoogleRoad(Road):
    """The road to the other server."""

    seen: Counter[str] = Counter()
    done: Counter[str] = Counter()


@pytest.fixture(scope="module")
def storage() -> Iterator[dict[str, Any]]:
    """What fsspec is given to reach the server by the road."""
    server = moto_server.ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    Road.target = server.get_host_and_port()
    road = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Road)
    threading.Thread(target=road.serve_forever, daemon=True).start()
    options = {
        "key": "nobody",
        "secret": "nothing",
        "endpoint_url": f"http://127.0.0.1:{road.server_port}",
        "client_kwargs": {"region_name": "eu-central-1"},
        # Only our own tries are counted on.
        "config_kwargs": {"retries": {"max_attempts": 1, "mode": "standard"}},
    }
    s3fs.S3FileSystem(**options).mkdir("fleet")
    yield options
    road.shutdown()
    server.stop()


@pytest.fixture(scope="module")
def google() -> Iterator[dict[str, Any]]:
    """What fsspec is given to reach a local server of Google's kind by a road; too heavy for every
    change, and run by ``engines.sh``."""
    with pytest.MonkeyPatch.context() as patch:
        # Else gcsfs asks Google by gRPC what kind of bucket this is.
        patch.setenv("GCSFS_EXPERIMENTAL_ZB_HNS_SUPPORT", "false")
        emulator = pytest.importorskip("gcp_storage_emulator.server")
        pytest.importorskip("gcsfs")
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            GoogleRoad.target = free.getsockname()
        server = emulator.create_server(*GoogleRoad.target, in_memory=True, default_bucket="fleet")
        server.start()
        road = http.server.ThreadingHTTPServer(("127.0.0.1", 0), GoogleRoad)
        threading.Thread(target=road.serve_forever, daemon=True).start()
        yield {"endpoint_url": f"http://127.0.0.1:{road.server_port}", "token": "anon", "project": "p"}
        road.shutdown()
        server.stop()


@pytest.fixture(autouse=True)
def calm() -> Iterator[None]:
    for road in (Road, GoogleRoad):
        road.slow = road.cut = 0
        road.seen.clear()
        road.done.clear()
    yield
    Road.slow = Road.cut = GoogleRoad.slow = GoogleRoad.cut = 0


@pytest.fixture(scope="module")
def robot() -> sesc.Robot:
    return sesc.Robot(POLE)


@pytest.fixture(scope="module")
def logs(robot: sesc.Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two robots on two days, one with a URDF of its own on the second; one log came twice."""
    folder = tmp_path_factory.mktemp("logs")
    for name in "ab":
        for day in "12":
            place = folder / f"robot={name}" / f"day={day}"
            place.mkdir(parents=True)
            seed = 10 * ord(name) + int(day)
            sesc.simulate(robot.on("foot"), 60, noise=2e-4, seed=seed).save(place / "log.csv")
    (folder / "robot=b/day=2/robot.urdf").write_text(POLE.replace("value='2'", "value='3'"))
    for end in ("", ".toml"):
        shutil.copy(folder / f"robot=a/day=1/log.csv{end}", folder / f"robot=a/day=1/again.csv{end}")
    return folder


@pytest.fixture
def bucket(logs: Path, storage: dict[str, Any], request: pytest.FixtureRequest) -> str:
    """The logs as objects, for one test."""
    system = s3fs.S3FileSystem(**storage)
    name = f"fleet/{request.node.name}"
    for path in logs.rglob("*"):
        if path.is_file():
            system.pipe_file(f"{name}/logs/{path.relative_to(logs)}", path.read_bytes())
    return f"s3://{name}"


def test_logs_store_and_table_on_s3(
    robot: sesc.Robot, logs: Path, bucket: str, storage: dict[str, Any], tmp_path: Path
) -> None:
    here = fleet.run(robot, str(logs / "robot=*/day=*/*.csv"))
    here.save(tmp_path / "here.csv")
    pattern = f"{bucket}/logs/robot=*/day=*/*.csv"
    first = fleet.run(robot, pattern, store=f"{bucket}/parts", storage=storage)
    first.save(f"{bucket}/fleet.csv")
    first.report(f"{bucket}/fleet.html")
    system = s3fs.S3FileSystem(**storage)
    # The bytes of the same logs as files, the URDF beside a log included.
    assert system.cat_file(f"{bucket}/fleet.csv") == (tmp_path / "here.csv").read_bytes()
    assert len({row["urdf_hash"] for row in first}) == 2
    assert b"Every robot" in system.cat_file(f"{bucket}/fleet.html")
    assert [one["input"] for one in first.twice] == [f"{bucket}/logs/robot=a/day=1/log.csv"]
    again = fleet.run(robot, f"{bucket}/logs", store=f"{bucket}/parts", storage=storage)
    assert (again.to_dict()["from_store"], again.to_dict()["logs_read"]) == (4, 0)
    assert again.rows == first.rows
    # An object that changed is read again; a table of addresses names the same logs.
    system.pipe_file(f"{bucket}/logs/robot=b/day=1/log.csv", (logs / "robot=a/day=2/log.csv").read_bytes())
    table = {"path": [log for log in system.glob(f"{bucket}/logs/robot=*/day=1/log.csv")]}
    table["path"] = [f"s3://{path}" for path in table["path"]]
    third = fleet.run(robot, table, store=f"{bucket}/parts", storage=storage)
    assert third.rows[1]["inputs"] == first.rows[1]["inputs"] and len(third) == 2


def test_throttling_and_cut_connections_cost_nothing_but_time(
    robot: sesc.Robot, bucket: str, storage: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from sesc.fleet import _objects

    monkeypatch.setattr(_objects, "PAUSE", (0.01, 0.05))
    pattern = f"{bucket}/logs/robot=*/day=*/*.csv"
    calm = fleet.run(robot, pattern, storage=storage)
    Road.seen.clear()
    Road.slow, Road.cut = 2, 2
    found = fleet.run(robot, pattern, store=f"{bucket}/parts", storage=storage)
    assert found.rows == calm.rows and found.failed == []
    # Every log and sidecar: 5 of each.
    assert Road.done["slow"] > 20 and Road.done["cut"] >= 10
    Road.slow = Road.cut = 0
    again = fleet.run(robot, pattern, store=f"{bucket}/parts", storage=storage)
    assert (again.to_dict()["from_store"], again.to_dict()["logs_read"]) == (4, 0)


def test_a_store_that_stays_away_is_an_error_of_its_rows(
    robot: sesc.Robot, bucket: str, storage: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from sesc.fleet import _objects

    monkeypatch.setattr(_objects, "PAUSE", (0.001, 0.001))
    table = {"path": [f"{bucket}/logs/robot=a/day=1/log.csv", f"{bucket}/logs/robot=a/day=3/log.csv"]}
    found = fleet.run(robot, table, storage=storage)
    # One is no object: a row with its error, and the other stays.
    assert [row["error"] is None for row in found] == [True, False]
    Road.cut = 10**6
    broken = fleet.run(robot, {"path": table["path"][:1]}, storage=storage)
    assert "log.csv" in str(broken.rows[0]["error"])


def test_google_cloud_storage(
    robot: sesc.Robot,
    logs: Path,
    google: dict[str, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    from sesc.fleet import _objects

    gcsfs: Any = pytest.importorskip("gcsfs")
    monkeypatch.setattr(_objects, "PAUSE", (0.01, 0.05))
    system = gcsfs.GCSFileSystem(**google)
    for path in logs.rglob("*"):
        if path.is_file():
            system.pipe_file(f"fleet/logs/{path.relative_to(logs)}", path.read_bytes())
    here = fleet.run(robot, str(logs / "robot=*/day=*/*.csv"))
    here.save(tmp_path / "here.csv")
    GoogleRoad.seen.clear()
    GoogleRoad.slow = GoogleRoad.cut = 1
    pattern = "gs://fleet/logs/robot=*/day=*/*.csv"
    first = fleet.run(robot, pattern, store="gs://fleet/parts", storage=google)
    assert GoogleRoad.done["slow"] > 10 and GoogleRoad.done["cut"] >= 10
    GoogleRoad.slow = GoogleRoad.cut = 0
    first.save("gs://fleet/fleet.csv")
    assert system.cat_file("fleet/fleet.csv") == (tmp_path / "here.csv").read_bytes()
    again = fleet.run(robot, "gs://fleet/logs", store="gs://fleet/parts", storage=google)
    assert (again.to_dict()["from_store"], again.to_dict()["logs_read"]) == (4, 0)
    assert again.rows == first.rows


def test_files_and_other_stores(robot: sesc.Robot, logs: Path, tmp_path: Path) -> None:
    here = fleet.run(robot, str(logs / "robot=*/day=*/*.csv"))
    there = fleet.run(robot, f"file://{logs}/robot=*/day=*/*.csv", store=f"file://{tmp_path}/parts")
    assert there.rows == here.rows and any((tmp_path / "parts").iterdir())
    with pytest.raises(ValueError, match=r"nowhere://bucket/\*.csv"):
        fleet.run(robot, "nowhere://bucket/*.csv")
    fsspec: Any = pytest.importorskip("fsspec")
    system = fsspec.filesystem("memory")
    for path in logs.rglob("*"):
        if path.is_file():
            system.pipe_file(f"/bucket/{path.relative_to(logs)}", path.read_bytes())
    memory = fleet.run(robot, "memory://bucket/robot=*/day=*/*.csv", store="memory://parts")
    assert [row["params"] for row in memory] == [row["params"] for row in here]
    assert os.fspath(tmp_path)
