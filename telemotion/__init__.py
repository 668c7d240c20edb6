"""Telemotion for a notebook: a recording file in, angles with their uncertainty and measures out.

::

    import telemotion

    walked = telemotion.process(telemotion.read("walk.csv"))
    table = walked.table()

The packages of this installation are imported before modules of the same name beside a notebook: after
`import telemotion` an `app.py` of one's own is no longer found as `app`.

Tables need no mapping where their columns say what they are. What is assumed or doubted stands in `notes`.
"""

from telemotion._names import make_room

with make_room():
    from estimators.comparison import Template, build_template, compare, find_repetitions, trajectory
    from estimators.recording import Recording
    from telemotion._process import Processed, process, smooth
    from telemotion._read import Read, read

__all__ = [
    "Processed",
    "Read",
    "Recording",
    "Template",
    "build_template",
    "compare",
    "find_repetitions",
    "process",
    "read",
    "smooth",
    "trajectory",
]
