"""Arms of real robots, and random postures and motions of them."""

from functools import cache

import numpy as np
import pinocchio as pin

from aspect_control import Arm
from aspect_control.arm.chain import is_prismatic
from aspect_control.arm.sources.examples import load_example_model

# One arm of every kind: fingers, a second arm, legs, mimic joints, continuous joints (nq != nv), a prismatic torso,
# wheels, a hand.
FRAMES = {
    "anymal_kinova": "j2s6s200_end_effector",
    "baxter": "left_gripper",
    "g1": "left_rubber_hand",
    "human": "left_hand",
    "icub": "r_gripper",
    "kinova": "j2s6s200_end_effector",
    "panda": "panda_hand_tcp",
    "planar3r": "tool",
    "pr2": "r_gripper_tool_frame",
    "romeo": "r_gripper",
    "talos": "gripper_left_joint",
    "talos_arm": "gripper_left_joint",
    "tiago": "hand_grasping_frame",
    "tiago_dual": "hand_left_grasping_frame",
    "ur5": "tool0",
    "xarm7": "link7",
    "z1": "gripperMover",
}


@cache
def example_arm(name, task="xyz"):
    return Arm.from_example(name, frame=FRAMES[name], task=task)


@cache
def whole_model(name):
    return load_example_model(name)


def random_posture(arm, rng):
    """A configuration with any angles; prismatic joints within 1 m."""
    reach = [1.0 if is_prismatic(arm.model, joint) else np.pi for joint in range(1, arm.model.njoints)]
    return arm.configuration(rng.uniform(-1.0, 1.0, arm.nv) * reach)


def random_postures(arm, count, seed):
    rng = np.random.default_rng(seed)
    return [random_posture(arm, rng) for _ in range(count)]


def random_motions(arm, count, seed):
    rng = np.random.default_rng(seed)
    return [(random_posture(arm, rng), rng.uniform(-2.0, 2.0, arm.nv)) for _ in range(count)]


def slopes(arm, function, q, step=1e-4):
    """∂f/∂q_k along the last axis, on the configuration manifold, by differences of fourth order in the step."""

    def along(shift):
        values = [function(arm.integrate(q, k * shift)) for k in (-2, -1, 1, 2)]
        return (values[0] - 8.0 * values[1] + 8.0 * values[2] - values[3]) / (12.0 * step)

    return np.stack([along(shift) for shift in step * np.eye(arm.nv)], axis=-1)


def serial_chain(joints):
    """A whole robot of revolute joints about alternating axes, with the frame `tip` at its end, without a URDF."""
    model, placement = pin.Model(), pin.SE3(np.eye(3), np.array([0.03, 0.01, 0.1]))
    model.name = f"chain of {joints}"
    turns = (pin.JointModelRZ(), pin.JointModelRY(), pin.JointModelRX())
    for i in range(joints):
        joint = model.addJoint(i, turns[i % 3], placement, f"joint{i + 1}")
        model.addJointFrame(joint)
        model.appendBodyToJoint(joint, pin.Inertia.FromSphere(1.0, 0.1), placement)
    model.addFrame(pin.Frame("tip", joints, 0, placement, pin.FrameType.OP_FRAME))
    return model


def planar_arm(lengths, limits):
    """An arm of parallel axes in the x-y plane: lengths of the links, m, and the range of each joint, rad."""
    model = pin.Model()
    model.name = "planar"
    for i, (before, (lower, upper)) in enumerate(zip([0.0, *lengths[:-1]], limits, strict=True)):
        placement = pin.SE3(np.eye(3), np.array([before, 0.0, 0.0]))
        bounds = [np.array([each]) for each in (100.0, 10.0, lower, upper)]
        joint = model.addJoint(i, pin.JointModelRZ(), placement, f"joint{i + 1}", *bounds)
        model.addJointFrame(joint)
        model.appendBodyToJoint(joint, pin.Inertia.FromSphere(1.0, 0.1), pin.SE3(np.eye(3), np.array([0.1, 0.0, 0.0])))
    tool = pin.SE3(np.eye(3), np.array([lengths[-1], 0.0, 0.0]))
    model.addFrame(pin.Frame("tool", len(lengths), 0, tool, pin.FrameType.OP_FRAME))
    return Arm.from_pinocchio(model, frame="tool", task="xy", gravity=(0.0, 0.0, 0.0))
