"""Every fault in the list is named from the first seconds; sound recordings, simulated and real, name none."""

import pickle
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from estimators import rotation, signals
from estimators.calibration import RecordingCheck, check_recording
from estimators.calibration.plausibility.pace import Moved, pace_of
from estimators.errors import ShapeError
from estimators.recording import ImuChunk, Recording, SampleQuality, SensorSignals
from estimators.simulation import ArmScenario, Schedule, simulate_arm
from validation.orientation.honesty_scenes import scene

DATA = Path(__file__).parents[2] / "data"
ARM = ("upper_arm_right", "forearm_right")
EXERCISES = ("reaching", "drinking", "abduction", "flexion", "pronation")


@cache
def simulated(exercise="drinking", seed=2, **changes) -> ImuChunk:
    """Two seconds of rest and a first repetition: ten seconds."""
    made = simulate_arm(
        ArmScenario(
            exercise=exercise,
            placements=ARM,
            schedule=Schedule(n_pose_s=2.0, settle_s=0.2, pause_s=0.3, repetitions=1),
            seed=seed,
            **changes,
        )
    )
    return signals.to_common_ticks(made.recording, 100.0).ticks(0, 1000)


@pytest.fixture(scope="module")
def sound() -> ImuChunk:
    return simulated()


def only(chunk: ImuChunk, **changes) -> ImuChunk:
    """Change the forearm's readings only: `name=function`."""
    fields = {}
    for name, function in changes.items():
        values = getattr(chunk, name).copy()
        values[1] = function(values[1])
        fields[name] = values
    return replace(chunk, **fields)


def codes(chunk: ImuChunk, **how) -> list[str]:
    found = check_recording(chunk, ARM, **how)
    assert all(finding.sensor == "forearm_right" for finding in found), found
    assert all(finding.message.parameters["where"] == ["forearm_right"] for finding in found)
    return [finding.code for finding in found]


def swap_xy(values):
    return values[:, [1, 0, 2]]


def quarter_turn(values):
    return np.column_stack((-values[:, 1], values[:, 0], values[:, 2]))


def z_down(values):
    return values * np.array([1.0, -1.0, -1.0])


def noise(values):
    return 1e-3 * np.random.default_rng(1).normal(size=values.shape)


