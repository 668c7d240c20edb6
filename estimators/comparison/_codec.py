"""Templates and comparisons as bytes: versioned, exact, without pickle.

Layout: 4 bytes magic, u16 version, u32 length of the JSON header, then everything zlib-compressed: the
header (UTF-8 JSON) and the arrays it lists, little-endian float64, in order. Non-finite numbers live only
in arrays, so the header is strict JSON.
"""

import json
import struct
import zlib
from typing import Any, Literal

import numpy as np

from estimators.comparison._contract import (
    ComparisonResult,
    Measure,
    Repetition,
    RepetitionResult,
    Template,
)
from estimators.errors import ComparisonError
from estimators.recording import Float
from estimators.sentences import CATALOGUE, for_json, say

TEMPLATE_MAGIC = b"TMT1"
COMPARISON_MAGIC = b"TMC1"
VERSION = 1
_PREFIX = struct.Struct("<4sHI")
_MOST_BYTES = 256 * 2**20
_ARRAYS_OF_EACH = 6


def _pack(magic: bytes, header: dict[str, Any], arrays: list[Float]) -> bytes:
    header = {**header, "shapes": [list(array.shape) for array in arrays]}
    text = json.dumps(header, allow_nan=False, separators=(",", ":")).encode()
    body = text + b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)
    return _PREFIX.pack(magic, VERSION, len(text)) + zlib.compress(body, 6)


def _unpack(
    magic: bytes, data: bytes, what: Literal["template", "comparison"]
) -> tuple[dict[str, Any], list[Float]]:
    try:
        found, version, length = _PREFIX.unpack_from(data)
        if found != magic:
            raise ComparisonError(say("compare.not_stored", kind=what))
        if version != VERSION:
            raise ComparisonError(
                say("compare.other_version", kind=what, version=str(version), known=str(VERSION))
            )
        unzip = zlib.decompressobj()
        body = unzip.decompress(data[_PREFIX.size :], _MOST_BYTES)
        if not unzip.eof:
            raise ComparisonError(say("compare.cut_short", kind=what))
        header = json.loads(body[:length])
        arrays, offset = [], length
        for shape in header["shapes"]:
            count = int(np.prod(shape, dtype=np.int64))
            arrays.append(
                np.frombuffer(body, dtype="<f8", count=count, offset=offset).reshape(shape).astype(float)
            )
            offset += 8 * count
    except (struct.error, zlib.error, ValueError, KeyError, TypeError) as error:
        raise ComparisonError(say("compare.damaged", kind=what)) from error
    return header, arrays


def template_to_bytes(template: Template) -> bytes:
    """Store a template; `template_from_bytes` gives back an equal one."""
    names = list(template.measures)
    header = {
        "channels": template.channels,
        "repetition_count": template.repetition_count,
        "primary_channel": template.primary_channel,
        "side": template.side,
        "measures": names,
        "deviations": list(template.measure_sd),
    }
    numbers = np.array([template.duration_s, template.duration_sd_s, template.reach_m])
    arrays = [
        template.mean,
        template.tolerance,
        numbers,
        np.array([template.measures[name] for name in names]),
        np.array(list(template.measure_sd.values())),
    ]
    return _pack(TEMPLATE_MAGIC, header, arrays)


def template_from_bytes(data: bytes) -> Template:
    """Read a stored template.

    Raises
    ------
    ComparisonError
        If the bytes are something else, damaged, or of a newer format.
    """
    header, arrays = _unpack(TEMPLATE_MAGIC, data, "template")
    try:
        mean, tolerance, numbers, values, deviations = arrays
        return Template(
            channels=tuple(header["channels"]),
            mean=mean,
            tolerance=tolerance,
            duration_s=float(numbers[0]),
            duration_sd_s=float(numbers[1]),
            repetition_count=int(header["repetition_count"]),
            primary_channel=header["primary_channel"],
            side=header["side"],
            reach_m=float(numbers[2]),
            measures=dict(zip(header["measures"], values.tolist(), strict=True)),
            measure_sd=dict(zip(header["deviations"], deviations.tolist(), strict=True)),
        )
    except (ValueError, KeyError, TypeError) as error:
        raise ComparisonError(say("compare.damaged", kind="template")) from error


def _measure_header(measures: tuple[Measure, ...]) -> list[list[Any]]:
    return [[m.name, m.group, m.unit, m.count, *([for_json(m.note)] if m.note else [])] for m in measures]


def _measure_array(measures: tuple[Measure, ...]) -> Float:
    return np.array([[m.value, m.uncertainty] for m in measures]).reshape(-1, 2)


def _measures(header: list[list[Any]], values: Float) -> tuple[Measure, ...]:
    return tuple(
        Measure(
            name,
            group,
            float(value),
            unit,
            float(uncertainty),
            int(count),
            CATALOGUE.restored(note[0]) if note else "",
        )
        for (name, group, unit, count, *note), (value, uncertainty) in zip(header, values, strict=True)
    )


def comparison_to_bytes(result: ComparisonResult) -> bytes:
    """Store a comparison; `comparison_from_bytes` gives back an equal one."""
    header = {
        "channels": result.channels,
        "findings": for_json(list(result.findings)),
        "summary": _measure_header(result.summary),
        "arrays_of_each": _ARRAYS_OF_EACH,
        "repetitions": [
            {
                "number": r.repetition.number,
                "is_kept": r.repetition.is_kept,
                "reason": for_json(r.repetition.reason),
                "counted": r.repetition.counted,
                "measures": _measure_header(r.measures),
                "outside": r.outside,
            }
            for r in result.repetitions
        ],
    }
    arrays = [_measure_array(result.summary)]
    for r in result.repetitions:
        bounds = np.array([r.repetition.start_s, r.repetition.end_s])
        arrays += [bounds, _measure_array(r.measures), r.curves, r.aligned, r.warp_template_phase, r.sigma]
    return _pack(COMPARISON_MAGIC, header, arrays)


def comparison_from_bytes(data: bytes) -> ComparisonResult:
    """Read a stored comparison.

    Raises
    ------
    ComparisonError
        If the bytes are something else, damaged, or of a newer format.
    """
    header, arrays = _unpack(COMPARISON_MAGIC, data, "comparison")
    try:
        repetitions = []
        each = int(header.get("arrays_of_each", 5))  # formerly without `sigma`
        for place, stored in enumerate(header["repetitions"]):
            bounds, values, curves, aligned, warp, *sigma = arrays[1 + each * place : 1 + each * (place + 1)]
            repetitions.append(
                RepetitionResult(
                    repetition=Repetition(
                        int(stored["number"]),
                        float(bounds[0]),
                        float(bounds[1]),
                        stored["is_kept"],
                        CATALOGUE.restored(stored["reason"]),
                        stored.get("counted", ""),
                    ),
                    measures=_measures(stored["measures"], values),
                    curves=curves,
                    aligned=aligned,
                    sigma=sigma[0] if sigma else np.full_like(aligned, np.nan),
                    warp_template_phase=warp,
                    outside={name: [(a, b) for a, b in runs] for name, runs in stored["outside"].items()},
                )
            )
        return ComparisonResult(
            channels=tuple(header["channels"]),
            repetitions=tuple(repetitions),
            summary=_measures(header["summary"], arrays[0]),
            findings=tuple(CATALOGUE.restored(header["findings"])),
        )
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise ComparisonError(say("compare.damaged", kind="comparison")) from error
