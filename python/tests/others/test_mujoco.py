"""The OP2 on a foot with four force sensors in MuJoCo: recorded, fitted, diagnosed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sesc

mujoco = pytest.importorskip("mujoco")

#: Where the foot's cells are, m, in the frame of the sole.
CELLS = np.array([[0.041, 0.025], [0.041, -0.025], [-0.041, -0.025], [-0.041, 0.025]])
#: What the cells add to their forces, N.
NOISE = 0.02
POSTURES = 60


def standing_robot(urdf: str) -> Any:
    """MuJoCo's own reading of the URDF, free to fall, with servos, a sole and cells."""
    spec = mujoco.MjSpec.from_string(urdf)
    spec.compiler.fusestatic = False
    spec.option.timestep = 0.002
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.body("body_link").add_freejoint()
    sole = spec.body("r_sole")
    for k, (x, y) in enumerate(CELLS):
        # A cell is a ball of 1 mm whose lowest point lies in the plane of the sole.
        # A stiff one: a sole that sinks in on one side turns the robot against gravity.
        ball = sole.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[1e-3, 0, 0], pos=[x, y, 1e-3], mass=0)
        ball.priority, ball.solref, ball.solimp = 1, [0.004, 1], [0.99, 0.999, 1e-4, 0.5, 2]
        sole.add_site(name=f"cell{k}", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[0.01, 0, 0], pos=[x, y, 0])
        spec.add_sensor(
            type=mujoco.mjtSensor.mjSENS_TOUCH, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=f"cell{k}", name=f"cell{k}"
        )
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 0.1])
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            joint.armature, joint.damping = 0.01, [1.0, 0, 0]
            servo = spec.add_actuator(
                name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT, gaintype=mujoco.mjtGain.mjGAIN_FIXED
            )
            servo.set_to_position(kp=200.0)
    return spec.compile()


def recorded(robot: sesc.Robot, seed: int) -> dict[str, Any]:
    """Joint positions that were held, and what the cells read."""
    plan = sesc.plan(robot, "r_sole", poses=POSTURES, cop_box=0.015, candidates=2000, seed=seed)
    model = standing_robot(robot.urdf)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    places = [model.joint(joint).qposadr[0] for joint in plan.joints]
    servos = [model.actuator(joint).id for joint in plan.joints]
    rows: dict[str, list[Any]] = {joint: [] for joint in plan.joints}
    forces = []
    for q in plan.q:
        mujoco.mj_resetData(model, data)
        data.qpos[places], data.ctrl[servos] = q, q
        mujoco.mj_forward(model, data)
        # The sole is put flat on the floor.
        sole = data.body("r_sole")
        turn, place = sole.xmat.reshape(3, 3).T, sole.xpos
        data.qpos[:3] = turn @ (data.qpos[:3] - place)
        mujoco.mju_mat2Quat(data.qpos[3:7], turn.flatten())
        for _ in range(1500):
            mujoco.mj_step(model, data)
        assert np.abs(data.qvel).max() < 1e-3 and data.body("r_sole").xmat[8] > 1 - 1e-4
        read = data.sensordata + NOISE * rng.standard_normal(4)
        forces.append(read)
        for joint, place_of in zip(plan.joints, places, strict=True):
            rows[joint].append(data.qpos[place_of])
    cells = np.array(forces)
    # The whole weight stands on the cells.
    np.testing.assert_allclose(cells.sum(axis=1), robot.on("r_sole").total_mass * 9.81, rtol=0.01)
    return {**rows, **{f"fsr_{k + 1}": cells[:, k] for k in range(4)}}


@pytest.fixture(scope="module")
def robot(robots: Path) -> sesc.Robot:
    return sesc.Robot(robots / "op2" / "op2.urdf")


@pytest.fixture(scope="module")
def rows(robot: sesc.Robot) -> dict[str, Any]:
    return recorded(robot, 1)


def log_of(rows: dict[str, Any]) -> sesc.Log:
    return sesc.Log(rows, support="r_sole", cells=CELLS)


def test_the_cells_stand_under_the_centre_of_mass(robot: sesc.Robot, rows: dict[str, Any]) -> None:
    model = robot.on("r_sole")
    forces = np.stack([rows[f"fsr_{k + 1}"] for k in range(4)], axis=-1)
    cop = forces @ CELLS / forces.sum(axis=1, keepdims=True)
    gap = cop - model.cop({joint: rows[joint] for joint in model.joints})
    # Noise of the cells is 0.06 mm on the CoP; the sole gives way by less.
    assert np.sqrt(np.mean(gap**2)) < 1.5e-4


def test_nothing_is_found_where_nothing_is_hidden(robot: sesc.Robot, rows: dict[str, Any]) -> None:
    found = sesc.diagnose(robot, log_of(rows), prior="tight")
    assert found.verdict == "none" and found.health == []
    fit = sesc.fit(robot, log_of(rows), prior="cad")
    assert fit.held_out_rmse < 1.5e-4


def test_an_encoder_that_is_off_is_named(robot: sesc.Robot, rows: dict[str, Any]) -> None:
    turned = {**rows, "r_knee": np.array(rows["r_knee"]) - 0.026}
    found = sesc.diagnose(robot, log_of(turned), prior="tight")
    named = {f"{step['effect']}:{step['target']}" for step in found.to_dict()["steps"]}
    assert named == {"joint_offset:r_knee"}, found.sentence
