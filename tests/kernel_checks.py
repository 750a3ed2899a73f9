"""What the kernels and the laws give at many states, in the mode of this process; run as a program, compiled.

`python kernel_checks.py FILE` calls `compile_kernels` and writes what `measured` returns to the file, an .npz.
"""

import inspect
import pkgutil
import sys
from importlib import import_module

import numpy as np

import aspect_control.redundancy
from aspect_control import Arm, Target, controllers
from aspect_control.redundancy import compile_kernels, kernels_compiled, minors, pseudoinverse
from aspect_control.redundancy.generalized_inverse import least_norm_solution
from aspect_control.redundancy.kernels import Kernel
from aspect_control.redundancy.laplace import laplace_expansion
from aspect_control.resources import model_path
from example_arms import example_arm
from oracles import literal

STATES = 10_000
COMPARED = 60
"""States at which the two modes are compared."""

START = np.array([0.3, 0.4, 0.2, -1.8, 0.1, 1.9, 0.5])
"""A posture of Panda off all borders."""

CLOSED_FORMS = [name for name in literal.LAWS if name != "jmdc"]
SMALLEST = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
"""Smallest singular values of matrices near the loss of rank; the others are 1 and 0.5."""

VARIANTS = {
    **{name: (name, {}) for name in controllers.available()},
    "dead-beat": ("modified-null-space-vector", {"switching": "dead-beat"}),
    "brake": ("modified-null-space-vector", {"switching": "brake"}),
    "jmdc, large kappa": ("jmdc", {"kappa": 0.1}),
    "joint range": ("resolved-motion", {"criterion": "joint-range", "kappa": 0.1}),
    "qp, limits": ("qp", {"torque_limit": 60.0}),
}


def kernels():
    """Every kernel of the mathematics, by name."""
    package = aspect_control.redundancy
    modules = [import_module(f"{package.__name__}.{each.name}") for each in pkgutil.iter_modules(package.__path__)]
    found = [each for module in modules for each in vars(module).values() if isinstance(each, Kernel)]
    return {each.__name__: each for each in found}


def random_states(arm, count, seed):
    """States at which J is no worse than what its literal equations can bear, with targets."""
    rng = np.random.default_rng(seed)
    m, found = arm.task_dim, 0
    while found < count:
        q, v = rng.uniform(-np.pi, np.pi, arm.nv), rng.normal(0.0, 1.0, arm.nv)
        target = Target(rng.normal(0.0, 0.5, m), rng.normal(size=m), rng.normal(size=m))
        if np.linalg.cond(arm.jacobian(q)) < 100.0:
            found += 1
            yield q, v, target


def relative(actual, expected):
    return np.linalg.norm(actual - expected) / np.linalg.norm(expected)


