"""Measures that need several repetitions: how alike they are, with its uncertainty."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from estimators.comparison._contract import Measure
from estimators.comparison.channels.names import channel_unit, tells_movement
from estimators.comparison.measures.coordination import multiple_correlation
from estimators.recording import Float
from estimators.sentences import say

TOGETHER: Final = ("multiple_correlation:", "repetition_rms:")
"""How the names of measures begin that no repetition has alone."""


def likeness_measures(curves: Sequence[Float], channels: tuple[str, ...], primary: str) -> list[Measure]:
    """Measure how alike repetitions are, by angle (`measures.coordination.multiple_correlation`).

    Parameters
    ----------
    curves : sequence of ndarray, shape (101, C)
        The repetitions that count, each over its own phase.
    primary : str
        Main channel of the exercise; it comes first.

    Returns
    -------
    list of Measure
        Of each main angle `multiple_correlation:<angle>`, NaN with the reason where the repetitions differ more from
        each other than the movement goes, and `repetition_rms:<angle>`, their distance from their mean. Empty for
        fewer than two repetitions. The uncertainty is the jackknife's (each repetition left out once), so it needs
        three.

    Notes
    -----
    Efron and Stein 1981, Annals of Statistics 9:586, for the jackknife.
    """
    if len(curves) < 2:
        return []
    together = np.stack(list(curves))
    wanted = [name for name in channels if tells_movement(name)]
    found = []
    for name in dict.fromkeys([*(n for n in (primary,) if n in channels), *wanted]):
        own = together[:, :, channels.index(name)]
        known = np.isfinite(own).all(axis=0)
        if known.sum() < 2:
            continue
        found.extend(_likeness(name, own[:, known]))
    return found


def _likeness(name: str, own: Float) -> list[Measure]:
    whole, count, unit = multiple_correlation(own), len(own), channel_unit(name)
    reason = ""
    if not whole.is_defined and unit == "m":
        reason = say("measure.unlike_length", rms_m=whole.rms, extent_m=whole.extent)
    elif not whole.is_defined:
        reason = say("measure.unlike_angle", rms_rad=whole.rms, extent_rad=whole.extent)
    less = [multiple_correlation(np.delete(own, one, axis=0)) for one in range(count)] if count > 2 else []
    return [
        Measure(
            f"multiple_correlation:{name}",
            "shape",
            whole.value,
            "1",
            _jackknife([one.value for one in less]),
            count,
            reason,
        ),
        Measure(f"repetition_rms:{name}", "shape", whole.rms, unit, _jackknife([o.rms for o in less]), count),
    ]


def _jackknife(left_out: Sequence[float]) -> float:
    count = len(left_out)
    if count < 3:
        return float("nan")
    values = np.asarray(left_out)
    return float(np.sqrt((count - 1) / count * np.sum((values - values.mean()) ** 2)))
