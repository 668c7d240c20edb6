"""`telemotion fuse`: a recording and a marker file in, the fused motion out, without a server."""

import csv
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import typer
from numpy.typing import NDArray

from app import readers
from app.commands.options.recordings import FuseOptions
from app.errors import InvalidInput
from app.ingest.marker_fusion import fuse_tracks, motion_of, report_of
from app.readers.markers.schemas import MarkerFileIn, MarkerReport
from app.readers.tables.schemas import CsvMapping
from app.recordings.marker_motion import csv_head, csv_lines
from estimators import signals
from estimators.optical import WITHHELD_M, OpticalFusion, OpticalResult, Provenance
from estimators.recording import Float, Recording, SampleQuality


def fuse(options: FuseOptions) -> None:
    """Fuse and write `motion.csv`, `filter.csv`, `lagged.csv`, `residuals.csv`, `gaps.csv` and `report.json`.

    Raises
    ------
    InvalidInput
        A word is unknown, a file cannot be read as declared, or markers and sensor do not show the same movement.
    """
    declared = MarkerFileIn.model_validate(
        {
            "format": "c3d" if options.markers.suffix.lower() == ".c3d" else "csv",
            "marker": options.marker or None,
            "cluster": tuple(options.cluster or ()),
            "up": options.up,
            "unit": options.unit,
            "rate_hz": options.marker_rate_hz,
            "delimiter": options.delimiter,
            "lever_arm_m": options.lever_arm_m,
            "largest_offset_s": options.largest_offset_s,
        }
    )
    mapping = CsvMapping.model_validate_json(options.mapping.read_text()) if options.mapping else None
    measured = readers.read(options.recording, options.format, mapping)
    sensor = _sensor(measured, options.sensor)
    tracks = readers.read_markers(options.markers, declared)
    gyroscope, accelerometer, bridged, step_s, start_s = _samples(measured, sensor, options.rate_hz)
    fusion, marker = fuse_tracks(tracks, declared, step_s, gyroscope, accelerometer, bridged, options.lag_s)
    report = report_of(fusion, marker, start_s)
    ticks = np.arange(len(fusion.residual_m), dtype=np.float64)
    time_s = start_s + (fusion.first_tick + ticks) * step_s
    options.out.mkdir(parents=True, exist_ok=True)
    results = {"motion": fusion.result, "filter": fusion.filtered, "lagged": fusion.lagged}
    for name, result in results.items():
        if result is None:
            continue
        _write_motion(options.out / f"{name}.csv", fusion, result, time_s)
    _write_residuals(options.out / "residuals.csv", fusion, time_s)
    _write_gaps(options.out / "gaps.csv", fusion, time_s)
    # The curves are there in full in the tables.
    text = report.model_dump_json(indent=2, exclude={"curves"})
    (options.out / "report.json").write_text(text + "\n", encoding="utf-8")
    _say(report, fusion, sensor, options.out)


def _sensor(measured: Recording, wanted: str) -> str:
    """Return the name of the sensor that wore the marker: named, or the only one."""
    names = measured.placements
    if wanted in names:
        return wanted
    if wanted:
        raise InvalidInput(
            f"the recording has no sensor {wanted}; it has {', '.join(names)}.", field="sensor"
        )
    if len(names) != 1:
        raise InvalidInput(
            f"the recording has {len(names)} sensors: say with --sensor which moved with the marker,"
            f" one of {', '.join(names)}."
        )
    return names[0]


def _samples(
    measured: Recording, sensor: str, rate_hz: float | None
) -> tuple[Float, Float, NDArray[np.bool_], float, float]:
    """Return gyroscope, accelerometer (NaN where all was lost) and which are bridged, the step, the first time."""
    found = measured.sensors[sensor]
    chunk = signals.to_common_ticks(
        replace(measured, sensors={sensor: found}), rate_hz or measured.nominal_rate_hz
    )
    sound = np.isfinite(found.gyroscope_radps).all(axis=1) & np.isfinite(found.accelerometer_mps2).all(axis=1)
    gap = ((chunk.quality[0] & SampleQuality.MISSING) != 0)[:, None]
    return (
        np.where(gap, np.nan, chunk.gyroscope_radps[0]),
        np.where(gap, np.nan, chunk.accelerometer_mps2[0]),
        (chunk.quality[0] & SampleQuality.BRIDGED) != 0,
        chunk.time_step_s,
        float(found.time_s[sound][0]),
    )


