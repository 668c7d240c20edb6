"""Simulated walks of both feet, as recordings and as what is compared."""

from dataclasses import fields, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from app.kinds.walk.compared import source_of
from app.kinds.walk.stored import content_of
from app.recordings.compared import Source
from estimators.comparison import Template, build_template
from estimators.pipelines import FEET, SessionSetup, analyse_walk
from estimators.recording import Recording
from estimators.simulation import FootStyle, GaitScenario, SimulatedWalk, WalkStyle, simulate_gait

SETUP = SessionSetup("gait", FEET, 100.0)


def both(**changes: Any) -> WalkStyle:
    """Return a walk in which both feet go otherwise than usual."""
    foot = replace(FootStyle(), **changes)
    return WalkStyle(feet={"left": foot, "right": foot})


def walked(style: WalkStyle | None = None, seed: int = 1, **scenario: Any) -> SimulatedWalk:
    """Return a walk with one sensor on each foot, where the shoes have the one of the heel."""
    made = simulate_gait(GaitScenario(style or WalkStyle(), seed=seed, has_load_cells=False, **scenario))
    sensors = {f"foot_{side}": made.recording.sensors[f"heel_{side}"] for side in ("left", "right")}
    return SimulatedWalk(Recording(sensors, made.recording.nominal_rate_hz, origin="simulation"), made.truth)


def until(recording: Recording, seconds: float) -> Recording:
    """Return the beginning of a recording."""
    ticks = round(seconds * recording.nominal_rate_hz)
    sensors = {}
    for name, own in recording.sensors.items():
        columns = {one.name: getattr(own, one.name) for one in fields(own)}
        sensors[name] = replace(
            own,
            **{
                name: values[:ticks]
                for name, values in columns.items()
                if isinstance(values, np.ndarray) and len(values) == len(own.time_s)
            },
        )
    return replace(recording, sensors=sensors)


def source(style: WalkStyle | None = None, seed: int = 1, **scenario: Any) -> Source:
    """Return the same, analysed, as what is compared."""
    return compared_as(walked(style, seed, **scenario).recording)


def compared_as(recording: Recording) -> Source:
    """Analyse a walk; return it as what is compared."""
    setup = replace(SETUP, rate_hz=recording.nominal_rate_hz)
    found = analyse_walk(recording, setup)
    result: Any = SimpleNamespace(id="result", session_id="session", setup=setup.to_dict())
    return source_of(found.frames, content_of(found), result, (None, None))


def template_of(shown: Source, side: str = "right") -> Template:
    """Return the template of a walk as the service begins one."""
    cycles = (shown.cycles or {})["left" if side == "left" else "right"]
    template = build_template(
        shown.moved, shown.judged(side), side, shown.reach_m, cycles.main_channel, judge=False
    )
    return replace(template, phases=cycles.phases, watched=cycles.watched)
