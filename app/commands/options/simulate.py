"""Words of `telemotion simulate`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from app.commands.options.words import Email, Password, Server


@dataclass(frozen=True, kw_only=True)
class SimulateOptions:
    """Stream a simulated patient to a service over the real socket, in real time or faster.

    Holds the N-pose, is calibrated, moves, and closes the session, as a gateway and a therapist would. Example:

    telemotion simulate --email therapist@demo.example --password ... --patient ID --movement drinking --loss-percent 5
    """

    command: ClassVar[str] = "simulate"
    runs: ClassVar[str] = "app.commands.simulation.chosen:simulate"

    server: Server = "http://127.0.0.1:8000"
    email: Email = ""
    password: Password = ""
    patient_id: Annotated[
        str, typer.Option("--patient", help="Patient identifier, as in the address of the patient's page.")
    ] = ""
    exercise_id: Annotated[
        str | None, typer.Option("--exercise", help="Exercise identifier; without, a free session.")
    ] = None
    movement: Annotated[
        str,
        typer.Option(
            help="reaching, drinking, abduction, flexion or pronation of an arm; knee_extension or leg_raise of a leg."
        ),
    ] = "reaching"
    arms: Annotated[str, typer.Option(help="Side that acts: left, right or, of arms, both.")] = "right"
    repetitions: Annotated[int, typer.Option(help="Repetitions of the movement.", min=1, max=500)] = 10
    patient_kind: Annotated[str, typer.Option(help="therapist_template, mild_stroke or moderate_stroke.")] = (
        "mild_stroke"
    )
    orientation: Annotated[
        str, typer.Option(help="Orientation estimator of the session; empty for the default.")
    ] = ""
    errors: Annotated[str, typer.Option(help="Sensor errors: nominal, marzouk_2009 or ideal.")] = "nominal"
    speed: Annotated[
        float | None, typer.Option(help="1 is real time, 10 ten times faster.", min=0.1, max=1000)
    ] = 1.0
    loss_percent: Annotated[
        float, typer.Option(help="Packets lost in bursts, never sent.", min=0, max=50)
    ] = 0.0
    duplicates_percent: Annotated[float, typer.Option(help="Packets sent twice.", min=0, max=50)] = 0.0
    reordered_percent: Annotated[float, typer.Option(help="Packets sent out of order.", min=0, max=50)] = 0.0
    breaks: Annotated[int, typer.Option(help="Times the connection is cut.", min=0, max=20)] = 0
    seed: Annotated[int, typer.Option(help="Same seed, same signals.")] = 1
    purpose: Annotated[str, typer.Option(help="exercise or template.")] = "exercise"
    forever: Annotated[
        bool, typer.Option("--forever", help="Begin again with a new session when one ends.")
    ] = False
    relative: Annotated[
        str,
        typer.Option(
            help="Instead of an arm, a magnetic source: flexion, rotation, walk_back, shoulder, hip, walk_leg, feet or"
            " bench."
        ),
    ] = ""
    walk: Annotated[
        str,
        typer.Option(
            help="Instead of an arm, a walk on instrumented shoes with load cells: centre_of_mass, stroke, turns,"
            " shuffling, placement, ankle or stairs."
        ),
    ] = ""
    steps: Annotated[int, typer.Option(help="Steps of a --walk.", min=4, max=2000)] = 24
    forces: Annotated[
        bool, typer.Option(help="Whether the shoes of a --walk have load cells; else one sensor a foot.")
    ] = True
    duration_s: Annotated[
        float, typer.Option("--seconds", help="Length of a --relative session.", min=10, max=1800)
    ] = 60.0
    no_implants: Annotated[
        bool,
        typer.Option(
            "--no-implants", help="Confirm that nobody near the source has a pacemaker or the like."
        ),
    ] = False
    bursts: Annotated[
        bool,
        typer.Option(
            "--bursts",
            help="The source of --relative fires three-coil bursts by itself, deaf to the service.",
        ),
    ] = False
    log: Annotated[
        Path | None,
        typer.Option("--to", help="With --bursts: write a packet log for `process`, without any service."),
    ] = None
    mqtt: Annotated[
        str,
        typer.Option(
            help="Send by MQTT, to the listener at mqtt://host:port or mqtts://host:port; needs the extra `scaled`."
        ),
    ] = ""
