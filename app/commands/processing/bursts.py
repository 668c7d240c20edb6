"""`telemotion process --pipeline magnetic_bursts`: a packet log with bursts of three coils in, poses as CSV out."""

import csv
import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import typer

from app import readers
from app.commands.options.recordings import ProcessOptions
from app.errors import InvalidInput
from estimators import rotation
from estimators.magnetic import Fix, TrackerFlag, TrackerFusionResult
from estimators.pipelines import (
    BURST_ORIENTATION,
    BURSTS,
    BurstAnalysis,
    SessionSetup,
    analyse_bursts,
    angles_with_sigma,
)
from estimators.recording import Float

_AXES = ("x", "y", "z")
_ANGLES = ("rotation", "flexion", "lateral")
_POSE = (
    *(f"{axis}_m" for axis in _AXES),
    "distance_m",
    *(f"{name}_deg" for name in _ANGLES),
    *(f"{axis}_sigma_m" for axis in _AXES),
    "distance_sigma_m",
    *(f"{name}_sigma_deg" for name in _ANGLES),
)


def process_bursts(recording: Path, options: ProcessOptions) -> None:
    """Estimate a recording and write, for each sensor, `NAME_bursts.csv`, `NAME_filter.csv`, `NAME_smoothed.csv`.

    Also `report.json` with the residuals. Positions are in the axes of the source; angles are z-y-x (rotation, flexion,
    lateral), sigmas those of the whole covariance, the coils' part included.

    Parameters
    ----------
    recording : Path
        A packet log: other formats have no coil states.
    options : ProcessOptions
        Without a rate: pulses are found on the recording's own ticks. `parameters` are those of source and filter;
        `orientation` smooths both modules' orientations.

    Raises
    ------
    InvalidInput
        For another format or rate, or parameters that are no object.
    """
    format, out = options.format, options.out
    if format != "auto" and not readers.reader_of(format).holds_packets:
        raise InvalidInput(f"bursts are in packet logs, which say what the coils do; {format} does not")
    if options.rate_hz is not None:
        raise InvalidInput("pulses are found on the recording's own ticks: leave --rate out")
    given = json.loads(options.parameters)
    if not isinstance(given, dict):
        raise InvalidInput("--parameters is a JSON object of names and values")
    chunk, log = readers.read_ticks(recording)
    worn = log.declaration
    orientation = options.orientation or BURST_ORIENTATION
    setup = SessionSetup(BURSTS, worn.placements, worn.rate_hz, orientation, given)
    found = analyse_bursts(chunk, setup)
    out.mkdir(parents=True, exist_ok=True)
    report = {}
    for one in found:
        _write_bursts(one, out / f"{one.sensor}_bursts.csv")
        for name, result in (("filter", one.filtered), ("smoothed", one.smoothed)):
            _write(one, result, out / f"{one.sensor}_{name}.csv")
        report[one.sensor] = summary(one)
        _say(one, report[one.sensor])
    content = {"source": found[0].source, "rate_hz": worn.rate_hz, "parameters": given, "sensors": report}
    (out / "report.json").write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    typer.echo(f"{chunk.tick_count} ticks, {chunk.tick_count * chunk.time_step_s:.1f} s -> {out}")


def summary(one: BurstAnalysis) -> dict[str, Any]:
    """Return how many bursts were used, and how far apart tracker, filter and smoother are (rms).

    `misfit`: chi-square of the pulses over its degrees of freedom; `surprise`: normalised innovation squared of the
    filter over its own. Both are about 1 where all is as it should be, and lower while the coils fit better than
    `gain_sigma` says.
    """
    used = [burst for burst in one.bursts if burst.used and burst.carried is not None]
    flags: Counter[str] = Counter()
    for burst in one.bursts:
        stated = burst.alone.flags if burst.carried is None else burst.carried.fix.flags
        flags.update(flag.name or "" for flag in TrackerFlag if flag and flag in stated)
    found: dict[str, Any] = {
        "bursts": len(one.bursts),
        "used": len(used),
        "flags": dict(flags),
        "valid_s": float(one.filtered.valid.sum() * (one.time_s[1] - one.time_s[0])),
    }
    if not used:
        return found
    ticks = np.array([burst.tick for burst in used])
    fixes = {
        "tracker_alone": [burst.alone for burst in used],
        "tracker_carried": [burst.carried.fix for burst in used if burst.carried is not None],
    }
    for name, poses in fixes.items():
        found[f"{name}_from_smoothed"] = _apart(
            np.stack([fix.position_m for fix in poses]),
            np.stack([fix.q_source_sensor for fix in poses]),
            one.smoothed.position_m[ticks],
            one.smoothed.q_source_sensor[ticks],
        )
    on = one.filtered.valid
    found["filter_from_smoothed"] = _apart(
        one.filtered.position_m[on],
        one.filtered.q_source_sensor[on],
        one.smoothed.position_m[on],
        one.smoothed.q_source_sensor[on],
    )
    found["misfit"] = float(np.mean([fix.chi_square for fix in fixes["tracker_carried"]]) / 3.0)
    surprise = one.filtered.nis[ticks]
    found["surprise"] = float(np.nanmean(surprise) / 6.0) if np.isfinite(surprise).any() else None
    found["gated"] = int(one.filtered.gated.sum())
    return found


