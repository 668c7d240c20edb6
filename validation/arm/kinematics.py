"""V3 conversions and Jacobians, V8 the kinematic identity, V9 the elbow's position (Marzouk 2009)."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from estimators import rotation, signals
from estimators.arm.published import two_link_joint_angles, two_link_pose
from estimators.recording import Float
from published.marzouk._quaternion_kernel import pitch_row, roll_row, yaw_row
from validation.arm.thesis import (
    RATE_HZ,
    SCORED_AFTER_S,
    Module,
    calibrate_still,
    envelope,
    estimate,
    measure_module,
    raw_angles,
)
from validation.protocol import Data, Figure, Protocol, Values

UPPER_ARM_M, FOREARM_M, MODULE_M = 0.30, 0.25, 0.18


def _conversions(seeds: Sequence[int], data: Data) -> Values:
    matrix, quaternion, product, jacobian = [], [], [], []
    for seed in seeds:
        generator = np.random.default_rng([seed, 3])
        angles = generator.uniform(
            [-np.pi, -np.radians(89), -np.pi], [np.pi, np.radians(89), np.pi], (10_000, 3)
        )
        reference = Rotation.from_euler("ZYX", angles)
        q = rotation.from_scipy(reference)
        matrix.append(np.abs(rotation.to_matrix(q) - reference.as_matrix()).max())
        back = rotation.from_matrix(reference.as_matrix())
        quaternion.append(rotation.angle_between(back, q).max())
        both = rotation.multiply(q[::-1], q)
        product.append(rotation.angle_between(both, rotation.from_scipy(reference[::-1] * reference)).max())
        jacobian.append(max(_jacobian_error(one) for one in q[:300]))
    return {
        "matrix against scipy": np.array(matrix),
        "quaternion from a matrix": np.array(quaternion),
        "product against scipy": np.array(product),
        "measurement rows against differences": np.array(jacobian),
    }


def _jacobian_error(q: Float) -> float:
    """Relative error of the rows of A9.4 along directions tangent to the unit sphere."""
    worst, step = 0.0, 1e-6
    # The twisting directions q * (0, axis) span the tangent space.
    for axis in np.eye(3):
        tangent = rotation.multiply(q, np.array([0.0, *axis]))
        for angle_row in (roll_row, pitch_row, yaw_row):
            _, _, length, *derivative = angle_row(*q)
            row = np.array(derivative) / length
            ahead, behind = (
                np.arctan2(*angle_row(*rotation.normalize(q + sign * step * tangent))[:2]) for sign in (1, -1)
            )
            slope = np.remainder(ahead - behind + np.pi, 2 * np.pi) - np.pi
            worst = max(worst, abs(slope / (2 * step) - row @ tangent) / max(float(np.linalg.norm(row)), 1.0))
    return worst


CONVERSIONS = Protocol(
    name="arm_conversions",
    title="V3 Conversions and Jacobians",
    source="Marzouk 2009, (2.33) to (2.42), (3.34) to (3.39), errata E-6 to E-8, E-14, E-15; method page V3",
    what="10,000 random attitudes: quaternions and matrices against scipy, and the filter's measurement rows against "
    "central differences.",
    figures=(
        Figure("matrix against scipy", "1", 1e-12),
        Figure("quaternion from a matrix", "rad", 1e-7),
        Figure("product against scipy", "rad", 1e-7),
        Figure("measurement rows against differences", "1", 1e-7),
    ),
    measure=_conversions,
)


def _turn(axis: int, angle: Float) -> Float:
    """Homogeneous rotations about x (0) or z (2), shape (N, 4, 4)."""
    table = np.zeros((len(angle), 4, 4))
    table[:, 3, 3] = table[:, axis, axis] = 1.0
    i, j = (axis + 1) % 3, (axis + 2) % 3
    table[:, i, i] = table[:, j, j] = np.cos(angle)
    table[:, j, i], table[:, i, j] = np.sin(angle), -np.sin(angle)
    return table


def _denavit_hartenberg(joints: Float, lengths: Sequence[float], twists: Sequence[float]) -> Float:
    """Pose at the end of a chain without offsets along the joints (4.20), shape (N, 4, 4)."""
    pose = np.broadcast_to(np.eye(4), (len(joints), 4, 4))
    for joint, length, twist in zip(joints.T, lengths, twists, strict=True):
        along = np.broadcast_to(np.eye(4), pose.shape).copy()
        along[:, 0, 3] = length
        pose = pose @ _turn(2, joint) @ along @ _turn(0, np.full(len(joints), twist))
    return pose


def _screw_axes(joints: Float, lengths: Sequence[float], twists: Sequence[float]) -> tuple[Float, Float]:
    """Position and matrix by the thesis' dual-quaternion recursion in vector form ((4.27) to (4.37), E-21)."""
    count = len(joints)
    s, a = (np.broadcast_to(axis, (count, 3)).astype(float) for axis in ([0, 0, 1], [1, 0, 0]))
    p = np.zeros((count, 3))
    for joint, length, twist in zip(joints.T, lengths, twists, strict=True):
        a = a * np.cos(joint)[:, None] + np.cross(s, a) * np.sin(joint)[:, None]
        p = p + length * a
        s = s * np.cos(twist) + np.cross(a, s) * np.sin(twist)
    return p, np.stack([a, np.cross(s, a), s], axis=-1)


