"""The fit as one writes it in Python: rows of all postures at once, then lstsq.

    numpy_fit.py FOLDER

reads fit_q.bin and fit_reading.bin of FOLDER (doubles, row by row), fits once per
line of standard input, and prints the seconds that took and the parameters.
"""

import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from prepare import rerooted


def rows_of(bodies, q):
    """CoP rows, x of all postures and then y: 2n × 42."""
    n = len(q)
    sines, cosines = np.sin(q), np.cos(q)
    # x and y rows of every body's orientation, 2n × 3.
    turns = [np.repeat(np.eye(3)[:2], n, axis=0)]
    rows = np.empty((2 * n, 2 * len(bodies)))
    rows[:, 0], rows[:, 1] = turns[0][:, 0], turns[0][:, 1]
    for i, body in enumerate(bodies[1:], 1):
        turn = turns[body.parent] @ body.placement[0]
        a, b = (body.axis + 1) % 3, (body.axis + 2) % 3
        s, c = np.tile(sines[:, i - 1], 2), np.tile(cosines[:, i - 1], 2)
        turn[:, a], turn[:, b] = c * turn[:, a] + s * turn[:, b], c * turn[:, b] - s * turn[:, a]
        turns.append(turn)
        a, b = sorted((a, b))
        rows[:, 2 * i], rows[:, 2 * i + 1] = turn[:, a], turn[:, b]
    return rows


def main():
    folder = Path(sys.argv[1])
    robot = ET.parse(folder / "robot.urdf").getroot()
    bodies = rerooted(robot, robot.find("link").get("name"))
    q = np.fromfile(folder / "fit_q.bin").reshape(-1, len(bodies) - 1)
    reading = np.fromfile(folder / "fit_reading.bin").reshape(-1, 2)
    for _ in sys.stdin:
        start = time.perf_counter()
        rows = rows_of(bodies, q)
        params = np.linalg.lstsq(rows, reading.T.ravel(), rcond=None)[0]
        seconds = time.perf_counter() - start
        print(repr(seconds), *(repr(float(x)) for x in params), flush=True)


if __name__ == "__main__":
    main()
