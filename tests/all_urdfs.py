#!/usr/bin/env python3
"""Run every URDF of a folder through `sesc` and print a table.

    tests/all_urdfs.py FOLDER [--supports N] [--pinocchio]

For each file: inspect (ranks), verify (generated functions against the
reference), and predict on random postures. With --pinocchio (PyPI package
`pin`), predictions are compared with Pinocchio as a third opinion, with
--no-snap. Exit code 1 if anything disagrees; files that `sesc` refuses are
listed with the reason.
"""

import argparse
import csv
import io
import json
import pathlib
import random
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def sesc(*arguments):
    return subprocess.run(
        [SESC, *map(str, arguments)], capture_output=True, text=True, check=False
    )


def links_to_stand_on(urdf, count):
    """The root, then links spread over the file (their order is stable)."""
    import xml.etree.ElementTree as tree

    root = tree.parse(urdf).getroot()
    names = [link.get("name") for link in root.findall("link")]
    children = {joint.find("child").get("link") for joint in root.findall("joint")}
    chosen = [name for name in names if name not in children][:1]
    step = max(1, len(names) // max(1, count))
    for name in reversed(names[::step]):
        if name not in chosen and len(chosen) < count:
            chosen.append(name)
    return chosen


def pinocchio_error(urdf, support, joints, folder):
    """Largest CoM difference to Pinocchio on 20 postures, m; None if it cannot read the file."""
    import numpy
    import pinocchio

    try:
        # A free root, or the mass of the root link is left out.
        root = pinocchio.JointModelFreeFlyer()
        model = pinocchio.buildModelFromUrdf(str(urdf), root, mimic=True)
    except Exception:  # its own parser's many complaints
        return None
    if any(not model.existJointName(joint) for joint in joints):
        return None
    if not model.existFrame(support):
        return None
    data = model.createData()
    generator = random.Random(7)
    postures = [[generator.uniform(-1, 1) for _ in joints] for _ in range(20)]
    log = folder / "poses.csv"
    with log.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["pose", *joints])
        writer.writerows([k, *posture] for k, posture in enumerate(postures))
    run = sesc("predict", urdf, "--support", support, "--no-snap", "--data", log)
    if run.returncode != 0:
        return float("inf")
    worst = 0.0
    for posture, row in zip(postures, csv.DictReader(io.StringIO(run.stdout))):
        q = pinocchio.neutral(model)
        for joint, value in zip(joints, posture):
            place = model.joints[model.getJointId(joint)]
            if place.nq == 2:  # continuous: cosine, sine
                q[place.idx_q], q[place.idx_q + 1] = numpy.cos(value), numpy.sin(value)
            else:
                q[place.idx_q] = value
        pinocchio.framesForwardKinematics(model, data, q)
        centre = pinocchio.centerOfMass(model, data, q)
        frame = data.oMf[model.getFrameId(support)]
        expected = frame.actInv(centre)
        found = [float(row[f"com_{axis}"]) for axis in "xyz"]
        worst = max(worst, *(abs(a - b) for a, b in zip(expected, found)))
    return worst


def shown(metres):
    return "not finite" if metres is None else f"{metres:.1e}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--supports", type=int, default=2, help="links to stand on, per robot")
    parser.add_argument("--pinocchio", action="store_true", help="compare with Pinocchio too")
    options = parser.parse_args()
    build = subprocess.run(
        ["cargo", "build", "--quiet", "--release", "--message-format=json"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )
    global SESC
    built = [json.loads(line) for line in build.stdout.splitlines()]
    SESC = next(
        item["executable"] for item in built
        if item.get("target", {}).get("name") == "sesc" and item.get("executable")
    )
    heads = ["file", "support", "dof", "full", "base", "cop", "worst CoM, m", "allowed, m", "pinocchio, m"]
    rows, refused, bad = [], [], 0
    with tempfile.TemporaryDirectory() as scratch:
        for urdf in sorted(options.folder.rglob("*.urdf")):
            name = str(urdf.relative_to(options.folder))
            try:
                supports = links_to_stand_on(urdf, options.supports)
            except Exception as error:  # not even XML
                refused.append((name, str(error)))
                continue
            for support in supports or ["base_link"]:
                inspect = sesc("inspect", urdf, "--support", support, "--json")
                if inspect.returncode == 2:
                    refused.append((name, inspect.stderr.strip().splitlines()[-1]))
                    break
                facts = json.loads(inspect.stdout)
                verify = sesc("verify", urdf, "--support", support, "--samples", 200, "--json")
                found = json.loads(verify.stdout) if verify.stdout else {"pass": False}
                other = None
                if options.pinocchio:
                    other = pinocchio_error(urdf, support, facts["joints"], pathlib.Path(scratch))
                good = found["pass"] and inspect.returncode == 0 and (other is None or other < 1e-12)
                bad += not good
                rows.append([
                    name, support, facts["dof"], facts["full_params"], facts["base_params"],
                    facts["rank"]["cop"],
                    shown(found.get("worst_error", {}).get("com")),
                    shown(found.get("bound", {}).get("com")),
                    "" if other is None else shown(other),
                    "" if good else "FAIL",
                ])
    table = [heads + [""], *([str(cell) for cell in row] for row in rows)]
    widths = [max(len(row[k]) for row in table) for k in range(len(table[0]))]
    for row in table:
        print("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip())
    for name, reason in refused:
        print(f"refused {name}: {reason}")
    print(f"{len(rows)} runs, {bad} disagree, {len(refused)} files refused")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