_QUARTER = np.pi / 2
_FIVE = (
    (0.0, 0.0, UPPER_ARM_M, 0.0, 0.0, FOREARM_M),
    (-_QUARTER, _QUARTER, -_QUARTER, _QUARTER, -_QUARTER, _QUARTER),
)
_SIX = (
    (0.0, 0.0, UPPER_ARM_M, 0.0, 0.0, FOREARM_M),
    (-_QUARTER, _QUARTER, -_QUARTER, -_QUARTER, _QUARTER, -_QUARTER),
)


def _identity(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}

    def add(name: str, error: Float) -> None:
        values.setdefault(name, []).append(float(np.abs(error).max()))

    for seed in seeds:
        generator = np.random.default_rng([seed, 8])
        q1, q2 = rotation.normalize(generator.normal(size=(2, 10_000, 4)))
        pose = two_link_pose(q1, q2, UPPER_ARM_M, FOREARM_M).T_shoulder_wrist
        shoulder = two_link_joint_angles(q1, q2)[0][:, :3]
        quarter = rotation.to_scipy(rotation.about_x(_QUARTER))
        relative = rotation.to_scipy(rotation.multiply(rotation.conjugate(q1), q2))
        elbow = (relative * quarter).as_euler("ZYZ")
        joints = np.concatenate([shoulder, elbow], axis=1)
        add("six joints, position", _denavit_hartenberg(joints, *_SIX)[:, :3, 3] - pose[:, :3, 3])
        p, axes = _screw_axes(joints, *_SIX)
        add("dual quaternions, position", p - pose[:, :3, 3])
        add("dual quaternions, orientation", axes - pose[:, :3, :3])
        # Without carrying angle the published chain of five joints is exact.
        flexion, turn = generator.uniform(-np.pi, np.pi, (2, 10_000))
        bent = rotation.multiply(rotation.about_z(flexion), rotation.about_x(turn))
        q2 = rotation.multiply(q1, bent)
        pose = two_link_pose(q1, q2, UPPER_ARM_M, FOREARM_M).T_shoulder_wrist
        angles, residual = two_link_joint_angles(q1, q2)
        add("five joints, carrying angle", residual)
        joints = np.concatenate([angles, np.full((len(angles), 1), -_QUARTER)], axis=1)
        chain = _denavit_hartenberg(joints, *_FIVE)
        add("five joints, position", chain[:, :3, 3] - pose[:, :3, 3])
        add("five joints, orientation", chain[:, :3, :3] - pose[:, :3, :3])
    return {name: np.array(found) for name, found in values.items()}


KINEMATIC_IDENTITY = Protocol(
    name="arm_kinematic_identity",
    title="V8 Three kinematics, one trajectory",
    source="Marzouk 2009, chapter 4 (P8), errata E-18 to E-21; method page V8",
    what="10,000 random postures: homogeneous transforms, Denavit-Hartenberg chains and dual quaternions must put "
    "the wrist in the same place.",
    figures=(
        Figure("six joints, position", "m", 1e-12),
        Figure("dual quaternions, position", "m", 1e-12),
        Figure("dual quaternions, orientation", "1", 1e-12),
        Figure("five joints, carrying angle", "rad", 1e-12),
        Figure("five joints, position", "m", 1e-12),
        Figure("five joints, orientation", "1", 1e-12),
    ),
    measure=_identity,
)


