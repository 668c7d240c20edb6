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
