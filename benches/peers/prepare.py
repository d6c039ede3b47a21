"""One description of the robot for every peer: standing on its support link.

    prepare.py URDF SUPPORT LIMITS FOLDER

writes into FOLDER

    robot.urdf   the robot re-rooted at SUPPORT, fixed joints folded
    robot.h      the same as C arrays, with the parameters of its serial chain
    limits.txt   a line per joint: name, lower, upper (rad), from LIMITS (degrees)

Whatever a peer could gain from the description is done here, once, outside the
timed loops: 20 joints and 21 bodies instead of 24 links, every axis +x, +y or +z
of its frame, rotations that are right angles to 1e-8 made exact.
"""

import csv
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

REVOLUTE = ("revolute", "continuous")


def rotation(rpy):
    (sr, cr), (sp, cp), (sy, cy) = ((np.sin(a), np.cos(a)) for a in rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def exact(matrix):
    """Right angles as they are meant."""
    whole = np.round(matrix)
    return np.where(np.abs(matrix - whole) < 1e-8, whole, matrix) + 0.0


def rpy(m):
    if abs(m[2, 0]) < 1 - 1e-12:
        return np.arctan2(m[2, 1], m[2, 2]), np.arcsin(-m[2, 0]), np.arctan2(m[1, 0], m[0, 0])
    pitch = -np.sign(m[2, 0]) * np.pi / 2
    return 0.0, pitch, np.arctan2(-m[0, 1], m[1, 1])


def numbers(element, key, default):
    text = default if element is None else element.get(key, default)
    return np.array([float(x) for x in text.split()])


def pose(element):
    """Rotation and translation of an <origin>."""
    origin = None if element is None else element.find("origin")
    return rotation(numbers(origin, "rpy", "0 0 0")), numbers(origin, "xyz", "0 0 0")


def times(a, b):
    return a[0] @ b[0], a[0] @ b[1] + a[1]


def inverse(a):
    return a[0].T, -a[0].T @ a[1]


def upright(axis, joint):
    """The frame, turned as little as possible, in which `axis` is a positive axis."""
    k = int(np.argmax(np.abs(axis)))
    if abs(abs(axis[k]) - 1) > 1e-12:
        sys.exit(f"joint {joint}: its axis {axis} is skewed; the peers are given aligned ones")
    turned = np.eye(3)
    if axis[k] < 0:
        turned[k, k] = turned[(k + 1) % 3, (k + 1) % 3] = -1
    return k, (turned, np.zeros(3))


class Body:
    def __init__(self, name, parent, joint, axis, placement):
        self.name, self.parent, self.joint = name, parent, joint
        self.axis, self.placement = axis, placement
        self.mass, self.moment = 0.0, np.zeros(3)


def rerooted(robot, support):
    """Bodies from the support outwards, a parent before its children."""
    links = {link.get("name"): link for link in robot.findall("link")}
    if support not in links:
        sys.exit(f"no link {support} to stand on")
    neighbours = {name: [] for name in links}
    for joint in robot.findall("joint"):
        if joint.get("type") not in (*REVOLUTE, "fixed") or joint.find("mimic") is not None:
            sys.exit(f"joint {joint.get('name')}: only revolute and fixed joints are compared")
        parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
        neighbours[parent].append((joint, child, False))
        neighbours[child].append((joint, parent, True))

    bodies = [Body(support, None, None, None, None)]

    def visit(link, came_by, body, frame):
        # `frame` is the link in the frame of the body that carries it.
        inertial = links[link].find("inertial")
        if inertial is not None:
            mass = float(inertial.find("mass").get("value"))
            _, centre = times(frame, pose(inertial))
            bodies[body].mass += mass
            bodies[body].moment += mass * centre
        for joint, other, against in neighbours[link]:
            if joint is came_by:
                continue
            origin = pose(joint)
            # Behind the joint: where its frame lies in the other link.
            here, there = (frame, inverse(origin)) if against else (times(frame, origin), None)
            there = there or (np.eye(3), np.zeros(3))
            if joint.get("type") == "fixed":
                visit(other, joint, body, times(here, there))
                continue
            axis = numbers(joint.find("axis"), "xyz", "1 0 0")
            axis = (-axis if against else axis) / np.linalg.norm(axis)
            k, turned = upright(axis, joint.get("name"))
            placement = times(here, turned)
            new = Body(other, body, joint.get("name"), k, (exact(placement[0]), placement[1]))
            bodies.append(new)
            visit(other, joint, len(bodies) - 1, times(inverse(turned), there))

    visit(support, None, 0, (np.eye(3), np.zeros(3)))
    return bodies


def chain(bodies):
    """r_i of every body, and what of them flat CoP rows see: x and y of r_0, then
    the two components of each r_i across the joint's axis."""
    total = sum(body.mass for body in bodies)
    carried = [body.mass for body in bodies]
    r = [body.moment / total for body in bodies]
    for i in reversed(range(1, len(bodies))):
        body = bodies[i]
        carried[body.parent] += carried[i]
        r[body.parent] = r[body.parent] + carried[i] / total * body.placement[1]
    full = np.concatenate(r)
    base = [x.copy() for x in r]
    for i in reversed(range(1, len(bodies))):
        body = bodies[i]
        along = base[i][body.axis]
        base[i][body.axis] = 0.0
        base[body.parent] += along * body.placement[0][:, body.axis]
    seen = [base[0][:2]] + [np.delete(base[i], b.axis) for i, b in enumerate(bodies) if i]
    return full, np.concatenate(seen)


def spaced(values):
    return " ".join(repr(float(x)) for x in values)


def urdf(bodies):
    """The robot for those who read a file."""
    lines = [
        '<?xml version="1.0"?>',
        '<robot name="rerooted">',
        # MuJoCo: keep the support a body, and do not look for meshes.
        '  <mujoco><compiler fusestatic="false" discardvisual="true"/></mujoco>',
    ]
    for body in bodies:
        lines.append(f'  <link name="{body.name}">')
        if body.mass > 0:
            lines += [
                f'    <inertial><origin xyz="{spaced(body.moment / body.mass)}"/>'
                f'<mass value="{body.mass!r}"/>',
                # Any inertia will do: nothing that is measured depends on it.
                '      <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>',
            ]
        lines.append("  </link>")
    for body in bodies[1:]:
        turn, place = body.placement
        axis = ["0", "0", "0"]
        axis[body.axis] = "1"
        lines += [
            f'  <joint name="{body.joint}" type="continuous">',
            f'    <origin xyz="{spaced(place)}" rpy="{spaced(rpy(turn))}"/>',
            f'    <parent link="{bodies[body.parent].name}"/><child link="{body.name}"/>',
            f'    <axis xyz="{" ".join(axis)}"/>',
            "  </joint>",
        ]
    return "\n".join([*lines, "</robot>", ""])


def array(kind, name, values):
    body = ",\n    ".join(values)
    return f"static const {kind} {name}[] = {{\n    {body},\n}};\n"


def header(bodies):
    full, base = chain(bodies)
    jointed = bodies[1:]
    vectors = lambda rows: [", ".join(repr(float(x)) for x in np.ravel(row)) for row in rows]
    return "\n".join(
        [
            "/* Written by prepare.py: body 0 is the support, body i + 1 hangs on joint i. */",
            "#pragma once",
            f"#define ROBOT_DOF {len(jointed)}",
            f"#define ROBOT_FULL {len(full)}",
            f"#define ROBOT_BASE {len(base)}",
            array("char *const", "robot_joint", [f'"{b.joint}"' for b in jointed]),
            "/* Body that carries joint i, and the axis (0, 1, 2) it turns about. */",
            array("int", "robot_parent", [str(b.parent) for b in jointed]),
            array("int", "robot_axis", [str(b.axis) for b in jointed]),
            "/* Joint frames in the bodies that carry them, row by row. */",
            array("double", "robot_rotation", vectors(b.placement[0] for b in jointed)),
            array("double", "robot_translation", vectors(b.placement[1] for b in jointed)),
            array("double", "robot_mass", vectors(b.mass for b in bodies)),
            array("double", "robot_centre", vectors(b.moment / (b.mass or 1.0) for b in bodies)),
            array("double", "robot_full_params", vectors(full.reshape(-1, 3))),
            array("double", "robot_base_params", vectors([x] for x in base)),
        ]
    )


def limits(bodies, file):
    rows = csv.DictReader(line for line in file.read_text().splitlines() if line[:1] != "#")
    given = {row["joint"]: (row["lower_deg"], row["upper_deg"]) for row in rows}
    lines = []
    for body in bodies[1:]:
        if body.joint not in given:
            sys.exit(f"{file}: no limits of joint {body.joint}")
        bounds = np.deg2rad([float(x) for x in given[body.joint]])
        lines.append(f"{body.joint} {spaced(bounds)}\n")
    return "".join(lines)


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    source, support, bounds, folder = sys.argv[1:]
    folder = Path(folder)
    bodies = rerooted(ET.parse(source).getroot(), support)
    folder.mkdir(parents=True, exist_ok=True)
    products = {
        "robot.urdf": urdf(bodies),
        "robot.h": header(bodies),
        "limits.txt": limits(bodies, Path(bounds)),
    }
    for name, text in products.items():
        path = folder / name
        # What has not changed keeps its date, and what was built from it stays.
        if not path.exists() or path.read_text() != text:
            path.write_text(text)


if __name__ == "__main__":
    main()
