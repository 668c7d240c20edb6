"""Results of protocols as a text table and as JSON."""

import json
import math
from collections.abc import Sequence
from typing import Any

from estimators.recording import Float
from estimators.validation._protocol import FigureResult, Plot, ProtocolResult

_HEADINGS = ("figure", "unit", "published", "required", "median", "worst", "spread", "n", "")


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    if math.isnan(value):
        return "none"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _row(result: FigureResult) -> tuple[str, ...]:
    figure = result.figure
    sign = "<=" if figure.at_most else ">="
    required = "-" if figure.required is None else f"{sign} {_number(figure.required)}"
    verdict = "" if figure.required is None else "pass" if result.passed else "FAIL"
    return (
        figure.name,
        figure.unit,
        _number(figure.published),
        required,
        _number(result.median),
        _number(result.worst),
        "-" if math.isnan(result.spread) else _number(result.spread),
        str(len(result.values)),
        verdict,
    )


def to_table(results: Sequence[ProtocolResult]) -> str:
    """Return a plain text table: per protocol its figures, published and required beside ours."""
    lines: list[str] = []
    for result in results:
        rows = [_HEADINGS, *(_row(figure) for figure in result.figures)]
        widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADINGS))]
        verdict = "pass" if result.passed else "FAIL"
        lines.append(f"{result.protocol.title} [{result.name}]: {verdict}, {result.seconds:.1f} s")
        lines.append(f"  {result.protocol.source}")
        lines.append(f"  {result.protocol.what}")
        for row in rows:
            cells = [row[0].ljust(widths[0]), row[1].ljust(widths[1])]
            cells += [cell.rjust(width) for cell, width in zip(row[2:8], widths[2:8], strict=True)]
            lines.append("    " + "  ".join([*cells, row[8]]).rstrip())
        lines.append("")
    failed = [result.name for result in results if not result.passed]
    lines.append(f"{len(results) - len(failed)} of {len(results)} protocols pass")
    if failed:
        lines.append("short of what is required: " + ", ".join(failed))
    return "\n".join(lines)


def to_markdown(results: Sequence[ProtocolResult], command: str, data: Sequence[str] = ()) -> str:
    """Return a page: what was typed, one line a protocol with the figure nearest to its limit, then `to_table`.

    Parameters
    ----------
    results : sequence of ProtocolResult
    command : str
        As typed.
    data : sequence of str
        Names of the recordings that were given.
    """
    passed = sum(result.passed for result in results)
    lines = [
        "# Accuracy",
        "",
        f"Made by `{command}`. {passed} of {len(results)} experiments reach what is required in every figure.",
        *([f"FOLDER held {', '.join(data)}."] if data else []),
        "",
        "| experiment | n | verdict | nearest to its limit (or farthest past it) | required | ours |",
        "|---|---|---|---|---|---|",
    ]
    for result in results:
        nearest = max((found for found in result.figures if found.figure.required is not None), key=_share)
        sign = "≤" if nearest.figure.at_most else "≥"
        unit = "" if nearest.figure.unit == "1" else f" {nearest.figure.unit}"
        cells = (
            f"{result.protocol.title} (`{result.name}`)",
            str(result.seeds),
            "pass" if result.passed else "**short**",
            nearest.figure.name,
            f"{sign} {_number(nearest.figure.required)}{unit}",
            f"{_number(nearest.judged)}{unit}",
        )
        lines.append(f"| {' | '.join(cells)} |")
    lines += [
        "",
        "Below: what was published, what is required, ours as the median and the worst of n seeds or recordings, and",
        "the spread between them. Ours is judged by the worst, or where the experiment says so by the median. Figures",
        "without a requirement are shown for comparison. The seconds are of one core of a shared machine.",
        "",
        "```",
        to_table(results),
        "```",
    ]
    return "\n".join(lines) + "\n"


def _share(found: FigureResult) -> float:
    """Return how much of what its limit allows a figure uses up; infinite when nothing could be measured."""
    limit, judged = found.figure.required, found.judged
    if limit is None or math.isnan(judged):
        return math.inf
    used, allowed = (judged, limit) if found.figure.at_most else (limit, judged)
    return used / allowed if allowed > 0.0 else math.inf if used > allowed else 0.0


def _finite(value: float | None) -> float | None:
    """Round to six digits: finer than any limit, and a third of the file."""
    return None if value is None or not math.isfinite(value) else float(f"{value:.6g}")


def to_data(results: Sequence[ProtocolResult]) -> list[dict[str, Any]]:
    """Return the same as plain JSON types, with the plots; a number that could not be measured is None."""
    return [
        {
            "name": result.name,
            "title": result.protocol.title,
            "source": result.protocol.source,
            "what": result.protocol.what,
            "passed": result.passed,
            "seeds": result.seeds,
            "seconds": round(result.seconds, 2),
            "figures": [
                {
                    "name": found.figure.name,
                    "unit": found.figure.unit,
                    "published": found.figure.published,
                    "required": found.figure.required,
                    "at_most": found.figure.at_most,
                    "judged_by": found.figure.judged_by,
                    "median": _finite(found.median),
                    "worst": _finite(found.worst),
                    "spread": _finite(found.spread),
                    "values": [_finite(float(value)) for value in found.values],
                    "passed": found.passed,
                }
                for found in result.figures
            ],
            "plots": [_plot(plot) for plot in result.plots],
        }
        for result in results
    ]


def _plot(plot: Plot) -> dict[str, Any]:
    return {
        "title": plot.title,
        "x_label": plot.x_label,
        "x_unit": plot.x_unit,
        "y_label": plot.y_label,
        "y_unit": plot.y_unit,
        "logarithmic": plot.logarithmic,
        "curves": [
            {"name": curve.name, "x": _rounded(curve.x), "y": _rounded(curve.y)} for curve in plot.curves
        ],
    }


def _rounded(values: Float) -> list[float | None]:
    """Four digits: more than a chart shows."""
    return [_finite(float(f"{value:.4g}")) for value in values]


def to_json(results: Sequence[ProtocolResult]) -> str:
    """Return `to_data` as text."""
    return json.dumps(to_data(results), indent=2)
