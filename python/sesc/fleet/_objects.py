"""Object stores by their addresses: ``s3://``, ``gs://`` and whatever fsspec knows.

fsspec and the package of the store (``s3fs``, ``gcsfs``) are imported when an address is met. A
request that fails is sent again with growing pauses, since stores throttle (503 SlowDown) and
connections end in the middle; bytes that are fewer than the store says count as a failure.
"""

from __future__ import annotations

import os
import random
import time
import uuid
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, TypeVar

from .._errors import ArgumentError

__all__ = ["Objects", "is_address", "local"]

#: Requests of one kind until it is given up, with pauses of 0.2, 0.4, ... 5 s between them.
TRIES = 8
#: Pause after the first failure, s, and the longest.
PAUSE = (0.2, 5.0)
#: What another try does not mend.
FINAL = (FileNotFoundError, PermissionError, IsADirectoryError, ValueError, TypeError, ImportError)
#: Stores in which an object appears when all its bytes have come.
WHOLE = {"s3", "s3a", "gs", "gcs", "az", "abfs", "adl", "oss", "oci", "memory"}
#: Endings of logs.
LOGS = (".csv", ".csv.gz", ".parquet", ".mcap")
#: Endings of what stands beside logs.
ASIDE = (".toml", ".urdf", ".xacro")

T = TypeVar("T")


def is_address(path: str | os.PathLike[str]) -> bool:
    """Whether a path is an address of another machine's: ``s3://bucket/log.csv``."""
    scheme, found, _ = local(path).partition("://")
    return bool(found and scheme) and "/" not in scheme and "\\" not in scheme


def local(path: str | os.PathLike[str]) -> str:
    """A path without ``file://``."""
    return os.fspath(path).removeprefix("file://")


class Objects:
    """Reads and writes objects for the library; it can be pickled.

    Args:
        options: what fsspec is given for these stores, such as ``{"anon": True}`` or
            ``{"endpoint_url": "http://127.0.0.1:5000"}``.
    """

    def __init__(self, options: Mapping[str, Any] | None = None) -> None:
        self._options = dict(options or {})

    def _of(self, address: str) -> tuple[Any, str, str]:
        """The file system of an address, the path there, and what to put before paths."""
        scheme = address.partition("://")[0]
        try:
            fsspec: Any = import_module("fsspec.core")
            system, path = fsspec.url_to_fs(address, **self._options)
        except ImportError as error:
            raise ImportError(f"{address}: {error}; install fsspec and the package of {scheme}://") from error
        except ValueError as error:
            raise ArgumentError(f"{address}: {error}") from error
        return system, path, f"{scheme}://"

    def _tried(self, call: Callable[[], T]) -> T:
        for tried in range(TRIES - 1):
            try:
                return call()
            except FINAL:
                raise
            except Exception:
                pause = min(PAUSE[0] * 2**tried, PAUSE[1])
                # Many workers that were throttled together come back one by one.
                time.sleep(pause * random.uniform(0.5, 1.0))
        return call()

    def stamp(self, address: str) -> tuple[int, str] | None:
        """Size and ETag, or whatever else changes with an object."""
        system, path, _ = self._of(address)

        def about() -> dict[str, Any]:
            # A listing may be older than the object.
            system.invalidate_cache(system._parent(path))
            found: dict[str, Any] = system.info(path)
            return found

        try:
            found = self._tried(about)
        except FINAL:
            return None
        for key in ("ETag", "etag", "generation", "md5Hash", "created", "mtime", "LastModified"):
            if found.get(key) is not None:
                return int(found["size"]), str(found[key])
        return None

    def read(self, address: str) -> bytes:
        """All bytes."""
        system, path, _ = self._of(address)

        def whole() -> bytes:
            found: bytes = system.cat_file(path)
            return found

        return self._tried(whole)

    def write(self, address: str, text: str | bytes) -> None:
        """Put an object, whole or not at all."""
        system, path, prefix = self._of(address)
        data = text.encode() if isinstance(text, str) else text

        def put() -> None:
            if prefix[:-3] in WHOLE:
                system.pipe_file(path, data)
                return
            system.makedirs(system._parent(path), exist_ok=True)
            beside = f"{path}.{uuid.uuid4().hex}.part"
            system.pipe_file(beside, data)
            system.mv(beside, path)

        self._tried(put)

    def logs(self, address: str) -> list[tuple[str, str | None]]:
        """Logs of a pattern or a folder, or the object itself; each with the URDF that is
        beside it or in a folder ``name=value`` above."""
        system, path, prefix = self._of(address)
        is_pattern = any(sign in path for sign in "*?[")
        root = path
        while any(sign in root for sign in "*?["):
            root = root.rpartition("/")[0]

        def listed() -> list[str]:
            system.invalidate_cache()
            found: list[str] = system.find(root)
            return found

        names = self._tried(listed)
        known = set(names)
        if is_pattern:
            found = [name for name in self._tried(lambda: list(system.glob(path))) if name in known]
            found = [name for name in found if not name.endswith(ASIDE)]
        elif path in known:
            found = [path]
        else:
            found = [name for name in names if name.endswith(LOGS)]
        if not found:
            raise FileNotFoundError(f"{address}: no log has such a name")
        return [(prefix + name, _urdf(name, known, prefix)) for name in sorted(found)]


def _urdf(log: str, known: set[str], prefix: str) -> str | None:
    folder = log.rpartition("/")[0]
    while True:
        if f"{folder}/robot.urdf" in known:
            return f"{prefix}{folder}/robot.urdf"
        above, _, name = folder.rpartition("/")
        if "=" not in name or "=" not in above.rpartition("/")[2]:
            return None
        folder = above
