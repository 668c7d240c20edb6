"""A patient's evenings with sensors on the body, of which every repetition and every fault is known."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from playwright.sync_api import Page

from estimators.conventions import Placement
from estimators.simulation import ArmScenario, Mounting, PlannedRepetition, Schedule, simulate_arm
from tests.e2e.sensors.sensors_at_home import RATE_HZ

PLACEMENTS: Final[tuple[Placement, ...]] = ("sternum", "upper_arm_right", "forearm_right", "hand_right")
EXERCISE: Final = "flexion"
POSE_S: Final = 7.0
TRANSITION_S: Final = 1.5

SOUND: Final = PlannedRepetition()
LEANING: Final = PlannedRepetition(lean_rad=float(np.radians(17.0)))
SHORT: Final = PlannedRepetition(size=0.62)
SLOW: Final = PlannedRepetition(pace=0.45)
SHORT_AND_SLOW: Final = PlannedRepetition(size=0.62, pace=0.45)


@dataclass(frozen=True)
class Evening:
    """What is done, and what is true of it.

    Attributes
    ----------
    plan : tuple of PlannedRepetition
    samples : ndarray, shape (ticks, sensors, 6)
        Gyroscope, rad/s, then accelerometer, m/s^2.
    rests : tuple of (int, int)
        Samples that are felt over and over until the page has been pressed: in the pose, in the start posture, after
        the last repetition.
    repetitions_s : ndarray, shape (R, 2)
        Start and end of each, on the clock of the samples.
    lean_rad : ndarray, shape (ticks,)
        Of the trunk forward, from its start posture.
    """

    plan: tuple[PlannedRepetition, ...]
    samples: NDArray[np.float64]
    rests: tuple[tuple[int, int], ...]
    repetitions_s: NDArray[np.float64]
    lean_rad: NDArray[np.float64]


@cache
def evening(plan: tuple[PlannedRepetition, ...], seed: int = 3) -> Evening:
    """Let somebody without any impairment do what is planned."""
    made = simulate_arm(
        ArmScenario(
            exercise=EXERCISE,
            rate_hz=RATE_HZ,
            schedule=Schedule(
                n_pose_s=POSE_S,
                transition_s=TRANSITION_S,
                pause_s=1.2,
                repetitions=None,
                settle_s=2.0,
                plan=plan,
            ),
            placements=PLACEMENTS,
            # As in the picture: without a magnetometer no pose shows how far a sensor is turned about the limb.
            mounting=Mounting(misalignment_sd_rad=0.0),
            seed=seed,
        )
    )
    sensors = [made.recording.sensors[place] for place in PLACEMENTS]
    values = [np.concatenate([one.gyroscope_radps, one.accelerometer_mps2], axis=1) for one in sensors]
    samples = np.stack(values, axis=1)
    begins_s = POSE_S + TRANSITION_S
    rests = tuple(
        (round(RATE_HZ * start_s), round(RATE_HZ * end_s))
        for start_s, end_s in ((1.0, POSE_S - 1.0), (begins_s + 0.2, begins_s + 1.2))
    )
    rests = (*rests, (len(samples) - round(RATE_HZ), len(samples) - 1))
    close_loops(samples, made.truth.gyroscope_bias_radps, rests)
    lean = made.truth.angle_rad("trunk_lean_forward_rad")
    return Evening(
        plan,
        samples,
        rests,
        made.truth.repetitions_s,
        lean - lean[rests[1][0]],
    )


def close_loops(
    samples: NDArray[np.float64], bias_radps: NDArray[np.float64], rests: Sequence[tuple[int, int]]
) -> None:
    """Let each rest end, by its gyroscopes, as it began, in place.

    Who stands sways a little. Felt over and over, the sway of one second is a turn without an end, by half a degree a
    second, which no accelerometer shows about the vertical.

    Parameters
    ----------
    samples : ndarray, shape (ticks, sensors, 6)
    bias_radps : ndarray, shape (sensors, ticks, 3)
        What the gyroscopes measure of no rotation.
    rests : sequence of (int, int)
    """
    for start, end in rests:
        turned = samples[start:end, :, :3] - bias_radps[:, start:end].swapaxes(0, 1)
        samples[start:end, :, :3] -= turned.mean(axis=0)


def put_on(page: Page, what: Evening) -> None:
    """Press what the page offers until every sensor measures."""
    page.evaluate(
        "one => emulateDots({rateHz: 60, ...one})",
        {"samples": what.samples.round(6).tolist(), "rests": [list(rest) for rest in what.rests]},
    )
    page.get_by_role("button", name="Bluetooth sensors").click()
    for place in ("Chest", "Right upper arm", "Right forearm", "Right hand"):
        page.get_by_role("button", name=f"Connect: {place}").click()


def go_on(page: Page) -> int:
    """Leave the present rest; returns by how many ticks the emulation is behind the recording then."""
    until = int(page.evaluate("emulated.goOn()[1]"))
    wait_until_felt(page, until + 1)
    return int(page.evaluate("emulated.shift"))


def wait_until_felt(page: Page, sample: int) -> None:
    """Wait until the sensors have felt this sample, however busy the machine is."""
    page.wait_for_function("until => emulated.sample >= until", arg=sample)


def watch_lines(page: Page) -> None:
    """Note every cue that is shown, once within its 4 s: a page without a link may hide it for a moment."""
    page.evaluate(
        """() => {
            window.lines = [];
            let before = '', last = '', since = -Infinity;
            setInterval(() => {
                const now = document.querySelector('.doing-cue')?.textContent ?? '';
                const isAgain = now === last && performance.now() - since < 4000;
                if (now && now !== before && !isAgain) {
                    window.lines.push(now);
                    last = now;
                    since = performance.now();
                }
                before = now;
            }, 50);
        }"""
    )