FAULTS = {
    "degrees a second as rad/s": ({"gyroscope_radps": np.degrees}, ["gyroscope_unit"]),
    "converted to rad/s twice": ({"gyroscope_radps": np.radians}, ["gyroscope_unit"]),
    "g as m/s^2": ({"accelerometer_mps2": lambda v: v / 9.80665}, ["accelerometer_unit"]),
    "milli-g as m/s^2": ({"accelerometer_mps2": lambda v: v / 9.80665e-3}, ["accelerometer_unit"]),
    "counts as m/s^2": ({"accelerometer_mps2": lambda v: v / 9.80665 * 4096}, ["accelerometer_unit"]),
    "microtesla as tesla": ({"magnetometer_t": lambda v: v * 1e6}, ["magnetometer_unit"]),
    "gauss as tesla": ({"magnetometer_t": lambda v: v * 1e4}, ["magnetometer_unit"]),
    "normalised field": ({"magnetometer_t": lambda v: v / 49e-6}, ["magnetometer_unit"]),
    "magnetometer of zeros": ({"magnetometer_t": np.zeros_like}, ["magnetometer_dead"]),
    "stuck magnetometer": ({"magnetometer_t": lambda v: np.ones_like(v) * 3e-5}, ["magnetometer_dead"]),
    "gravity as north-east-down devices give it": ({"accelerometer_mps2": lambda v: -v}, ["gravity_reversed"]),
    "north-east-down accelerometer": ({"accelerometer_mps2": z_down}, ["accelerometer_axes"]),
    "north-east-down magnetometer": ({"magnetometer_t": z_down}, ["magnetometer_axes"]),
    "swapped magnetometer axes": ({"magnetometer_t": swap_xy}, ["magnetometer_axes"]),
    "swapped gyroscope axes": ({"gyroscope_radps": swap_xy}, ["gyroscope_axes"]),
    "gyroscope turned a quarter": ({"gyroscope_radps": quarter_turn}, ["gyroscope_axes"]),
    "left-handed gyroscope": ({"gyroscope_radps": lambda v: -v}, ["gyroscope_axes"]),
    "swapped accelerometer axes": ({"accelerometer_mps2": swap_xy}, ["accelerometer_axes"]),
    "clipped gyroscope": ({"gyroscope_radps": lambda v: np.clip(v, -1.2, 1.2)}, ["gyroscope_clipped"]),
    "silent gyroscope": ({"gyroscope_radps": noise}, ["gyroscope_dead"]),
    "dead gyroscope axis": ({"gyroscope_radps": lambda v: v * np.array([1.0, 0.0, 1.0])}, ["gyroscope_dead"]),
    "dead accelerometer": ({"accelerometer_mps2": lambda v: v[:1].repeat(len(v), axis=0)}, ["accelerometer_dead"]),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("seed", [2, 5])
def test_every_fault_is_named_on_its_sensor_and_no_other(fault, seed):
    changes, expected = FAULTS[fault]
    assert codes(only(simulated(seed=seed), **changes)) == expected


def test_messages_say_what_to_do(sound):
    (finding,) = check_recording(only(sound, gyroscope_radps=np.degrees), ARM)
    assert finding.message.code == "readings.gyroscope_in_degrees"
    assert finding.severity == "refuse"
    (finding,) = check_recording(only(sound, gyroscope_radps=swap_xy), ARM)
    assert finding.message.parameters["mapping"] == ["x → y", "y → x"]
    (finding,) = check_recording(only(sound, magnetometer_t=z_down), ARM)
    assert finding.message.parameters["mapping"] == ["y → -y", "z → -z"]
    # A fifth is no unit of its own: the device may be off.
    (finding,) = check_recording(only(sound, accelerometer_mps2=lambda v: 1.2 * v), ARM)
    assert (finding.code, finding.severity) == ("accelerometer_unit", "warning")
    assert finding.message.parameters["remedy"].code == "readings.force_off"
    (finding,) = check_recording(only(sound, gyroscope_radps=lambda v: np.clip(v, -1.2, 1.2)), ARM)
    assert finding.message.parameters["level_radps"] == pytest.approx(1.2)


def test_without_a_magnetometer_units_and_improper_axes_are_still_named(sound):
    six = replace(sound, magnetometer_t=None)
    assert codes(six) == []
    assert codes(only(six, gyroscope_radps=np.degrees)) == ["gyroscope_unit"]
    assert codes(only(six, gyroscope_radps=swap_xy)) == ["gyroscope_axes"]
    assert codes(only(six, gyroscope_radps=quarter_turn)) == ["gyroscope_or_accelerometer_axes"]
    assert codes(only(six, accelerometer_mps2=lambda v: v / 9.80665)) == ["accelerometer_unit"]


def swinging(offset_radps, mapping=None, seed=1) -> ImuChunk:
    """A limb that swings about one axis of its sensor without a rest, with an offset of the gyroscope."""
    generator = np.random.default_rng(seed)
    step_s, ticks = 0.01, 3600
    time_s = np.arange(ticks) * step_s
    angle = 1.2 * np.sin(1.5 * time_s)
    about = np.stack([np.cos(angle / 2), np.sin(angle / 2), 0 * angle, 0 * angle], axis=1)
    rate = np.column_stack([1.2 * 1.5 * np.cos(1.5 * time_s), np.zeros((ticks, 2))])
    readings = []
    for values, noise_of in (
        (rate + np.asarray(offset_radps), 0.005),
        (rotation.rotate(rotation.conjugate(about), np.array([0.0, 0.0, 9.81])), 0.03),
        (rotation.rotate(rotation.conjugate(about), np.array([2e-5, 0.0, -4.3e-5])), 2e-7),
    ):
        readings.append((values + generator.normal(0.0, noise_of, values.shape))[None])
    if mapping is not None:
        readings[0] = readings[0] @ np.asarray(mapping, float).T
    return ImuChunk(0, step_s, *readings, np.zeros((1, ticks), np.uint8))


@pytest.mark.parametrize("seed", range(4))
def test_an_offset_is_not_taken_for_axes_about_which_nothing_turned(seed):
    """Exchanging two axes that read an offset only may fit better by chance: the movement does not say."""
    offset = np.random.default_rng(seed).choice([-0.03, 0.03], 3)
    check = RecordingCheck(["upper_arm_left"])
    whole = swinging(offset, seed=seed)
    for first in range(0, whole.tick_count, 1200):
        check.add(whole.ticks(first, first + 1200))
    assert check.findings == ()
    # The axis about which it turns is known: taken for another one it is found.
    wrong = check_recording(swinging(offset, [[0, 1, 0], [1, 0, 0], [0, 0, 1]], seed), ["upper_arm_left"])
    assert any(one.code.endswith("_axes") for one in wrong)


def test_two_faults_at_once(sound):
    both = only(sound, gyroscope_radps=np.degrees, accelerometer_mps2=lambda v: v / 9.80665)
    assert sorted(codes(both)) == ["accelerometer_unit", "gyroscope_unit"]


def test_rest_alone_tells_units_but_claims_no_axes(sound):
    rest = sound.ticks(0, 190)
    assert codes(rest) == []
    assert codes(only(rest, accelerometer_mps2=lambda v: v / 9.80665)) == ["accelerometer_unit"]
    assert codes(only(rest, gyroscope_radps=swap_xy)) == []
    # Half a radian a second of bias is no bias.
    assert codes(only(rest, gyroscope_radps=lambda v: v + 0.5)) == ["gyroscope_unit"]


def test_dip_is_reversed_in_the_south(sound):
    southern = replace(sound, magnetometer_t=-sound.magnetometer_t)
    assert check_recording(southern, ARM, hemisphere="south") == ()
    assert check_recording(southern, ARM, hemisphere="unknown") == ()
    assert [f.code for f in check_recording(southern, ARM)] == ["gravity_reversed"] * 2


def test_marked_clipping_and_missing_data(sound):
    quality = sound.quality.copy()
    quality[1, 500] |= SampleQuality.SATURATED
    assert codes(replace(sound, quality=quality)) == ["gyroscope_clipped"]
    assert codes(only(sound, gyroscope_radps=lambda v: np.full_like(v, np.nan))) == ["no_data"]
    # A sensor without a magnetometer has NaN there, which is no fault.
    assert codes(only(sound, magnetometer_t=lambda v: np.full_like(v, np.nan))) == []
    with pytest.raises(ShapeError):
        check_recording(sound, ("one",))


def test_a_magnetometer_that_repeats_itself_in_movement_is_doubted(sound):
    turning = np.linalg.norm(sound.gyroscope_radps[1], axis=1)
    first = 600 + int(np.argmax(np.convolve(turning[600:], np.ones(300), "valid")))
    field = sound.magnetometer_t.copy()
    field[1, first : first + 300] = field[1, first - 1]
    found = check_recording(replace(sound, magnetometer_t=field), ARM)
    assert [(f.sensor, f.code, f.severity) for f in found] == [(ARM[1], "magnetometer_frozen", "warning")]
    assert 1.0 < found[0].value <= 3.0
    # A slow one holds its value between two samples.
    held = np.arange(sound.tick_count) // 5 * 5
    assert codes(replace(sound, magnetometer_t=sound.magnetometer_t[:, held])) == []


@pytest.mark.parametrize("exercise", EXERCISES)
@pytest.mark.parametrize("errors", ["nominal", "marzouk_2009"])
def test_sound_simulations_name_nothing(exercise, errors):
    assert check_recording(simulated(exercise, 0, errors=errors), ARM) == ()


@pytest.mark.slow
@pytest.mark.parametrize("exercise", EXERCISES)
@pytest.mark.parametrize("errors", ["nominal", "marzouk_2009"])
def test_more_sound_simulations_name_nothing(exercise, errors):
    for seed in range(1, 6):
        assert check_recording(simulated(exercise, seed, errors=errors), ARM) == ()


def test_sound_real_recordings_name_nothing():
    content = np.load(DATA / "qmt" / "arms_25s.npz")
    names = [k.removesuffix("_gyroscope_radps") for k in content.files if k.endswith("_gyroscope_radps")]
    sensors = {
        name: SensorSignals(
            content["time_s"],
            content[f"{name}_gyroscope_radps"].astype(float),
            content[f"{name}_accelerometer_mps2"].astype(float),
        )
        for name in names
    }
    chunk = signals.to_common_ticks(Recording(sensors, 100.0), 100.0)
    for start in range(0, 2500, 500):
        assert check_recording(chunk.ticks(start, start + 1000), names) == ()
    content = np.load(DATA / "broad" / "fast_combined_15s.npz")
    rate = float(content["sampling_rate_hz"])
    time_s = np.arange(len(content["movement"])) / rate
    field_t = content["magnetometer_ut"] * 1e-6
    single = SensorSignals(time_s, content["gyroscope_radps"], content["accelerometer_mps2"], field_t)
    chunk = signals.to_common_ticks(Recording({"box": single}, rate), rate)
    assert check_recording(chunk, ["box"]) == ()
    assert check_recording(chunk.ticks(1400, 4286), ["box"]) == ()


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        (lambda c: replace(c, gyroscope_radps=np.degrees(c.gyroscope_radps)), "gyroscope_unit"),
        (lambda c: replace(c, gyroscope_radps=c.gyroscope_radps[..., [0, 2, 1]]), "gyroscope_axes"),
        (lambda c: replace(c, magnetometer_t=c.magnetometer_t * np.array([1, -1, -1])), "magnetometer_axes"),
        (lambda c: replace(c, accelerometer_mps2=-c.accelerometer_mps2), "gravity_reversed"),
        (lambda c: replace(c, accelerometer_mps2=c.accelerometer_mps2 / 9.80665), "accelerometer_unit"),
    ],
)
def test_faults_in_a_real_recording_are_named(fault, expected):
    content = np.load(DATA / "broad" / "fast_combined_15s.npz")
    rate = float(content["sampling_rate_hz"])
    time_s = np.arange(len(content["movement"])) / rate
    field_t = content["magnetometer_ut"] * 1e-6
    single = SensorSignals(time_s, content["gyroscope_radps"], content["accelerometer_mps2"], field_t)
    chunk = signals.to_common_ticks(Recording({"box": single}, rate), rate)
    assert [f.code for f in check_recording(fault(chunk), ["box"])] == [expected]


