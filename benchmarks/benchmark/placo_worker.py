"""Ticks of PlaCo's `DynamicsSolver`, timed by a Python that has PlaCo and need not have this package.

The first line on standard input is JSON: `urdf` (text), `frame`, `joints` (names), `q` and `v` (one list a state) and
`x` (a target a state). Each line after it is a number of ticks, answered by the mean time of one, s.
"""

import json
import sys
import tempfile
import time
from itertools import cycle
from pathlib import Path

import numpy as np
import placo


def main() -> None:
    """Answer until standard input ends."""
    job = json.loads(sys.stdin.readline())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "robot.urdf"
        path.write_text(job["urdf"], encoding="utf-8")
        robot = placo.RobotWrapper(str(path), int(placo.Flags.ignore_collisions))
    solver = placo.DynamicsSolver(robot)
    solver.mask_fbase(True)
    solver.dt = 1e-3
    position = solver.add_position_task(job["frame"], np.array(job["x"][0]))
    position.configure("position", "soft", 1.0)
    posture = solver.add_joints_task()
    posture.set_joints(dict.fromkeys(job["joints"], 0.1))
    posture.configure("posture", "soft", 1e-3)
    q, v = robot.state.q.copy(), robot.state.qd.copy()
    states = []
    for angles, speeds, x in zip(job["q"], job["v"], job["x"], strict=True):
        for name, angle, speed in zip(job["joints"], angles, speeds, strict=True):
            q[robot.get_joint_offset(name)], v[robot.get_joint_v_offset(name)] = angle, speed
        states.append((q.copy(), v.copy(), np.array(x)))
    waiting = cycle(states)

    def tick() -> bool:
        state_q, state_v, x = next(waiting)
        robot.state.q, robot.state.qd = state_q, state_v
        robot.update_kinematics()
        position.target_world = x
        return bool(solver.solve().success)

    if not all(tick() for _ in states):
        raise SystemExit("PlaCo found no solution")
    print("ready", placo.__name__, flush=True)  # noqa: T201
    for line in sys.stdin:
        count = int(line)
        begin = time.perf_counter()
        for _ in range(count):
            tick()
        print((time.perf_counter() - begin) / count, flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
