"""Results of protocols as a text table and as JSON."""

import json
import math
from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

from estimators.recording import Float
from validation.judgement import Verdict
from validation.protocol import FigureResult, Plot, ProtocolResult

_HEADINGS = (
    "figure",
    "unit",
    "published",
    "required",
    "judged",
    "interval",
    "median",
    "worst",
    "spread",
    "n",
    "",
)
_WORDS: Final[dict[Verdict, str]] = {"pass": "pass", "open": "open", "short": "SHORT"}


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    if not math.isfinite(value):
        return "none"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _row(result: FigureResult) -> tuple[str, ...]:
    figure = result.figure
    sign = "<=" if figure.at_most else ">="
    required = "-" if figure.required is None else f"{sign} {_number(figure.required)}"
    is_judged = figure.required is not None
    has_estimate = is_judged or figure.judged_by == "mean"
    return (
        figure.name,
        figure.unit,
        _number(figure.published),
        required,
        _number(result.judged.value) if has_estimate else "-",
        _interval(result) if has_estimate else "-",
        _number(result.median),
        _number(result.worst),
        "-" if math.isnan(result.spread) else _number(result.spread),
        str(len(result.values)),
        _WORDS[result.verdict] if is_judged else "",
    )


def _interval(result: FigureResult) -> str:
    low, high = result.judged.low, result.judged.high
    return "-" if result.each == "recording" else f"{_number(low)} to {_number(high)}"


def to_table(results: Sequence[ProtocolResult]) -> str:
    """Return a plain text table: per protocol its figures, published and required beside ours."""
    lines: list[str] = []
    for result in results:
        rows = [_HEADINGS, *(_row(figure) for figure in result.figures)]
        widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADINGS))]
        lines.append(
            f"{result.protocol.title} [{result.name}]: {_WORDS[result.verdict]}, {result.seconds:.1f} s"
        )
        lines.append(f"  {result.protocol.source}")
        lines.append(f"  {result.protocol.what}")
        for row in rows:
            cells = [row[0].ljust(widths[0]), row[1].ljust(widths[1])]
            cells += [cell.rjust(width) for cell, width in zip(row[2:10], widths[2:10], strict=True)]
            lines.append("    " + "  ".join([*cells, row[10]]).rstrip())
        lines.append("")
    lines.append(f"{sum(result.verdict == 'pass' for result in results)} of {len(results)} protocols pass")
    for verdict, words in (
        ("open", "not decided by these seeds, the limit lies within the interval"),
        ("short", "short of what is required"),
    ):
        if found := [result.name for result in results if result.verdict == verdict]:
            lines.append(f"{words}: {', '.join(found)}")
    return "\n".join(lines)


def to_markdown(results: Sequence[ProtocolResult], command: str, data: Sequence[str] = ()) -> str:
    """Return a page: what was typed, one line a protocol with the figure nearest to its limit, then `to_table`.

    Parameters
    ----------
    command : str
        As typed.
    data : sequence of str
        Names of the recordings that were given.
    """
    judged = [
        result for result in results if any(found.figure.required is not None for found in result.figures)
    ]
    passed = sum(result.verdict == "pass" for result in judged)
    undecided = sum(result.verdict == "open" for result in judged)
    lines = [
        "# Accuracy",
        "",
        f"Made by `{command}`. {passed} of {len(judged)} experiments reach what is required in every figure, "
        f"{undecided} are open, {len(judged) - passed - undecided} fall short.",
        *([f"FOLDER held {', '.join(data)}."] if data else []),
        *_other_seeds(results),
        "",
        "| experiment | n | verdict | nearest to its limit (or farthest past it) | required | ours |",
        "|---|---|---|---|---|---|",
    ]
    for result in judged:
        nearest = max((found for found in result.figures if found.figure.required is not None), key=_share)
        sign = "≤" if nearest.figure.at_most else "≥"
        unit = "" if nearest.figure.unit == "1" else f" {nearest.figure.unit}"
        cells = (
            f"{result.protocol.title} (`{result.name}`)",
            str(result.seeds),
            {"pass": "pass", "open": "open", "short": "**short**"}[result.verdict],
            nearest.figure.name,
            f"{sign} {_number(nearest.figure.required)}{unit}",
            f"{_number(nearest.judged.value)}{unit}"
            + ("" if nearest.each == "recording" else f" ({_interval(nearest)})"),
        )
        lines.append(f"| {' | '.join(cells)} |")
    lines += [
        "",
        "Unless the command names them, the seeds are drawn from the version. Of a figure with one value a seed,",
        "what nine seeds in ten reach is judged, or where the experiment says so their median; of a figure pooled over",
        "a batch of seeds, the mean of the batches; of recordings, the worst or the median one. The interval has",
        "95 % confidence. A figure passes when its whole interval meets the limit, is open when the limit lies within",
        "the interval, and is short when the interval lies beyond. The worst is shown and not judged alone. Figures",
        "without a requirement are shown for comparison, as are experiments that have none. The seconds are of one",
        "core of a shared machine.",
        "",
        "```",
        to_table(results),
        "```",
    ]
    return "\n".join(lines) + "\n"


def _other_seeds(results: Sequence[ProtocolResult]) -> list[str]:
    """Name what was measured with other seeds than most."""
    drawn = Counter((result.first_seed, result.seeds) for result in results if not result.protocol.needs_data)
    lines = []
    for (first, count), _ in drawn.most_common()[1:]:
        names = [
            result.name
            for result in results
            if (result.first_seed, result.seeds) == (first, count) and not result.protocol.needs_data
        ]
        lines.append(f"With {count} seeds from {first} on: {', '.join(names)}.")
    return lines


def _share(found: FigureResult) -> float:
    """Return how much of what its limit allows a figure uses up; infinite when nothing could be measured."""
    limit, judged = found.figure.required, found.judged.high if found.figure.at_most else found.judged.low
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
            "verdict": result.verdict,
            "seeds": result.seeds,
            "first_seed": result.first_seed,
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
                    "judged": _finite(found.judged.value),
                    "low": _finite(found.judged.low),
                    "high": _finite(found.judged.high),
                    "each": found.each,
                    "verdict": found.verdict,
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