def test_a_pace_is_named_only_by_several_windows():
    """Where samples are lost without a word, some pace explains the two or three windows that hold the jump."""
    schedule = Schedule(n_pose_s=2.0, settle_s=0.2, pause_s=0.3, repetitions=3)
    made = simulate_arm(ArmScenario(exercise="drinking", placements=ARM, schedule=schedule, seed=2))
    slow = only(signals.to_common_ticks(made.recording, 100.0), gyroscope_radps=lambda rate: 0.5 * rate)
    live, named = RecordingCheck(ARM), []
    for first, stop in ((0, 800), (800, 1600)):
        live.add(slow.ticks(first, stop))
        named.append([one.code for one in live.findings if one.severity == "refuse"])
    assert named == [[], ["gyroscope_unit"]]
    assert codes(slow.ticks(0, 800)) == ["unexplained"]
    assert codes(slow.ticks(0, 1600)) == ["gyroscope_unit"]


def test_infinite_samples_are_missing_samples(sound):
    def lost(value):
        def change(values):
            values[[301, 302, 760], 1] = value
            values[303] = -value
            return values

        changes = dict.fromkeys(("gyroscope_radps", "accelerometer_mps2", "magnetometer_t"), change)
        return only(sound, **changes)

    infinite = lost(np.inf)
    assert codes(infinite) == codes(lost(np.nan)) == []
    assert codes(only(infinite, gyroscope_radps=lambda rate: np.degrees(rate))) == ["gyroscope_unit"]


