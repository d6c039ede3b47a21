"""Logs of a robot in MuJoCo with an effect hidden: its statics, posture by posture.

    φ = q + e_joint(q, τ(φ), t, side)        CoP = CoM_xy(φ) + e_sensor(CoM_xy, t)

MuJoCo gives places of links, joints and centres of subtrees; τ is gravity's moment about each joint
(N m), of what hangs on it seen from the sole.  The sizes are such that the effect is seen with χ²
from 100 to 20,000 in the log.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

POSTURES, FRESH, APART_S, NOISE_M, BOX_M, GRAVITY = 120, 500, 4.0, 0.0005, 0.023, 9.81
#: Postures that say how large an effect is.
FEW = 24
#: Kind of effect: where it acts, and whether sesc's list of named effects has it.
KINDS = {
    "joint_offset": ("joint", True),
    "joint_scale": ("joint", True),
    "joint_compliance": ("joint", True),
    "backlash": ("joint", True),
    "payload": ("link", True),
    "sensor_gain": ("sensor", True),
    "sensor_rotation": ("sensor", True),
    "encoder_eccentricity": ("joint", False),
    "joint_coupling": ("joint", False),
    "joint_curvature": ("joint", False),
    "joint_hysteresis": ("joint", False),
    "joint_drift": ("joint", False),
    "spring_hardening": ("joint", False),
    "sensor_crosstalk": ("sensor", False),
    "saturating": ("joint", False),
    "step": ("joint", False),
}


class Standing:
    """A robot of a URDF in MuJoCo, seen from its sole."""

    def __init__(self, urdf: Path, support: str) -> None:
        spec = mujoco.MjSpec.from_file(str(urdf))
        spec.compiler.fusestatic = False
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.sole = self.model.body(support).id
        joints = [self.model.joint(j) for j in range(self.model.njnt)]
        self.names = [joint.name for joint in joints]
        self.ranges = np.array([joint.range for joint in joints])
        # Bodies beyond each joint, seen from the sole.
        parents, beyond = self.model.body_parentid, []
        for joint in joints:
            body = joint.bodyid[0]
            below = np.zeros(self.model.nbody, bool)
            for k in range(1, self.model.nbody):
                below[k] = k == body or below[parents[k]]
            beyond.append((below, -1.0) if not below[self.sole] else (~below, 1.0))
        self.beyond = beyond

    def at(self, q: Array) -> tuple[Array, Array]:
        """CoM in the frame of the sole, m, and gravity's moment about each joint, N m."""
        data, mass = self.data, self.model.body_mass
        data.qpos[:] = q
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        sole = data.xmat[self.sole].reshape(3, 3)
        centres, up = data.xipos, sole[:, 2]
        com = sole.T @ (mass @ centres / mass.sum() - data.xpos[self.sole])
        moments = np.empty(len(q))
        for j, (bodies, sign) in enumerate(self.beyond):
            arm = mass[bodies] @ (centres[bodies] - data.xanchor[j])
            moments[j] = -sign * data.xaxis[j] @ np.cross(arm, -GRAVITY * up)
        return com, moments


def sole_ranges(names: list[str], ranges: Array) -> Array:
    """Ranges of drawn positions: within the joint's, of legs 0.4 rad and of the rest 0.9."""
    most = np.array([0.4 if any(w in name for w in ("hip", "knee", "ank")) else 0.9 for name in names])
    return np.clip(np.stack([-most, most], axis=1), ranges[:, :1], ranges[:, 1:])


class Hidden:
    """One effect at one place."""

    def __init__(self, kind: str, robot: Standing, rng: np.random.Generator) -> None:
        self.kind, self.site = kind, KINDS[kind][0]
        self.joint, self.other = rng.choice(len(robot.names), 2, replace=False)
        self.axis = int(rng.integers(2))
        self.phase, self.begin = rng.uniform(0, 2 * np.pi), rng.uniform(-0.1, 0.1)
        bodies = [k for k in range(1, robot.model.nbody) if robot.model.body_mass[k] > 1e-6 and k != robot.sole]
        self.body = int(rng.choice(bodies))
        self.place = {
            "joint": robot.names[self.joint],
            "link": robot.model.body(self.body).name,
            "sensor": "sensor",
        }[self.site]

    def of_joint(self, q: Array, moments: Array, part: float, side: float) -> float:
        """What is added to the position of its joint, over its size."""
        own, other, moment = q[self.joint], q[self.other], moments[self.joint]
        forms: dict[str, Callable[[], float]] = {
            "joint_offset": lambda: 1.0,
            "joint_scale": lambda: own,
            "joint_compliance": lambda: moment,
            "backlash": lambda: np.sign(moment),
            "encoder_eccentricity": lambda: np.sin(own + self.phase),
            "joint_coupling": lambda: other,
            "joint_curvature": lambda: own**2,
            "joint_hysteresis": lambda: side,
            "joint_drift": lambda: part,
            "spring_hardening": lambda: np.sign(moment) * np.sqrt(abs(moment)),
            "saturating": lambda: np.tanh(8 * (own - self.begin)),
            "step": lambda: float(own > self.begin),
        }
        return float(forms[self.kind]())

    def of_sensor(self, cop: Array, size: float) -> Array:
        """The reading."""
        if self.kind == "sensor_gain":
            return cop * (1 + size * np.eye(2)[self.axis])
        if self.kind == "sensor_rotation":
            return np.array([[np.cos(size), -np.sin(size)], [np.sin(size), np.cos(size)]]) @ cop
        return cop + size * np.eye(2)[self.axis] * cop[1 - self.axis]