def _apart(p: Float, q: Float, other: Float, q_other: Float) -> dict[str, float]:
    away = np.linalg.norm(p - other, axis=1)
    turn = rotation.angle_between(q, q_other)
    return {
        "position_mm": 1e3 * float(np.sqrt(np.mean(away**2))),
        "orientation_deg": float(np.degrees(np.sqrt(np.mean(turn**2)))),
    }


def _columns(position_m: Float, q: Float, covariance: Float) -> Float:
    """Return the columns of `_POSE`, shape (K, 14)."""
    distance = np.linalg.norm(position_m, axis=1)
    unit = position_m / np.where(distance > 0.0, distance, 1.0)[:, None]
    along = np.einsum("ki,kij,kj->k", unit, covariance[:, :3, :3], unit)
    angle, spread = angles_with_sigma(q, covariance[:, 3:, 3:])
    sigma = np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2)[:, :3], 0.0))
    return np.column_stack(
        [
            position_m,
            distance,
            np.degrees(angle),
            sigma,
            np.sqrt(np.maximum(along, 0.0)),
            np.degrees(spread),
        ]
    )


def _write(one: BurstAnalysis, result: TrackerFusionResult, path: Path) -> None:
    """Write a pose at every tick; empty before the first fix."""
    table = _columns(result.position_m, result.q_source_sensor, result.covariance + one.coil_covariance)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["time_s", *_POSE, "gated"])
        for time_s, row, valid, gated in zip(
            one.time_s.tolist(), table.round(6).tolist(), result.valid, result.gated, strict=True
        ):
            writer.writerow([round(time_s, 6), *(row if valid else [""] * len(row)), int(gated)])


def _write_bursts(one: BurstAnalysis, path: Path) -> None:
    """Write both fixes of every burst, and what the filter thought of it."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        names = [*(f"alone_{name}" for name in _POSE), *(f"carried_{name}" for name in _POSE)]
        writer.writerow(
            [
                "time_s",
                *names,
                "chi_square",
                "signal_to_noise",
                "filter_nis",
                "used",
                "alone_flags",
                "carried_flags",
            ]
        )
        for burst in one.bursts:
            carried = None if burst.carried is None else burst.carried.fix
            nis = float(one.filtered.nis[burst.tick])
            writer.writerow(
                [
                    round(float(one.time_s[burst.tick]), 6),
                    *_fix_row(burst.alone),
                    *_fix_row(carried),
                    "" if carried is None else round(carried.chi_square, 3),
                    round(burst.alone.signal_to_noise, 2),
                    round(nis, 3) if np.isfinite(nis) else "",
                    int(burst.used),
                    _words(burst.alone.flags),
                    "" if carried is None else _words(carried.flags),
                ]
            )


def _fix_row(fix: Fix | None) -> list[Any]:
    if fix is None or fix.flags & TrackerFlag.NO_SOLUTION:
        return [""] * len(_POSE)
    table = _columns(fix.position_m[None], fix.q_source_sensor[None], fix.covariance[None])
    return list(table[0].round(6).tolist())


def _words(flags: TrackerFlag) -> str:
    return " ".join((flag.name or "").lower() for flag in TrackerFlag if flag and flag in flags)


def _say(one: BurstAnalysis, found: dict[str, Any]) -> None:
    typer.echo(f"{one.sensor} against {one.source}: {found['used']} of {found['bursts']} bursts used")
    for name in ("tracker_alone", "tracker_carried", "filter"):
        apart = found.get(f"{name}_from_smoothed")
        if apart:
            typer.echo(
                f"  {name.replace('_', ' '):<16} {apart['position_mm']:7.1f} mm {apart['orientation_deg']:6.2f} deg"
                " from the smoothed pose (rms)"
            )
    for name, count in found["flags"].items():
        typer.echo(f"  {name.lower().replace('_', ' ')}: {count} bursts")
