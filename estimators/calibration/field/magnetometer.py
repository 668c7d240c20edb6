"""Hard and soft iron of one magnetometer while a person turns it: coverage, fit, what to do next."""

import math
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from estimators import rotation
from estimators.calibration._contract import UNUSABLE_SCORE
from estimators.calibration._device import TriadCalibration, matrix, vector
from estimators.calibration.field.ellipsoid import (
    UNKNOWN_SHAPE_SIGMA,
    EllipsoidFit,
    align_with_gravity,
    fit_ellipsoid,
    fit_sphere,
    mean_direction_sigma,
)
from estimators.calibration.field.local_field import LocalField, field_of, quiet_up
from estimators.calibration.plausibility.coverage import DIRECTIONS, next_turn, visited_directions
from estimators.errors import CalibrationError, ShapeError
from estimators.recording import Float
from estimators.sentences import say

IronMethod = Literal["ellipsoid", "sphere", "circle"]

_MOST_CELLS: Final = 900
_FIRST_SPACING: Final = 0.06
_FEWEST_CELLS: Final = 25
_ELLIPSOID_COVERAGE: Final = 0.4
_SPHERE_COVERAGE: Final = 0.15
_RESIDUAL_WARNING: Final = 0.03
_RESIDUAL_FAULT: Final = 0.12
_HEADING_WARNING_RAD: Final = math.radians(1.0)
_HEADING_FAULT_RAD: Final = math.radians(4.0)
_SPHERE_FAULT_RAD: Final = math.radians(10.0)
_ALIGNED_RAD: Final = math.radians(12.0)
_SAME_ATTITUDE: Final = math.cos(math.radians(6.0))
_KNOWN_SHAPE_SIGMA: Final = 0.005
_COMMON_DIP_RAD: Final = math.radians(67.0)


@dataclass(frozen=True)
class MagnetometerProgress:
    """What to show while the person turns the sensor.

    Attributes
    ----------
    coverage : float
        Share of the directions of the field, as the sensor sees it, that were visited, 0 to 1.
    directions, visited : ndarray, shape (B, 3) and bool (B,)
        Evenly spread unit vectors in sensor axes, and which were visited.
    residual : float
        Relative RMS of the norm after the fit of now; NaN while there is none.
    heading_sigma_rad : float
        What the uncertainty of the fit would make of the heading; NaN while there is none.
    is_complete : bool
        A full fit can be taken.
    hint : str
        What to do next.
    """

    coverage: float
    directions: Float
    visited: NDArray[np.bool_]
    residual: float
    heading_sigma_rad: float
    is_complete: bool
    hint: str


@dataclass(frozen=True)
class MagnetometerResult:
    """Hard and soft iron of one magnetometer.

    Attributes
    ----------
    calibration : TriadCalibration
        `gain` (soft iron, mean scale one) and `bias` (hard iron); the norm keeps its unit.
    method : {"ellipsoid", "sphere", "circle"}
        `sphere` and `circle` find the hard iron only.
    field : LocalField
        After the correction.
    residual : float
        Relative RMS of the norm after the correction.
    heading_sigma_rad : float
        Expected error of the heading by what the fit could not tell.
    misalignment_rad : float
        Turn of the magnetometer against the accelerometer that was found and corrected; NaN if it was not.
    """

    calibration: TriadCalibration
    method: IronMethod
    field: LocalField
    residual: float
    coverage: float
    heading_sigma_rad: float
    misalignment_rad: float
    score: float
    reasons: tuple[str, ...]