def test_a_gyroscope_57_times_too_small_does_not_hide_its_own_movement():
    content = np.load(DATA / "broad" / "fast_combined_15s.npz")
    rate = float(content["sampling_rate_hz"])
    time_s = np.arange(len(content["movement"])) / rate
    slow = content["gyroscope_radps"] / 57.29578
    single = SensorSignals(time_s, slow, content["accelerometer_mps2"], content["magnetometer_ut"] * 1e-6)
    chunk = signals.to_common_ticks(Recording({"box": single}, rate), rate)
    (finding,) = check_recording(chunk, ["box"])
    assert (finding.code, finding.severity) == ("gyroscope_unit", "refuse")
    assert finding.message.code == "readings.gyroscope_twice"


def test_a_magnet_on_the_sensor_reverses_nothing():
    """A hard iron twice the field's size: at rest the field seems to point up, over movement it does not."""
    content = np.load(DATA / "broad" / "fast_combined_15s.npz")
    rate = float(content["sampling_rate_hz"])
    time_s = np.arange(len(content["movement"])) / rate
    magnet_t = np.array([0.0, 0.0, 5e-5])
    single = SensorSignals(
        time_s,
        content["gyroscope_radps"],
        content["accelerometer_mps2"],
        content["magnetometer_ut"] * 1e-6 + magnet_t,
    )
    chunk = signals.to_common_ticks(Recording({"box": single}, rate), rate)
    assert not [f for f in check_recording(chunk, ["box"]) if f.severity == "refuse"]
    field = chunk.magnetometer_t - magnet_t
    reversed_ = replace(
        chunk, accelerometer_mps2=-chunk.accelerometer_mps2, magnetometer_t=field + 0.2 * magnet_t
    )
    refused = [f.code for f in check_recording(reversed_, ["box"]) if f.severity == "refuse"]
    assert refused == ["gravity_reversed"]


