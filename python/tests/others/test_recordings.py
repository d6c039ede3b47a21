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
