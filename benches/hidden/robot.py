"""CAD's robot in numpy: CoM of many postures at once, seen from the sole.

    CoM = Σ m_i T_i c_i / Σ m_i        standing still: CoP = (CoM_x, CoM_y)

It is what a user of the peers has beside the log: the URDF.  It shares no code with sesc, the
reference or MuJoCo; `check.py` compares the three.
"""

from __future__ import annotations

import xml.etree.ElementTree as xml
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def turn(rpy: Array) -> Array:
    """Rotation about fixed axes x, y, z, as URDF has it."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def about(axis: Array, angle: Array) -> Array:
    """Rotations about a unit axis, one for each angle (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    s, c = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + s * cross + (1 - c) * (cross @ cross)


def vector(element: xml.Element | None, key: str, default: str = "0 0 0") -> Array:
    text = default if element is None else element.get(key, default)
    return np.array([float(x) for x in text.split()])


@dataclass
class Joint:
    """A joint of the URDF."""

    name: str
    parent: str
    child: str
    turn: Array
    place: Array
    axis: Array
    #: Column of q; none where it is fixed.
    column: int | None
    slides: bool


class Robot:
    """The masses and joints of a URDF on one sole."""

    def __init__(self, urdf: Path, support: str, joints: list[str]) -> None:
        root = xml.parse(urdf).getroot()
        self.support, self.columns = support, joints
        self.joints: list[Joint] = []
        for joint in root.findall("joint"):
            origin, axis = joint.find("origin"), vector(joint.find("axis"), "xyz", "1 0 0")
            name = joint.get("name", "")
            self.joints.append(
                Joint(
                    name,
                    joint.find("parent").get("link"),  # type: ignore[union-attr, arg-type]
                    joint.find("child").get("link"),  # type: ignore[union-attr, arg-type]
                    turn(vector(origin, "rpy")),
                    vector(origin, "xyz"),
                    axis / max(float(np.linalg.norm(axis)), 1e-12),
                    joints.index(name) if name in joints else None,
                    joint.get("type") == "prismatic",
                )
            )
        self.links: list[str] = []
        masses, centres = [], []
        for link in root.findall("link"):
            inertial = link.find("inertial")
            if inertial is None:
                continue
            mass = inertial.find("mass")
            self.links.append(link.get("name", ""))
            masses.append(0.0 if mass is None else float(mass.get("value", "0")))
            centres.append(vector(inertial.find("origin"), "xyz"))
        self.mass, self.centre = np.array(masses), np.array(centres)

    def frames(self, q: Array) -> dict[str, tuple[Array, Array]]:
        """Rotation (postures × 3 × 3) and place (postures × 3) of each link, seen from the sole."""
        n = len(q)
        children = {joint.child for joint in self.joints}
        (root,) = {joint.parent for joint in self.joints} - children
        frames = {root: (np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 3)))}
        left = list(self.joints)
        while left:
            joint = next(joint for joint in left if joint.parent in frames)
            left.remove(joint)
            rotation, place = frames[joint.parent]
            place = place + rotation @ joint.place
            rotation = rotation @ joint.turn
            if joint.column is not None:
                x = q[:, joint.column]
                if joint.slides:
                    place = place + np.einsum("nij,j,n->ni", rotation, joint.axis, x)
                else:
                    rotation = rotation @ about(joint.axis, x)
            frames[joint.child] = (rotation, place)
        sole, origin = frames[self.support]
        return {
            link: (np.swapaxes(sole, 1, 2) @ rotation, np.einsum("nji,nj->ni", sole, place - origin))
            for link, (rotation, place) in frames.items()
        }

    def com(self, q: Array, mass: Array | None = None, centre: Array | None = None) -> Array:
        """CoM of each posture in the frame of the sole, m."""
        mass = self.mass if mass is None else mass
        centre = self.centre if centre is None else centre
        frames = self.frames(q)
        total = np.zeros((len(q), 3))
        for link, m, c in zip(self.links, mass, centre, strict=True):
            rotation, place = frames[link]
            total += m * (place + rotation @ c)
        return total / mass.sum()