def busiest(chunk: ImuChunk, sensor: int, length: int, earliest: int) -> int:
    """Return where the sensor turns most for `length` ticks."""
    turning = np.linalg.norm(chunk.gyroscope_radps[sensor, earliest:], axis=1)
    return earliest + int(np.argmax(np.convolve(turning, np.ones(length), "valid")))


def with_freezes(chunk: ImuChunk, sensor: int, *spans: tuple[int, int]) -> ImuChunk:
    field = chunk.magnetometer_t.copy()
    for first, stop in spans:
        field[sensor, first:stop] = field[sensor, first - 1]
    return replace(chunk, magnetometer_t=field)


def test_forgetting_one_sensor_leaves_the_others_what_is_known_of_them(sound):
    first = busiest(sound, 1, 300, 600)
    frozen = with_freezes(sound, 1, (first, first + 300))

    def found(forgotten: str | None) -> list[tuple[str, str]]:
        check = RecordingCheck(ARM)
        check.add(frozen.ticks(0, first + 20))
        if forgotten:
            check.forget(forgotten)
        check.add(frozen.ticks(first + 20, first + 300))
        return [(finding.sensor, finding.code) for finding in check.findings]

    assert found(None) == found(ARM[0]) == [(ARM[1], "magnetometer_frozen")]
    assert found(ARM[1]) == [(ARM[1], "magnetometer_dead")], "all that its successor ever gave"


def test_an_interrupted_check_is_small_and_goes_on_like_one_that_was_not(sound):
    first, second = sound.ticks(0, 500), sound.ticks(900, 1400)
    whole, interrupted = RecordingCheck(ARM), RecordingCheck(ARM)
    for check in (whole, interrupted):
        check.add(first)
    before = len(pickle.dumps(interrupted))
    interrupted.interrupt()
    # Of each sensor four seconds of three triads, until the movement has said enough.
    assert len(pickle.dumps(interrupted)) < 0.65 * before
    for check in (whole, interrupted):
        check.add(second)
    assert pickle.dumps(interrupted) == pickle.dumps(whole)


