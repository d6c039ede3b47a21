"""The same centre of mass as Pinocchio's, for every robot of the repository on every link."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Any

import numpy as np
import pytest

import sesc

from conftest import repository

pin = pytest.importorskip("pinocchio")

ROBOTS = sorted(path.stem for path in (repository() / "robots").glob("*/*.urdf"))


def configuration(peer: Any, urdf: ET.Element, joints: dict[str, float]) -> Any:
    """Pinocchio's vector of positions: angles of continuous joints are cosine and sine there,
    and joints that follow others have places of their own."""
    q = pin.neutral(peer)
    joints = dict(joints)
    for joint in urdf.iter("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            leader = joints[mimic.attrib["joint"]]
            factor, offset = (float(mimic.get(key, default)) for key, default in (("multiplier", 1), ("offset", 0)))
            joints[joint.attrib["name"]] = factor * leader + offset
    for name, position in joints.items():
        joint = peer.joints[peer.getJointId(name)]
        values = [position] if joint.nq == 1 else [np.cos(position), np.sin(position)]
        q[joint.idx_q : joint.idx_q + joint.nq] = values
    return q


def test_all_robots_are_compared() -> None:
    assert len(ROBOTS) >= 7


@pytest.mark.parametrize("name", ROBOTS)
def test_the_centre_of_mass_is_pinocchios(name: str) -> None:
    text = (repository() / "robots" / name / f"{name}.urdf").read_text()
    ours = sesc.Robot(text, snap=False)
    # Its reader refuses limits without velocity, which say nothing about masses.
    document = ET.fromstring(text)
    for limit in document.iter("limit"):
        limit.attrib.setdefault("velocity", "1")
    # Free to move: a root that is fixed to the world would not count in its centre of mass.
    peer = pin.buildModelFromXML(ET.tostring(document, encoding="unicode"), pin.JointModelFreeFlyer())
    data, rng = peer.createData(), np.random.default_rng(1)
    for support in ours.links:
        model = ours.on(support)
        frame = peer.getFrameId(support, pin.FrameType.BODY)
        for q in rng.uniform(-1.0, 1.0, (5, model.dof)):
            theirs = configuration(peer, document, dict(zip(model.joints, q, strict=True)))
            com = pin.centerOfMass(peer, data, theirs)
            pin.updateFramePlacements(peer, data)
            np.testing.assert_allclose(model.com(q), data.oMf[frame].actInv(com), atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_motor_applies_pinocchios_generalized_gravity(name: str) -> None:
    text = (repository() / "robots" / name / f"{name}.urdf").read_text()
    document = ET.fromstring(text)
    for limit in document.iter("limit"):
        limit.attrib.setdefault("velocity", "1")
    # Its root is fixed to the world: ours stands on the root link.
    peer = pin.buildModelFromXML(ET.tostring(document, encoding="unicode"))
    data, rng = peer.createData(), np.random.default_rng(3)
    children = {child.attrib["link"] for child in document.iter("child")}
    root = next(link.attrib["name"] for link in document.iter("link") if link.attrib["name"] not in children)
    model = sesc.Robot(text, snap=False).on(root)
    weight = -peer.gravity.linear[2] * model.total_mass
    for q in rng.uniform(-1.0, 1.0, (5, model.dof)):
        joints = dict(zip(model.joints, q, strict=True))
        theirs = pin.computeGeneralizedGravity(peer, data, configuration(peer, document, joints))
        holding = {joint: theirs[peer.joints[peer.getJointId(joint)].idx_v] for joint in model.joints}
        for joint in document.iter("joint"):
            mimic = joint.find("mimic")
            if mimic is not None:
                own = theirs[peer.joints[peer.getJointId(joint.attrib["name"])].idx_v]
                holding[mimic.attrib["joint"]] += float(mimic.get("multiplier", 1)) * own
        np.testing.assert_allclose(-weight * model.gravity_moments(q), list(holding.values()), atol=1e-9)


def test_positions_go_there_by_name_and_back() -> None:
    model = sesc.Robot(sesc.OP2_URDF).on("r_sole")
    peer = pin.buildModelFromXML(sesc.OP2_URDF, pin.JointModelFreeFlyer())
    names = list(peer.names)[2:]
    mixed = sorted(model.joints)
    q = np.random.default_rng(2).uniform(-0.5, 0.5, (50, model.dof))
    recorded = model.reordered(q, to=mixed)
    assert mixed != model.joints and sorted(names) == mixed
    np.testing.assert_array_equal(model.reordered(recorded, joints=mixed), q)
    data = peer.createData()
    for k, theirs in enumerate(model.reordered(recorded, joints=mixed, to=names)):
        com = pin.centerOfMass(peer, data, np.concatenate([pin.neutral(peer)[:7], theirs]))
        pin.updateFramePlacements(peer, data)
        sole = data.oMf[peer.getFrameId("r_sole")]
        np.testing.assert_allclose(sole.actInv(com), model.com(q[k]), atol=1e-12)