class MagnetometerCollector:
    """Collects what a magnetometer sees while it is turned, in bounded memory.

    Samples that lie close together are averaged into one cell, so that a direction held for long counts as
    much as one passed quickly. Feed it the raw readings: in any unit, before any normalisation (erratum to
    Marzouk 2009, A17), with the earlier `gain` not applied.
    """

    def __init__(self) -> None:
        self._sum = np.zeros((0, 3))
        self._up = np.zeros((0, 3))
        self._count = np.zeros(0)
        self._spacing = 0.0
        self._samples = 0

    @property
    def sample_count(self) -> int:
        """Finite samples taken so far."""
        return self._samples

    @property
    def cells(self) -> tuple[Float, Float]:
        """Mean reading and mean up direction (NaN where never quiet) of every cell, each (C, 3)."""
        norm = np.linalg.norm(self._up, axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            return self._sum / self._count[:, None], np.where(norm > 0.0, self._up / norm, np.nan)

    def add(self, field: Float, accelerometer_mps2: Float | None = None) -> None:
        """Take samples, shape (K, 3) each; NaN is skipped. The accelerometer serves dip and alignment."""
        field = np.asarray(field, dtype=np.float64)
        if field.ndim != 2 or field.shape[1] != 3:
            raise ShapeError(f"field has shape {field.shape}; it must be (K, 3)")
        up = np.zeros_like(field)
        if accelerometer_mps2 is not None:
            if accelerometer_mps2.shape != field.shape:
                raise ShapeError(
                    f"accelerometer has shape {accelerometer_mps2.shape}; it must be {field.shape}"
                )
            up = np.nan_to_num(quiet_up(accelerometer_mps2))
        for sample, direction in zip(field, up, strict=True):
            if np.isfinite(sample).all():
                self._put(sample, direction, 1.0)
                self._samples += 1

    def _put(self, sample: Float, up: Float, weight: float) -> None:
        if not len(self._count):
            self._spacing = max(_FIRST_SPACING * float(np.linalg.norm(sample)), 1e-30)
        else:
            away = np.linalg.norm(self._sum / self._count[:, None] - sample, axis=1)
            nearest = int(np.argmin(away))
            if away[nearest] < self._spacing:
                self._sum[nearest] += weight * sample
                # The same field is seen in many attitudes turned about it: a cell keeps the up of the first.
                held = self._up[nearest]
                if not held.any() or up @ held > _SAME_ATTITUDE * np.linalg.norm(held):
                    self._up[nearest] += weight * up
                self._count[nearest] += weight
                return
        self._sum = np.concatenate((self._sum, weight * sample[None]))
        self._up = np.concatenate((self._up, weight * up[None]))
        self._count = np.append(self._count, weight)
        if len(self._count) > _MOST_CELLS:
            self._coarsen()

    def _coarsen(self) -> None:
        """Fewer, larger cells: the sphere turned out to be large against the first sample."""
        sums, ups, counts = self._sum, self._up, self._count
        spacing = 1.5 * self._spacing
        self._sum, self._up, self._count = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
        for total, up, count in zip(sums, ups, counts, strict=True):
            mean = total / count
            if not len(self._count):
                self._spacing = spacing
                self._sum, self._up, self._count = total[None].copy(), up[None].copy(), np.array([count])
                continue
            self._put(mean, up / count, float(count))

    def progress(self) -> MagnetometerProgress:
        """Say how far the person has come; never raises."""
        directions = DIRECTIONS.copy()
        nothing = np.zeros(len(DIRECTIONS), dtype=np.bool_)
        unknown = float("nan")
        if len(self._count) < _FEWEST_CELLS:
            hint = say("compass.begin")
            return MagnetometerProgress(0.0, directions, nothing, unknown, unknown, False, hint)
        cells, _ = self.cells
        fit, _ = _fit(cells)
        visited = visited_directions(fit, cells, directions)
        coverage = float(visited.mean())
        sigma = mean_direction_sigma(fit) / math.cos(_COMMON_DIP_RAD)
        likely = min(1.0, _HEADING_WARNING_RAD / sigma) * min(
            1.0, _RESIDUAL_WARNING / max(fit.residual, 1e-9)
        )
        is_complete = coverage >= _ELLIPSOID_COVERAGE and likely >= UNUSABLE_SCORE
        return MagnetometerProgress(
            coverage,
            directions,
            visited,
            fit.residual,
            sigma,
            is_complete,
            next_turn(directions, visited, is_complete),
        )

    def result(self, norm: float | None = None, known: TriadCalibration | None = None) -> MagnetometerResult:
        """Fit what was collected.

        Parameters
        ----------
        norm : float, optional
            The known norm of the local field; by default the mean that the sensor itself reads.
        known : TriadCalibration, optional
            An earlier full result of this device: its soft iron stays, only the hard iron is found again.

        Returns
        -------
        MagnetometerResult
            `ellipsoid` from 40 percent of all directions on, `sphere` (hard iron only) below.

        Raises
        ------
        CalibrationError
            If too few directions were visited, the field is not uniform, or the score would be below 0.25; with what
            to do.
        """
        if len(self._count) < _FEWEST_CELLS:
            raise CalibrationError(say("compass.hardly_turned"))
        cells, ups = self.cells
        if known is not None:
            cells = cells @ np.array(known.gain).T
        fit, coverage = _fit(cells) if known is None else _fit_sphere(cells, _KNOWN_SHAPE_SIGMA)
        visited = visited_directions(fit, cells, DIRECTIONS)
        if coverage < _SPHERE_COVERAGE:
            hint = next_turn(DIRECTIONS, visited, False)
            raise CalibrationError(say("compass.few_directions", coverage=coverage, hint=hint))
        if fit.residual > _RESIDUAL_FAULT:
            raise CalibrationError(say("compass.not_uniform", residual=fit.residual))
        hint = next_turn(DIRECTIONS, visited, True)
        result = _finish(fit, cells, ups, coverage, norm, hint, is_shape_known=known is not None)
        return result if known is None else _with_earlier_shape(result, known)


def _fit(cells: Float) -> tuple[EllipsoidFit, float]:
    """Fit as much as the coverage allows."""
    sphere, coverage = _fit_sphere(cells)
    # Seen from a displaced centre the coverage is misjudged: try the full fit well below its limit.
    if coverage < 0.7 * _ELLIPSOID_COVERAGE:
        return sphere, coverage
    full = fit_ellipsoid(cells, sphere)
    seen = float(visited_directions(full, cells, DIRECTIONS).mean())
    return (full, seen) if full.is_full and seen >= _ELLIPSOID_COVERAGE else (sphere, coverage)


def _fit_sphere(cells: Float, shape_sigma: float = UNKNOWN_SHAPE_SIGMA) -> tuple[EllipsoidFit, float]:
    sphere = fit_sphere(cells, shape_sigma)
    return sphere, float(visited_directions(sphere, cells, DIRECTIONS).mean())


def _with_earlier_shape(result: MagnetometerResult, known: TriadCalibration) -> MagnetometerResult:
    """Bring the hard iron found behind the known soft iron back to raw readings."""
    gain, earlier = np.array(result.calibration.gain), np.array(known.gain)
    bias = np.linalg.solve(earlier, np.array(result.calibration.bias))
    return replace(result, calibration=TriadCalibration(matrix(gain @ earlier), vector(bias)))


def _finish(
    fit: EllipsoidFit,
    cells: Float,
    ups: Float,
    coverage: float,
    norm: float | None,
    hint: str,
    *,
    is_shape_known: bool,
) -> MagnetometerResult:
    shape, misalignment = fit.shape, float("nan")
    known = np.isfinite(ups).all(axis=1)
    true = fit.correct(cells)
    reasons = []
    score = 1.0
    if fit.is_full and known.sum() >= _FEWEST_CELLS:
        turn = align_with_gravity(true[known], ups[known])
        if turn is not None:
            misalignment = float(np.linalg.norm(turn))
            if misalignment > _ALIGNED_RAD:
                score *= 0.4
                reasons.append(say("compass.axes_turned", angle_rad=misalignment))
            shape = rotation.to_matrix(rotation.exp(turn)) @ shape
            true = (cells - fit.centre) @ shape.T
    radius = float(abs(np.linalg.det(fit.shape)) ** (-1.0 / 3.0))
    gain = (radius if norm is None else norm) * shape
    field = field_of((cells - fit.centre) @ gain.T, ups)
    dip = field.dip_rad if math.isfinite(field.dip_rad) else _COMMON_DIP_RAD
    sigma = mean_direction_sigma(fit) / max(math.cos(dip), 0.05)
    if sigma > (_HEADING_FAULT_RAD if fit.is_full else _SPHERE_FAULT_RAD):
        raise CalibrationError(say("compass.heading_unknown", sigma_rad=sigma, hint=hint))
    if sigma > _HEADING_WARNING_RAD:
        score *= _HEADING_WARNING_RAD / sigma
        reasons.append(say("compass.heading_uncertain", sigma_rad=sigma, hint=hint))
    if not fit.is_full and not is_shape_known:
        score *= 0.7
        reasons.append(say("compass.hard_iron_only", coverage=coverage, hint=hint))
    if fit.residual > _RESIDUAL_WARNING:
        score *= _RESIDUAL_WARNING / fit.residual
        reasons.append(say("compass.norm_varies", residual=fit.residual))
    if score < UNUSABLE_SCORE:
        raise CalibrationError(say("compass.unusable", reasons=reasons))
    return MagnetometerResult(
        TriadCalibration(matrix(gain), vector(fit.centre)),
        "ellipsoid" if fit.is_full else "sphere",
        field,
        fit.residual,
        coverage,
        sigma,
        misalignment,
        score,
        tuple(reasons),
    )
