"""The command line: `telemotion COMMAND --help` explains each one.

Commands are thin: each parses its words here and calls one function of `app.commands`, imported only then, so that
`--help` is instant and a command loads only what it needs.
"""

from pathlib import Path
from typing import Annotated

import typer

from app.commands.options_demo import compile_kernels, demo
from app.commands.options_mass_centre import mass_centre
from app.commands.options_tables import mapping, upload
from app.commands.words import (
    Bursts,
    Email,
    Guess,
    LogFile,
    Mapping,
    OutFolder,
    Password,
    Port,
    RecordingFile,
    RecordingFormat,
    Server,
)

cli = typer.Typer(
    name="telemotion",
    help="Telemotion: body-worn sensors in, motion and comparison with the therapist's template out.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
cli.command("mass-centre")(mass_centre)
cli.command()(demo)
cli.command("compile")(compile_kernels)
cli.command()(upload)
cli.command()(mapping)


@cli.command()
def serve(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Port = 8000,
) -> None:
    """Start the service. Settings come from TELEMOTION_* variables; unsafe ones refuse to start.

    The database is brought to the newest schema first.
    """
    from app.commands import serve as command

    command.serve(host, port)


@cli.command()
def migrate() -> None:
    """Bring the database of TELEMOTION_DATABASE_URL to the newest schema."""
    from app.commands import store as command

    command.migrate()


@cli.command("create-clinic")
def create_clinic(
    clinic: Annotated[str, typer.Argument(help="Name of the clinic.")],
    email: Annotated[str, typer.Option(help="E-mail of its first administrator.")],
    name: Annotated[str, typer.Option(help="Name of that person.")],
    password: Annotated[
        str, typer.Option(help="Their password; asked for when absent.", prompt=True, hide_input=True)
    ],
) -> None:
    """Create a clinic and its first administrator, on the server's own machine."""
    from app.commands import store as command

    command.create_clinic(clinic, email, name, password)


@cli.command()
def simulate(
    server: Server = "http://127.0.0.1:8000",
    email: Email = "",
    password: Password = "",
    patient: Annotated[
        str, typer.Option(help="Patient identifier, as in the address of the patient's page.")
    ] = "",
    exercise: Annotated[str, typer.Option(help="Exercise identifier; empty for a free session.")] = "",
    movement: Annotated[
        str, typer.Option(help="reaching, drinking, abduction, flexion or pronation.")
    ] = "reaching",
    arms: Annotated[str, typer.Option(help="left, right or both.")] = "right",
    repetitions: Annotated[int, typer.Option(help="Repetitions of the movement.", min=1, max=500)] = 10,
    patient_kind: Annotated[
        str, typer.Option(help="therapist_template, mild_stroke or moderate_stroke.")
    ] = "mild_stroke",
    orientation: Annotated[
        str, typer.Option(help="Orientation estimator of the session; empty for the default.")
    ] = "",
    errors: Annotated[str, typer.Option(help="Sensor errors: nominal, marzouk_2009 or ideal.")] = "nominal",
    speed: Annotated[
        float, typer.Option(help="1 is real time, 10 ten times faster.", min=0.1, max=1000)
    ] = 1.0,
    loss_percent: Annotated[
        float, typer.Option(help="Packets lost in bursts, never sent.", min=0, max=50)
    ] = 0.0,
    duplicates_percent: Annotated[float, typer.Option(help="Packets sent twice.", min=0, max=50)] = 0.0,
    reordered_percent: Annotated[float, typer.Option(help="Packets sent out of order.", min=0, max=50)] = 0.0,
    breaks: Annotated[int, typer.Option(help="Times the connection is cut.", min=0, max=20)] = 0,
    seed: Annotated[int, typer.Option(help="Same seed, same signals.")] = 1,
    purpose: Annotated[str, typer.Option(help="exercise or template.")] = "exercise",
    forever: Annotated[
        bool, typer.Option("--forever", help="Begin again with a new session when one ends.")
    ] = False,
    relative: Annotated[
        str,
        typer.Option(
            help="Instead of an arm, a magnetic source: flexion, rotation, walk_back, shoulder, hip, walk_leg, feet or"
            " bench."
        ),
    ] = "",
    walk: Annotated[
        str,
        typer.Option(
            help="Instead of an arm, a walk on instrumented shoes with load cells: centre_of_mass, stroke, turns,"
            " shuffling, placement, ankle or stairs."
        ),
    ] = "",
    steps: Annotated[int, typer.Option(help="Steps of a --walk.", min=4, max=2000)] = 24,
    forces: Annotated[
        bool, typer.Option(help="Whether the shoes of a --walk have load cells; else one sensor a foot.")
    ] = True,
    seconds: Annotated[float, typer.Option(help="Length of a --relative session.", min=10, max=1800)] = 60.0,
    no_implants: Annotated[
        bool,
        typer.Option(
            "--no-implants", help="Confirm that nobody near the source has a pacemaker or the like."
        ),
    ] = False,
    bursts: Bursts = False,
    to: LogFile = None,
) -> None:
    """Stream a simulated patient to a service over the real socket, in real time or faster.

    Holds the N-pose, is calibrated, moves, and closes the session, as a gateway and a therapist would. Example:

    telemotion simulate --email therapist@demo.example --password ... --patient ID --movement drinking --loss-percent 5
    """
    if relative:
        from app.commands import simulate_relative as magnetic

        magnetic.simulate_relative(
            magnetic.RelativeOptions(
                server,
                email,
                password,
                patient,
                relative,
                seconds,
                speed,
                seed,
                no_implants,
                bursts=bursts,
                log=to,
            )
        )
        return
    if walk:
        from app.commands import simulate_walk as walking

        walking.simulate_walk(
            walking.WalkOptions(
                server,
                email,
                password,
                patient,
                exercise or None,
                walk,
                steps,
                speed,
                seed,
                forces,
                loss_percent=loss_percent,
                breaks=breaks,
            )
        )
        return
    from app.commands import simulate as command

    command.simulate(
        command.Options(
            server=server,
            email=email,
            password=password,
            patient_id=patient,
            exercise_id=exercise or None,
            movement=movement,
            arms=arms,
            repetitions=repetitions,
            patient_kind=patient_kind,
            orientation=orientation,
            errors=errors,
            speed=speed,
            loss_percent=loss_percent,
            duplicates_percent=duplicates_percent,
            reordered_percent=reordered_percent,
            breaks=breaks,
            seed=seed,
            purpose=purpose,
            forever=forever,
        )
    )


@cli.command()
def process(
    recording: RecordingFile,
    out: OutFolder,
    pipeline: Annotated[
        str,
        typer.Option(
            help="arm (joint angles), gait (feet and strides), orientation (single sensors) or magnetic_bursts;"
            " default: what the sensors are worn for."
        ),
    ] = "",
    orientation: Annotated[
        str, typer.Option(help="Orientation estimator, e.g. vqf; empty for the default.")
    ] = "",
    format: RecordingFormat = "auto",
    mapping: Mapping = None,
    guess: Guess = False,
    rate: Annotated[
        float | None, typer.Option(help="Common tick rate in Hz; default: the recording's.")
    ] = None,
    pose: Annotated[
        tuple[float, float] | None,
        typer.Option(help="Start and end (s) of the N-pose; default: first stillness."),
    ] = None,
    parameters: Annotated[str, typer.Option(help="Estimator parameters as JSON.")] = "{}",
    force: Annotated[
        bool, typer.Option("--force", help="Estimate although units, axes or signs cannot be right.")
    ] = False,
    hemisphere: Annotated[
        str,
        typer.Option(help="north, south or unknown: where it was recorded; tells a reversed accelerometer."),
    ] = "north",
) -> None:
    """Estimate a recording without a server; writes frames.parquet, frames.csv, columns.json, setup.json.

    Example: telemotion process walk.mat --pipeline orientation --orientation vqf --out results
    """
    from app.commands import process as command

    command.process(
        recording,
        out,
        pipeline,
        orientation,
        format,
        mapping,
        rate,
        pose,
        parameters,
        force,
        hemisphere,
        guess,
    )


@cli.command("calibrate-source")
def calibrate_source(
    recording: Annotated[
        Path,
        typer.Argument(
            help="Packet log of a session in which the sensor was laid at places around the source.",
            exists=True,
            dir_okay=False,
        ),
    ],
    places: Annotated[
        Path | None,
        typer.Option(
            help="CSV: x, y, z in metres from the middle of the source along its axes, a line for each place; - leaves"
            " one out. Without it the places that were found are listed.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
    serial: Annotated[str, typer.Option(help="Serial number of the source.")] = "",
    name: Annotated[str, typer.Option(help="Its name; default: the serial number.")] = "",
    out: Annotated[Path | None, typer.Option(help="JSON file to write, for the clinic's page.")] = None,
    source: Annotated[
        str, typer.Option(help="Placement of the source; default: pelvis, sternum, foot.")
    ] = "",
    sensor: Annotated[str, typer.Option(help="Placement of the sensor; default: the first other one.")] = "",
    ruler_mm: Annotated[
        float, typer.Option(help="How well the places were measured, one sigma.", min=0.05, max=20)
    ] = 1.0,
    turns: Annotated[float, typer.Option(help="Of a coil as designed.", min=1, max=5000)] = 50.0,
    radius_cm: Annotated[float, typer.Option(help="Of a coil as designed.", min=0.5, max=50)] = 5.5,
    offset_cm: Annotated[
        float, typer.Option(help="From the middle of the source to a coil, along its axis.", min=0, max=50)
    ] = 6.0,
    current_limit: Annotated[float, typer.Option(help="Of the driver, in A.", min=0.01, max=9.9)] = 1.5,
) -> None:
    """Find moment, place and direction of each coil of a magnetic source from a bench recording.

    Example: telemotion calibrate-source bench.tml --places places.csv --serial S-12 --out S-12.json
    """
    from app.commands import calibrate_source as command

    command.calibrate_source(
        command.CalibrateOptions(
            recording,
            places,
            serial,
            name,
            out,
            source,
            sensor,
            ruler_mm,
            turns,
            radius_cm,
            offset_cm,
            current_limit,
        )
    )


@cli.command()
def fuse(
    recording: RecordingFile,
    markers: Annotated[
        Path, typer.Argument(help="Markers of a camera system: C3D or CSV.", exists=True, dir_okay=False)
    ],
    out: OutFolder,
    sensor: Annotated[
        str, typer.Option(help="Sensor that moved with the marker; needed when there are several.")
    ] = "",
    format: RecordingFormat = "auto",
    mapping: Mapping = None,
    rate: Annotated[
        float | None, typer.Option(help="Tick rate in Hz; default: the recording's.", min=10, max=10000)
    ] = None,
    marker: Annotated[str, typer.Option(help="Name of the marker; default: the one seen most.")] = "",
    cluster: Annotated[
        list[str] | None,
        typer.Option(help="Another marker of the same rigid body, three or more: aligns by rate too."),
    ] = None,
    up: Annotated[
        str, typer.Option(help="Axis of the laboratory that points up: x, y, z, -x, -y or -z.")
    ] = "z",
    unit: Annotated[str, typer.Option(help="Of a CSV of markers: mm, cm, m or inch.")] = "mm",
    marker_rate: Annotated[
        float | None, typer.Option(help="Frames a second of a CSV without a column time_s.")
    ] = None,
    delimiter: Annotated[str, typer.Option(help="Of a CSV of markers.")] = ",",
    lever_arm: Annotated[
        tuple[float, float, float] | None,
        typer.Option(help="From sensor to marker in sensor axes (m), if measured; default: found."),
    ] = None,
    largest_offset: Annotated[float | None, typer.Option(help="How far the clocks can be apart (s).")] = None,
    lag: Annotated[float | None, typer.Option(help="Also tell what is known so many seconds later.")] = None,
) -> None:
    """Fuse a sensor with a marker of a camera system: gaps filled, motion at the rate of the sensor.

    Aligns the clocks by the movement; writes motion.csv (smoothed), filter.csv (what was known at each moment),
    lagged.csv (with --lag: a moment later), residuals.csv, gaps.csv and report.json. Markers in a CSV are columns
    NAME_x, NAME_y, NAME_z and time_s. Example:

    telemotion fuse walk.tml walk.c3d --sensor foot_right --marker RHEE --out results
    """
    from app.commands import fuse as command

    command.fuse(
        command.FuseOptions(
            *(recording, markers, out, sensor, format, mapping, rate, marker, tuple(cluster or ())),
            *(up, unit, marker_rate, delimiter, lever_arm, largest_offset, lag),
        )
    )


@cli.command()
def reprocess(
    session: Annotated[str, typer.Argument(help="Session identifier, or `all`.")],
    orientation: Annotated[str, typer.Option(help="Orientation estimator, e.g. marzouk_quaternion_ekf.")],
    parameters: Annotated[str, typer.Option(help="Estimator parameters as JSON.")] = "{}",
) -> None:
    """Estimate a stored session again; the earlier results stay beside the new one."""
    from app.commands import store as command

    command.reprocess(session, orientation, parameters)


@cli.command()
def backup(
    archive: Annotated[Path, typer.Argument(help="File to write; must not exist.")],
) -> None:
    """Write the whole database to one file while the service runs."""
    from app.commands import store as command

    command.backup(archive)


@cli.command()
def restore(
    archive: Annotated[Path, typer.Argument(help="File that backup wrote.", exists=True, dir_okay=False)],
) -> None:
    """Fill the empty database of TELEMOTION_DATABASE_URL from a backup; refuses a database with data."""
    from app.commands import store as command

    command.restore(archive)


@cli.command("audit-verify")
def audit_verify(
    against: Annotated[
        Path | None,
        typer.Option(
            help="A backup; finds events that were cut off since it was made.", exists=True, dir_okay=False
        ),
    ] = None,
) -> None:
    """Check that no event of the audit trail was changed, removed or inserted. Exit code 1 when one was."""
    from app.commands import store as command

    command.audit_verify(against)


@cli.command()
def validate(
    names: Annotated[
        list[str] | None, typer.Argument(help="Protocols to run; all when none is named.")
    ] = None,
    seeds: Annotated[int, typer.Option(help="Simulated repetitions of each protocol.", min=1, max=1000)] = 20,
    first_seed: Annotated[
        int | None,
        typer.Option(help="Use this seed and those after it; drawn from the version by default.", min=0),
    ] = None,
    processes: Annotated[int, typer.Option(help="How many processes work at once.", min=1)] = 1,
    data: Annotated[
        Path | None,
        typer.Option(
            help="Folder of recordings (BROAD, PyShoe, gaitmap, x-io); without, their protocols are left out."
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
    list_only: Annotated[bool, typer.Option("--list", help="Only name the protocols.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Also write the report with its plots to this JSON file.")
    ] = None,
    page: Annotated[Path | None, typer.Option(help="Also write a Markdown page to this file.")] = None,
    into: Annotated[
        Path | None,
        typer.Option(help="Put the results into this report of all protocols; --page is then of the whole."),
    ] = None,
) -> None:
    """Run the published experiments: published figure, required figure, ours. Exit code 1 when one falls short."""
    from app.commands import validate as command

    command.validate(
        names or None,
        seeds,
        first_seed,
        processes,
        data,
        json=json,
        list_only=list_only,
        out=out,
        page=page,
        into=into,
    )


def main() -> None:
    """Run the command line; expected failures are one line on standard error and exit code 2."""
    from app.commands.failures import in_one_line

    with in_one_line():
        cli()


if __name__ == "__main__":
    main()