def test_what_is_known_of_a_session_of_hours_takes_no_more_room_than_of_twenty_minutes(sound):
    """Live sessions are looked at every twelve seconds, and each hands what it knows to another process."""
    check, stretch, sizes = RecordingCheck(ARM), sound.ticks(300, 500), []
    rng = np.random.default_rng(4)
    for number in range(480):
        # Peaks of the same size would look like the end of the range and are held for it, up to a bound.
        rate = stretch.gyroscope_radps * rng.uniform(0.8, 1.0)
        check.add(replace(stretch, gyroscope_radps=rate, first_tick=number * stretch.tick_count))
        if number in (99, 479):
            sizes.append(len(pickle.dumps(check)))
    assert sizes[1] - sizes[0] < 8e3, "over a hundred kilobytes while each stretch left its numbers in lists"


def test_a_freeze_lasts_as_long_as_the_longest_not_as_all_of_them(sound):
    first = busiest(sound, 1, 300, 600)
    (whole,) = check_recording(with_freezes(sound, 1, (first, first + 300)), ARM)
    assert whole.message.parameters["lasts_s"] == whole.value
    parts = RecordingCheck(ARM)
    for start, stop in ((0, first + 200), (first + 200, sound.tick_count)):
        parts.add(with_freezes(sound, 1, (first, first + 300)).ticks(start, stop))
    assert [finding.value for finding in parts.findings] == [pytest.approx(whole.value)]
    # Twice for more than half of that: no stretch of a second, though more than a second in all.
    short = round(100 * (3.0 - whole.value)) + 70
    twice = with_freezes(sound, 1, (first, first + short), (first + 300 - short, first + 300))
    assert codes(twice) == []


def test_a_magnetometer_that_never_changed_is_dead_and_nothing_else(sound):
    """Gaps must not count as changes that it once had."""
    quality = sound.quality.copy()
    quality[1, 300:800:5] |= np.uint8(SampleQuality.MISSING)
    still = only(replace(sound, quality=quality), magnetometer_t=lambda v: np.broadcast_to(v[0], v.shape))
    assert codes(still) == ["magnetometer_dead"]


def test_a_mark_of_clipping_counts_for_the_triad_that_has_a_level():
    swings, _ = scene("arm swings", [4])
    level_mps2 = 25.0
    is_cut = (np.abs(swings.accelerometer_mps2) >= level_mps2).any(axis=2)
    marked = np.where(is_cut, SampleQuality.SATURATED, 0).astype(np.uint8)
    cut = np.clip(swings.accelerometer_mps2, -level_mps2, level_mps2)
    chunk = replace(swings, accelerometer_mps2=cut, quality=swings.quality | marked)
    assert [f.code for f in check_recording(chunk, ["arm"])] == ["accelerometer_clipped"]
    # Without a level of either, the mark must be the gyroscope's: an accelerometer is seen to be cut off.
    free = replace(swings, quality=swings.quality | marked)
    assert [f.code for f in check_recording(free, ["arm"])] == ["gyroscope_clipped"]


@pytest.mark.parametrize(("turns_as_far", "expected"), [(0.0, 1.0), (1.0, 1.0), (2.0, 2.0)])
def test_no_pace_is_named_that_only_leaves_the_gyroscope_out(turns_as_far, expected):
    rate = np.zeros((3, 120, 3))
    rate[:, :, 0] = 1.0
    angle = turns_as_far * (np.arange(120) + 0.5) * 0.05
    up = np.stack([np.zeros(120), np.sin(angle), np.cos(angle)], axis=1)
    gravity = Moved(rate, np.tile(up, (3, 1, 1)))
    nothing = Moved(np.zeros((0, 120, 3)), np.zeros((0, 120, 3)))
    assert pace_of(gravity, nothing, 0.05, np.array([1e3, 0.0])) == pytest.approx(expected, rel=0.02)