def _swing(column: int, amplitude_deg: float) -> Callable[[Float], tuple[Float, Float]]:
    """One angle swings at 0.2 Hz; the module rides on the upper arm."""

    def motion(time_s: Float) -> tuple[Float, Float]:
        angles = np.zeros((len(time_s), 3))
        angles[:, column] = (
            np.radians(amplitude_deg) * np.sin(0.4 * np.pi * (time_s - 10.0)) * envelope(time_s)
        )
        along = Rotation.from_euler("ZYX", angles).apply([MODULE_M, 0.0, 0.0])
        return angles, along

    return motion


_SWINGS = {"pitch": _swing(1, 45.0), "yaw": _swing(0, 60.0)}


def _elbow_m(attitude: Rotation) -> Float:
    q = rotation.from_scipy(attitude)
    return np.asarray(two_link_pose(q, q, UPPER_ARM_M, FOREARM_M).T_shoulder_elbow[:, :3, 3])


def _axis_error_cm(found: Rotation, module: Module) -> Float:
    """Mean absolute error of the elbow per axis, shape (3,)."""
    scored = module.time_s > SCORED_AFTER_S
    return np.asarray(100 * np.abs(_elbow_m(found) - _elbow_m(module.attitude))[scored].mean(axis=0))


def _elbow(seeds: Sequence[int], data: Data) -> Values:
    values: dict[str, list[float]] = {}
    for name, motion in _SWINGS.items():
        modules = [calibrate_still(measure_module(motion, 72.0, seed)) for seed in seeds]
        found, _ = estimate(modules, "marzouk_error_state_ekf")
        for module, attitude in zip(modules, found, strict=True):
            raw = Rotation.from_euler("ZYX", raw_angles(module.gravity_g, module.field))
            filtered, single = _axis_error_cm(attitude, module), _axis_error_cm(raw, module)
            values.setdefault(f"{name}, worst axis", []).append(float(filtered.max()))
            values.setdefault(f"{name}, worst axis, single samples", []).append(float(single.max()))
            large = single > 0.3
            gain = float((single[large] / filtered[large]).min()) if large.any() else np.nan
            values.setdefault(f"{name}, least improvement over single samples", []).append(gain)
        fast = [calibrate_still(measure_module(motion, 72.0, seed, rate_hz=17.1)) for seed in seeds]
        found, _ = estimate(fast, "marzouk_error_state_ekf")
        for module, attitude in zip(fast, found, strict=True):
            by_index, aligned = _skewed_cm(motion, module, attitude)
            values.setdefault(f"{name}, 17.1 Hz paired by index", []).append(by_index)
            values.setdefault(f"{name}, 17.1 Hz aligned in time", []).append(aligned)
    return {name: np.array(found) for name, found in values.items()}


def _skewed_cm(
    motion: Callable[[Float], tuple[Float, Float]], module: Module, found: Rotation
) -> tuple[float, float]:
    """Worst axis against a 17.0 Hz reference, paired by sample number and by time."""
    count = len(module.time_s)
    reference_s = np.arange(count) / RATE_HZ
    truth = _elbow_m(Rotation.from_euler("ZYX", motion(reference_s)[0]))
    estimated = _elbow_m(found)
    # Only what both know, after the start.
    scored = (reference_s > SCORED_AFTER_S) & (reference_s < module.time_s[-1])
    by_index = 100 * np.abs(estimated - truth)[scored].mean(axis=0).max()
    q = signals.interpolate_rotations(module.time_s, rotation.from_scipy(found), reference_s[scored])
    aligned = _elbow_m(rotation.to_scipy(q)) - truth[scored]
    return float(by_index), float(100 * np.abs(aligned).mean(axis=0).max())


ELBOW_POSITION = Protocol(
    name="arm_elbow_position",
    title="V9 Position of the elbow",
    source="Marzouk 2009, 4.5 and 5.4 (P5: about 5 cm, P6); method page V9",
    what="An upper arm of 0.30 m swings in pitch or yaw for a minute; mean absolute error of the elbow on the worst "
    "axis. At 17.1 Hz paired with 17.0 Hz by sample number, timing alone makes the published 5 cm.",
    figures=tuple(
        figure
        for name, skew_cm in (("pitch", 4.1), ("yaw", 5.2))
        for figure in (
            Figure(f"{name}, worst axis", "cm", 1.0, 5.0),
            Figure(f"{name}, worst axis, single samples", "cm"),
            Figure(f"{name}, least improvement over single samples", "times", 2.0, at_most=False),
            Figure(f"{name}, 17.1 Hz paired by index", "cm", 0.85 * skew_cm, 5.0, at_most=False),
            Figure(f"{name}, 17.1 Hz aligned in time", "cm", 1.0),
        )
    ),
    measure=_elbow,
)
