"""Recordings of ROS 2, written and read by the official library of MCAP."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

writer = pytest.importorskip("mcap_ros2.writer")
reader = pytest.importorskip("mcap_ros2.reader")

HEADER = """
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
JOINT_STATE = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n"
WRENCH = """std_msgs/Header header
geometry_msgs/Wrench wrench
================================================================================
MSG: geometry_msgs/Wrench
geometry_msgs/Vector3 force
geometry_msgs/Vector3 torque
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


def record(path: Path, model: sesc.Model, q: Any, cop: Any, rate: float = 100.0, stay: float = 0.6) -> None:
    """A robot that goes from posture to posture in 0.6 s and stays there as long."""
    weight = model.total_mass * 9.81
    with open(path, "wb") as file, writer.Writer(file) as bag:
        joint_state = bag.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE + HEADER)
        wrench = bag.register_msgdef("geometry_msgs/msg/WrenchStamped", WRENCH + HEADER)
        step = 0
        steps = int(rate * stay)
        for k, (posture, place) in enumerate(zip(q, cop, strict=True)):
            before = q[max(k - 1, 0)]
            for part in range(2 * steps):
                share = min(part / steps, 1.0)
                stamp = int(1e9 * step / rate)
                header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": model.support}
                position = before + (posture - before) * share
                joints = {"name": model.joints, "position": position.tolist(), "velocity": [], "effort": []}
                bag.write_message("/joint_states", joint_state, {"header": header, **joints}, stamp, stamp, step)
                turn = {"x": place[1] * weight, "y": -place[0] * weight, "z": 0.0}
                force = {"x": 0.0, "y": 0.0, "z": weight}
                reading = {"header": header, "wrench": {"force": force, "torque": turn}}
                bag.write_message("/cop", wrench, reading, stamp, stamp, step)
                step += 1


def test_a_recording_of_stays_is_diagnosed(tmp_path: Path) -> None:
    robot = sesc.Robot(sesc.OP2_URDF)
    model = robot.on("r_sole")
    hidden = {"joint_offset:r_knee": 0.026}
    log = sesc.simulate(model, 60, range=0.4, noise=1e-4, seed=3, hide=hidden)
    columns = log.columns()
    q = np.stack([columns[joint] for joint in model.joints], axis=-1)
    cop = np.stack([columns["cop_x"], columns["cop_y"]], axis=-1)
    record(tmp_path / "stays.mcap", model, q, cop)
    found = sesc.diagnose(robot, sesc.Log(tmp_path / "stays.mcap", support="r_sole"), prior="tight", motion="off")
    steps = found.to_dict()["steps"]
    assert [f"{step['effect']}:{step['target']}" for step in steps] == ["joint_offset:r_knee"], found.sentence
    offset = steps[0]["parameters"]["offset_rad"]
    assert abs(offset["value"] - 0.026) < 4 * offset["std"]


def test_the_recording_of_a_diagnosis_is_read(tmp_path: Path) -> None:
    robot = sesc.Robot(sesc.OP2_URDF)
    model = robot.on("r_sole")
    log = sesc.simulate(model, 60, range=0.4, noise=1e-4, seed=3, hide={"joint_offset:r_knee": 0.026})
    log.save(tmp_path / "log.csv")
    (tmp_path / "op2.urdf").write_text(sesc.OP2_URDF)
    words = ["diagnose", "op2.urdf", "--data", "log.csv", "--mcap", "found.mcap"]
    subprocess.run([sys.executable, "-m", "sesc", *words], cwd=tmp_path, check=True, capture_output=True)
    topics: dict[str, list[Any]] = {}
    stamps = set()
    for message in reader.read_ros2_messages(tmp_path / "found.mcap"):
        stamp = message.ros_msg.header.stamp
        assert message.log_time_ns == stamp.sec * 10**9 + stamp.nanosec
        stamps.add(message.log_time_ns)
        topics.setdefault(message.channel.topic, []).append(message.ros_msg)
    # The log has no times.
    assert stamps == {k * 10**9 for k in range(60)}
    columns = log.columns()
    states = topics.pop("/joint_states")
    assert all(state.name == list(model.joints) for state in states)
    q = np.stack([columns[joint] for joint in model.joints], axis=-1)
    assert np.array_equal([state.position for state in states], q)
    assert all(message.header.frame_id == "r_sole" for track in topics.values() for message in track)
    found = {
        topic: np.array([[at.x, at.y] for at in (getattr(m, "point", None) or m.vector for m in track)])
        for topic, track in topics.items()
    }
    measured = found.pop("/cop/measured")
    assert np.array_equal(measured, np.stack([columns["cop_x"], columns["cop_y"]], axis=-1))
    assert np.allclose(found["/cop/cad"], model.com(q)[:, :2], rtol=0, atol=1e-12)
    for by in ("cad", "explained"):
        gap = measured - found.pop(f"/cop/{by}")
        assert np.allclose(found.pop(f"/cop_gap/{by}"), gap, rtol=0, atol=1e-15)
    # 1e-4 m of noise on each axis; the knee moves the CoP by millimetres.
    assert np.sqrt(np.mean(gap**2)) < 1.2e-4
    assert not found