def read(robot: Standing, q: Array, hidden: Hidden | None, size: float) -> tuple[Array, Array]:
    """Readings without noise, m, and true CoMs, m."""
    cops, coms = [], []
    mass = robot.model.body_mass.copy()
    if hidden is not None and hidden.site == "link":
        robot.model.body_mass[hidden.body] += size
    for k, posture in enumerate(q):
        phi = posture.copy()
        com, moments = robot.at(phi)
        if hidden is not None and hidden.site == "joint":
            side = np.sign(posture[hidden.joint] - q[k - 1, hidden.joint]) if k else 0.0
            # What gives way moves the moments that it gives way to.
            for _ in range(6):
                phi[hidden.joint] = posture[hidden.joint] + size * hidden.of_joint(
                    posture, moments, k / (len(q) - 1), side
                )
                com, moments = robot.at(phi)
        cop = com[:2].copy()
        if hidden is not None and hidden.site == "sensor":
            cop = hidden.of_sensor(cop, size)
        cops.append(cop)
        coms.append(com)
    robot.model.body_mass[:] = mass
    return np.array(cops), np.array(coms)


def balanced(robot: Standing, count: int, rng: np.random.Generator) -> Array:
    """Postures whose CoP is within the sole."""
    low, high = sole_ranges(robot.names, robot.ranges).T
    found: list[Array] = []
    while len(found) < count:
        q = rng.uniform(low, high)
        if np.abs(robot.at(q)[0][:2]).max() < BOX_M:
            found.append(q)
    return np.array(found)


def write(path: Path, names: list[str], columns: list[str], rows: Array, apart_s: float) -> None:
    t = apart_s * np.arange(len(rows))
    table = np.column_stack([t, np.arange(len(rows)), rows])
    np.savetxt(path, table, delimiter=",", header=",".join(["t", "pose", *names, *columns]), comments="", fmt="%.17g")


def simulate(urdf: Path, support: str, folder: Path, logs: int, seed: int) -> None:
    """Write `logs` logs of each kind into `folder`."""
    robot = Standing(urdf, support)
    for k, kind in enumerate(KINDS):
        for number in range(seed, seed + logs):
            rng = np.random.default_rng([number, k])
            q = balanced(robot, POSTURES, rng)
            sound = read(robot, q[:FEW], None, 0.0)[0]
            while True:
                hidden, wanted, size, chi2 = Hidden(kind, robot, rng), 10 ** rng.uniform(2, 4.3), 1e-3, 0.0
                for _ in range(4):
                    gaps = (read(robot, q[:FEW], hidden, size)[0] - sound) / NOISE_M
                    chi2 = float((gaps**2).sum()) * POSTURES / FEW
                    size *= min(np.sqrt(wanted / max(chi2, 1e-9)), 1e3)
                # No robot errs by more than 10°, a third of its reading or a fifth of its mass.
                most = {"joint": 0.17, "sensor": 0.33, "link": 0.2 * robot.model.body_mass.sum()}[hidden.site]
                if abs(size) < most and 0.8 < chi2 / wanted < 1.25:
                    break
            case = folder / f"{kind}-{number}"
            case.mkdir(parents=True, exist_ok=True)
            cop = read(robot, q, hidden, size)[0] + NOISE_M * rng.standard_normal((POSTURES, 2))
            write(case / "log.csv", robot.names, ["cop_x", "cop_y"], np.hstack([q, cop]), APART_S)
            fresh = balanced(robot, FRESH, rng)
            cop, com = read(robot, fresh, hidden, size)
            columns = ["cop_x", "cop_y", "com_x", "com_y", "com_z"]
            apart_s = APART_S * (POSTURES - 1) / (FRESH - 1)
            write(case / "fresh.csv", robot.names, columns, np.hstack([fresh, cop, com]), apart_s)
            truth = {
                "kind": kind,
                "is_in_table": kind not in ("saturating", "step"),
                "place": hidden.place,
                "chi2": round(wanted),
                "noise_m": NOISE_M,
                "support": support,
                "simulator": "mujoco",
                "urdf": "robots/op2/op2.urdf",
            }
            (case / "truth.json").write_text(json.dumps(truth, indent=2) + "\n")
