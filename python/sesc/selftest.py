"""``python -m sesc.selftest``: whether this installation computes what it should.

A simulated OP2 with an encoder that is off by 1.5 degrees is diagnosed; functions are compared
with closed forms. Exit code 0 where all holds.
"""

from __future__ import annotations

import sys
import time

import numpy as np

import sesc

__all__ = ["main"]

_POLE = """<robot name='pole'><link name='foot'/><link name='top'><inertial><origin xyz='0 0 1'/>
<mass value='2'/></inertial></link><joint name='hip' type='revolute'><parent link='foot'/>
<child link='top'/><origin xyz='0.1 0 0'/><axis xyz='0 1 0'/>
<limit lower='-1' upper='1' effort='1' velocity='1'/></joint></robot>"""


def _functions() -> bool:
    model = sesc.Robot(_POLE).on("foot")
    q = np.linspace(-1, 1, 1000)[:, None]
    want = np.stack([0.1 + np.sin(q[:, 0]), np.zeros(1000), np.cos(q[:, 0])], axis=1)
    return bool(np.abs(model.com(q, threads=2) - want).max() < 1e-14)


def _diagnosis() -> bool:
    robot = sesc.Robot(sesc.OP2_URDF)
    log = sesc.simulate(
        robot.on("r_sole"), 100, range=0.5, noise=5e-4, hide={"joint_offset:r_knee": 0.026}
    )
    found = sesc.diagnose(robot, log)
    return any("joint_offset:r_knee" in effects for effects in found.explanations)


def _parts() -> bool:
    robot = sesc.Robot(sesc.OP2_URDF)
    logs = [sesc.simulate(robot.on("r_sole"), 200, range=0.5, noise=1e-4, seed=seed) for seed in (1, 2)]
    parts = [sesc.Part.from_bytes(bytes(sesc.gather(robot, log))) for log in logs]
    apart, together = sesc.fit(parts[0] | parts[1]), sesc.fit(robot, logs)
    return bool(np.abs(apart.params - together.params).max() < 1e-12)


def main() -> int:
    """Run all checks; gives the exit code."""
    failed = 0
    for name, check in (("functions", _functions), ("diagnosis", _diagnosis), ("parts", _parts)):
        start = time.perf_counter()
        holds = check()
        failed += not holds
        print(f"{name:12} {'ok' if holds else 'FAILED'}  {time.perf_counter() - start:.2f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
