"""A robot that is a plant in the same process: its clock goes on by one period a reading, without waiting."""

import numpy as np

from aspect_control.plants import RigidBodyPlant
from aspect_control.simulation.integrators import RungeKutta4


class PlantRobot:
    """What `simulate` moves, as the loop sees a robot with a clock of its own.

    Attributes:
        written: Every torque that it was given.
        time: Its time, s.
    """

    def __init__(self, arm, q, dt=1e-3):
        self.plant, self.method, self.dt = RigidBodyPlant(arm), RungeKutta4(), dt
        self.q, self.v, self.tau = np.array(q, dtype=float), np.zeros(arm.nv), None
        self.readings, self.written, self.stops = -1, [], 0  # the first reading is not yet part of the motion
        self.time = 0.0

    def read(self):
        if self.tau is not None:
            self.q, self.v = self.method.step(self.plant, self.q, self.v, self.tau, self.dt)
        self.time = self.readings * self.dt
        self.readings += 1
        return self.q, self.v

    def write(self, tau):
        self.tau = tau
        self.written.append(tau)

    def stop(self):
        self.stops += 1


class UnclockedRobot:
    """The same without a clock: every reading is as it is now."""

    def __init__(self, arm, q, dt):
        self._robot = PlantRobot(arm, q, dt)
        self.written, self.read, self.write = self._robot.written, self._robot.read, self._robot.write