def calls_of(function):
    """Calls of Python and of C functions that a call makes: the same on every machine, unlike its time."""
    count = 0

    def seen(frame, event, argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(seen)
    try:
        function()
    finally:
        sys.setprofile(None)
    return count


def nearly_singular(smallest, seed):
    """A 3 × 7 matrix of singular values 1, 0.5 and the smallest, with its pseudoinverse."""
    rng = np.random.default_rng(seed)
    U, V = np.linalg.qr(rng.normal(size=(3, 3)))[0], np.linalg.qr(rng.normal(size=(7, 3)))[0]
    s = np.array([1.0, 0.5, smallest])
    return (U * s) @ V.T, (V / s) @ U.T


def examples(kernel, arm, count):
    """Arguments of a kernel by the names of its parameters, at states of an arm."""
    rng = np.random.default_rng(220)
    n, m = arm.nv, arm.task_dim
    # The gains and the error of a law in joint space have its shape.
    k = n if "v_d" in inspect.signature(kernel.text).parameters else m
    for q, v, target in random_states(arm, count, seed=221):
        s = arm.state(q, v)
        vectors = {name: rng.normal(size=n) for name in ("tau", "tau_0", "tau_tilde", "v_d", "v_d_before", "gradient")}
        known = {
            **vectors,
            **{"M": s.M, "nle": s.nle, "J": s.J, "A": s.J, "v": v, "drift": s.drift},
            **{"b": rng.normal(size=m), "dx": target.dx, "ddx": target.ddx, "error": rng.normal(size=k)},
            **{"kp": 100.0 * np.eye(k), "kv": 20.0 * np.eye(k), "damping": 10.0, "dt": 1e-3, "kappa": 0.1},
            **{"dJ": arm.jacobian_derivative(q), "slope": rng.normal(size=(m, n))},
            "terms": laplace_expansion(arm.minor_columns),
        }
        yield [known[name] for name in inspect.signature(kernel.text).parameters]


def measured():
    """Arrays by what they are."""
    panda, planar = example_arm("panda", "xyz"), _planar()
    made = {"is compiled": np.array(kernels_compiled())}
    made |= {f"kernel {name}": _flat(each, panda) for name, each in kernels().items()}
    made |= {f"torques {label}": _torques(label, panda) for label in VARIANTS}
    made |= {f"calls {label}": np.array(_calls(label, panda)) for label in VARIANTS}
    made |= {f"stretched {name}": _stretched(name, planar) for name in controllers.available()}
    share = STATES // len(literal.LAWS) + 1
    made |= {f"error {name}": _errors(name, panda, share) for name in literal.LAWS}
    made |= {f"near rank loss {smallest:g}": _near_rank_loss(smallest) for smallest in SMALLEST}
    made["lost"] = np.array([pseudoinverse(A) for A in lost_matrices()])
    made["lost, transposed"] = np.array([pseudoinverse(A.T.copy()) for A in lost_matrices()])
    made["of another type"] = pseudoinverse(np.asfortranarray([[1, 2, 0], [0, 2, 1]]))
    return made


def lost_matrices():
    return [nearly_singular(smallest, seed)[0] for seed in range(50) for smallest in (1e-14, 1e-17)]


def _planar():
    return Arm.from_urdf(model_path("planar3r.urdf"), frame="tool", task="xy", gravity=(0.0, 0.0, 0.0))


def _flat(kernel, arm):
    rows = []
    for arguments in examples(kernel, arm, COMPARED):
        result = kernel(*arguments)
        parts = result if isinstance(result, tuple) else (result,)
        rows.append(np.concatenate([np.ravel(part) for part in parts]))
    return np.array(rows)


def _law(label, arm):
    name, options = VARIANTS[label]
    law = controllers.create(name, arm, **options)
    law.reset(START, np.zeros(arm.nv), 1e-3)
    return law


def _torques(label, arm):
    law = _law(label, arm)
    return np.array([law.torque(*sample) for sample in random_states(arm, COMPARED, seed=222)])


def _calls(label, arm):
    law, (first, second) = _law(label, arm), random_states(arm, 2, seed=223)
    law.torque(*first)
    return calls_of(lambda: law.torque(*second))


def _stretched(name, arm):
    law = controllers.create(name, arm, **({"kappa": 0.0} if name in ("jmdc", "resolved-motion") else {}))
    law.reset(np.zeros(3), np.zeros(3), 1e-3)
    target = Target(arm.task_position(np.zeros(3)), np.zeros(2), np.ones(2))
    return np.array([law.torque(np.zeros(3), np.zeros(3), target) for _ in range(2)])


def _errors(name, arm, count):
    """Relative errors against the equations as printed, each pseudoinverse by `numpy.linalg.pinv`."""
    equations, errors = literal.LAWS[name][0], []
    law = controllers.create(name, arm, **({"kp": 0.0} if name == "jmdc" else {}))
    for q, v, target in random_states(arm, count, seed=200 + len(name)):
        if name == "jmdc":
            sizes = np.abs(minors(arm.jacobian(q), arm.minor_columns))
            if sizes.min() < 1e-4 * sizes.max():
                continue
            # What is commanded at one sample is followed at the next; without K_p as in the equations of a start.
            law.reset(q, v, literal.DT)
            law.torque(q, v, target)
        errors.append(relative(law.torque(q, v, target), equations(arm, arm.state(q, v), target)))
    return np.array(errors)


def _near_rank_loss(smallest):
    """Relative error of A⁺, and of A⁺b as a part of what its rounding may be."""
    rng, errors = np.random.default_rng(215), []
    for seed in range(50):
        A, A_pinv = nearly_singular(smallest, seed)
        b = rng.normal(size=3)
        of_solution = np.linalg.norm(least_norm_solution(A, b) - A_pinv @ b)
        bound = np.linalg.norm(A_pinv, 2) * np.linalg.norm(b)
        errors.append((relative(pseudoinverse(A), A_pinv), of_solution / bound))
    return np.array(errors)


def _compiled_in_ticks(arm):
    """How many functions Numba compiles while every law makes its ticks, and while one is asked to."""
    import numba
    from numba.core import event

    laws = [_law(label, arm) for label in VARIANTS]
    with event.install_recorder("numba:compile") as ticks:
        for law in laws:
            for sample in random_states(arm, 5, seed=224):
                law.torque(*sample)
    with event.install_recorder("numba:compile") as asked:
        numba.njit(lambda x: x + 1)(1)
    return np.array([len(ticks.buffer), len(asked.buffer)])


def _misfits(arm):
    """How kernels end that are given shapes that do not fit."""
    s, b = arm.state(np.full(arm.nv, 0.3), np.zeros(arm.nv)), np.ones(3)
    found = kernels()
    torque, least = found["pseudoinverse_torque"], found["minimum_torque"]
    misfits = (
        (torque, s.M, s.nle, s.J, np.ones(4)),
        (torque, s.M, s.nle[:6], s.J, b),
        (least, s.M[:6, :6].copy(), s.nle, s.J, b),
        (least, s.M, s.nle[:6], s.J, b),
    )
    return np.array([_ending(*each) for each in misfits])


def _ending(kernel, *arguments):
    try:
        kernel(*arguments)
    except Exception as error:
        return type(error).__name__
    return "none"


def everything():
    """What `measured` returns, and what has no counterpart in the other mode."""
    panda = example_arm("panda", "xyz")
    made = {**measured(), "misfits": _misfits(panda)}
    if kernels_compiled():
        made["compiled in ticks"] = _compiled_in_ticks(panda)
    return made


if __name__ == "__main__":
    compile_kernels()
    np.savez(sys.argv[1], **everything())