def _write_motion(path: Path, fusion: OpticalFusion, result: OpticalResult, time_s: Float) -> None:
    with path.open("w", encoding="utf-8") as file:
        file.write(csv_head())
        file.writelines(csv_lines(time_s, motion_of(fusion, result)))


def _write_residuals(path: Path, fusion: OpticalFusion, time_s: Float) -> None:
    """Write one row a frame of the cameras: what is left of it, and whether it was used."""
    ticks = np.flatnonzero(np.isfinite(fusion.marker_m).all(axis=1))
    camera_s = fusion.alignment.camera_time(
        (fusion.first_tick + ticks.astype(np.float64)) * fusion.time_step_s
    )
    head = (
        "time_s",
        "camera_time_s",
        "residual_x_m",
        "residual_y_m",
        "residual_z_m",
        "distance_m",
        "nis",
        "use",
    )
    rows = (
        (
            f"{time_s[k]:.5f}",
            f"{camera:.5f}",
            *(_text(x) for x in fusion.residual_m[k]),
            _text(float(np.linalg.norm(fusion.residual_m[k]))),
            _text(fusion.result.nis[k]),
            Provenance(int(fusion.result.provenance[k])).name.lower(),
        )
        for k, camera in zip(ticks.tolist(), np.atleast_1d(camera_s).tolist(), strict=True)
    )
    _write(path, head, rows)


def _write_gaps(path: Path, fusion: OpticalFusion, time_s: Float) -> None:
    head = ("start_s", "length_s", "sigma_m", "withheld")
    rows = (
        (f"{time_s[gap.start]:.5f}", f"{gap.length_s:.5f}", _text(gap.sigma_m), str(gap.withheld).lower())
        for gap in fusion.gaps
    )
    _write(path, head, rows)


def _write(path: Path, head: tuple[str, ...], rows: Iterable[tuple[Any, ...]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        writer.writerows(rows)


def _text(value: float) -> str:
    return f"{value:.7g}" if np.isfinite(value) else ""


def _say(report: MarkerReport, fusion: OpticalFusion, sensor: str, out: Path) -> None:
    rate_hz, count = 1.0 / fusion.time_step_s, len(fusion.residual_m)
    typer.echo(
        f"{report.marker} with {sensor}: {count} ticks, {count / rate_hz:.1f} s at {rate_hz:g} Hz -> {out}"
    )
    typer.echo(
        f"  clocks apart {1e3 * report.offset_s:.2f} +- {1e3 * report.offset_sigma_s:.2f} ms,"
        f" drift {report.drift_ppm:.0f} +- {report.drift_sigma_ppm:.0f} ppm; agreement {report.correlation:.3f}"
    )
    typer.echo(f"  marker from sensor {_millimetres(report.lever_arm_m)} mm")
    typer.echo(
        f"  residual {_millimetres(report.residual_rms_m, 2)} mm RMS; {report.used_count} of {report.frame_count}"
        f" frames used, {report.rejected_count} rejected"
    )
    longest = max((gap.length_s for gap in report.gaps), default=0.0)
    withheld = sum(gap.withheld for gap in fusion.gaps)
    typer.echo(f"  {report.gap_count} gaps, the longest {longest:.2f} s")
    if withheld:
        typer.echo(
            f"  {withheld} of them known to no better than {1e3 * WITHHELD_M:g} mm (two sigma): do not rely on them"
        )
    for check in report.checks:
        spline = "" if check.spline_m is None else f", by a spline {1e3 * check.spline_m:.1f} mm"
        typer.echo(f"  hidden for {check.length_s:g} s and filled: {1e3 * check.inertial_m:.1f} mm{spline}")
    for reason in report.reasons:
        typer.echo(f"  {reason}")


def _millimetres(values: list[float], digits: int = 1) -> str:
    return ", ".join(f"{1e3 * value:.{digits}f}" for value in values)
