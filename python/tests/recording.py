"""A recording as ROS 2 writes it (MCAP, messages in CDR), without a library of either.

Layouts: <https://mcap.dev/spec> and the OMG's CDR, little-endian.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import sesc

MAGIC = b"\x89MCAP0\r\n"


def text(given: str) -> bytes:
    """A string of MCAP."""
    return struct.pack("<I", len(given.encode())) + given.encode()


def entry(kind: int, content: bytes) -> bytes:
    """A record of MCAP."""
    return struct.pack("<BQ", kind, len(content)) + content


class Message:
    """A message in CDR: values are aligned to their size, behind four bytes of encapsulation."""

    def __init__(self, stamp: int, frame: str) -> None:
        self.data = b""
        self.put("i", stamp // 10**9).put("I", stamp % 10**9).string(frame)

    def put(self, kind: str, *values: float) -> Message:
        size = struct.calcsize(kind)
        if values:
            self.data += bytes(-len(self.data) % size)
        self.data += struct.pack(f"<{len(values)}{kind}", *values)
        return self

    def string(self, given: str) -> Message:
        data = given.encode() + b"\0"
        self.put("I", len(data))
        self.data += data
        return self

    def __bytes__(self) -> bytes:
        return b"\0\1\0\0" + self.data


def joint_state(stamp: int, joints: list[str], positions: Any) -> bytes:
    message = Message(stamp, "")
    message.put("I", len(joints))
    for joint in joints:
        message.string(joint)
    message.put("I", len(joints)).put("d", *positions)
    return bytes(message.put("I", 0).put("I", 0))


def wrench(stamp: int, cop: Any, weight: float) -> bytes:
    """The force of a robot of that weight, N, on a plate, whose moments are the CoP's."""
    return bytes(Message(stamp, "").put("d", 0.0, 0.0, weight, cop[1] * weight, -cop[0] * weight, 0.0))


def record(path: Path, log: sesc.Log, model: sesc.Model, rate: float = 50.0, stay: float = 0.6) -> None:
    """The postures of a simulated log: the robot goes to each in ``stay`` seconds and stays there
    as long. The sidecar says the support."""
    columns = log.columns()
    assert columns is not None
    q = list(zip(*(columns[joint] for joint in model.joints)))
    cop = list(zip(columns["cop_x"], columns["cop_y"]))
    schemas = ["sensor_msgs/msg/JointState", "geometry_msgs/msg/WrenchStamped"]
    out = [MAGIC, entry(1, text("ros2") + text("sesc"))]
    for k, (schema, topic) in enumerate(zip(schemas, ["/joint_states", "/cop"]), 1):
        out.append(entry(3, struct.pack("<H", k) + text(schema) + text("ros2msg") + text("")))
        out.append(entry(4, struct.pack("<HH", k, k) + text(topic) + text("cdr") + struct.pack("<I", 0)))
    step, steps, weight = 0, int(rate * stay), 9.80665 * model.total_mass
    for k, posture in enumerate(q):
        before = q[max(k - 1, 0)]
        for part in range(2 * steps):
            stamp, share = int(1e9 * step / rate), min(part / steps, 1.0)
            now = [a + (b - a) * share for a, b in zip(before, posture)]
            for channel, data in ((1, joint_state(stamp, model.joints, now)), (2, wrench(stamp, cop[k], weight))):
                out.append(entry(5, struct.pack("<HIQQ", channel, step, stamp, stamp) + data))
            step += 1
    out += [entry(15, bytes(4)), entry(2, bytes(20)), MAGIC]
    path.write_bytes(b"".join(out))
    path.with_name(path.name + ".toml").write_text(f'support = "{model.support}"\n')
