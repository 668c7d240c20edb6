"""Two feet that walk along closed forms, in turn: exact truth for gaits that clinics see; see `foot_walk` for one."""

from collections.abc import Callable

import numpy as np
from numpy.polynomial import Polynomial

from estimators import rotation
from estimators.conventions import GRAVITY_MPS2
from estimators.gait import guided_test
from estimators.pipelines import SessionSetup, analyse_walk
from estimators.recording import Recording, SensorSignals

RATE_HZ, OVER = 100.0, 10
"""Readings are means of so many samples."""
_U = Polynomial([0.0, 1.0])
_FORWARD = 35 * _U**4 - 84 * _U**5 + 70 * _U**6 - 20 * _U**7
_BUMP = 64.0 * (_U * (1.0 - _U)) ** 3
SIDES = ("left", "right")
UP = np.array([0.0, 0.0, 1.0])


def bump(u, first, last):
    """Return 1 in the middle of a share of the swing, 0 outside of it, smooth."""
    return _BUMP(np.clip((u - first) / (last - first), 0.0, 1.0))


def path(
    lifts_s, lands_s, lengths_m, end_s, *, push_rad=0.8, land_rad=0.25, lift_m=0.05, aside_m=0.08, out_rad=0.1
):
    """Return time, place and turn of a sensor on a foot that makes these strides along x, at a fine rate."""
    time = np.arange(int(end_s * RATE_HZ) * OVER) / (RATE_HZ * OVER)
    along, up, pitch = np.zeros_like(time), np.zeros_like(time), np.zeros_like(time)
    for lift, land, length in zip(lifts_s, lands_s, lengths_m, strict=True):
        u = np.clip((time - lift) / (land - lift), 0.0, 1.0)
        along += length * _FORWARD(u)
        up += lift_m * bump(u, 0.1, 0.9)
        # Heel first off the ground, toes up before it lands.
        pitch += push_rad * bump(u, 0.0, 0.55) - land_rad * bump(u, 0.6, 1.0)
    place = np.stack([along, np.full_like(time, aside_m), up], axis=1)
    return time, place, turned(out_rad, pitch)


def turned(yaw_rad, pitch_rad):
    about_y = np.stack([np.zeros_like(pitch_rad), pitch_rad, np.zeros_like(pitch_rad)], axis=1)
    return rotation.multiply(rotation.about_z(np.full_like(pitch_rad, yaw_rad)), rotation.exp(about_y))


def readings(place_m, q, seed=0):
    """Return what a sensor with a little noise measures on the way."""
    step_s = 1.0 / (RATE_HZ * OVER)
    acceleration = np.zeros_like(place_m)
    acceleration[1:-1] = (place_m[2:] - 2 * place_m[1:-1] + place_m[:-2]) / step_s**2
    force = rotation.rotate(rotation.conjugate(q), acceleration + GRAVITY_MPS2 * UP)
    rate = rotation.log(rotation.multiply(rotation.conjugate(q[:-1]), q[1:])) / step_s
    rate = np.concatenate([rate, rate[-1:]])
    random = np.random.default_rng(seed)
    gyroscope, accelerometer = (one.reshape(-1, OVER, 3).mean(axis=1) for one in (rate, force))
    return SensorSignals(
        np.arange(len(gyroscope)) / RATE_HZ,
        gyroscope + 0.003 * random.normal(size=3) + 0.003 * random.normal(size=gyroscope.shape),
        accelerometer + 0.02 * random.normal(size=3) + 0.03 * random.normal(size=accelerometer.shape),
    )


def even_walk(
    count=7,
    stride_s=1.2,
    length_m=1.2,
    swing_s=0.5,
    stand_s=3.0,
    change: Callable[..., tuple] | None = None,
    seed=0,
    **style,
):
    """Return both feet of an even straight walk: `count` strides a foot, the right one first by half a length."""
    found = {}
    for number, side in enumerate(("right", "left")):
        lifts = stand_s + 0.5 * number * stride_s + stride_s * np.arange(count)
        lengths = np.full(count, length_m)
        lengths[0 if side == "right" else -1] *= 0.5
        end_s = stand_s + stride_s * (count + 0.5) + stand_s
        sign = 1.0 if side == "left" else -1.0
        place = {"aside_m": 0.08 * sign, "out_rad": 0.1 * sign} | style
        time, at, q = path(lifts, lifts + swing_s, lengths, end_s, **place)
        if change is not None:
            at, q = change(side, time, at, q)
        found[side] = readings(at, q, seed=2 * seed + number)
    return {side: found[side] for side in SIDES}


def analysed(feet, apart_m=None, kind="walk", recorded_s=None):
    """Return the walk and its test."""
    sensors = {f"foot_{side}": signals for side, signals in feet.items()}
    setup = SessionSetup("gait", tuple(sensors), RATE_HZ, feet_apart_m=apart_m)
    made = analyse_walk(Recording(sensors, RATE_HZ), setup, recorded_s)
    return made, guided_test(made.strides, kind)
