"""The command line: `telemotion COMMAND --help` explains each one.

Commands are thin: each parses its words here and calls one function of `app.commands`, imported only then, so that
`--help` is instant and a command loads only what it needs.
"""

from pathlib import Path
from typing import Annotated

import typer

from app.commands.options.declared import add_commands
from app.commands.options.demo import compile_kernels, demo, demo_scaled
from app.commands.options.mass_centre import mass_centre
from app.commands.options.recordings import CalibrateOptions, FuseOptions
from app.commands.options.simulate import SimulateOptions
from app.commands.options.tables import mapping, upload
from app.commands.options.words import (
    Guess,
    Hemisphere,
    Mapping,
    NewPassword,
    OutFolder,
    PasswordFile,
    Port,
    Pose,
    Rate,
    RecordingFiles,
    RecordingFormat,
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
cli.command("demo-scaled")(demo_scaled)
cli.command("compile")(compile_kernels)
cli.command()(upload)
cli.command()(mapping)
add_commands(cli, SimulateOptions, FuseOptions, CalibrateOptions)


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
def capacity(
    sessions: Annotated[int, typer.Option(min=1, help="Live at once, each watched.")] = 10_000,
    partitions: Annotated[int, typer.Option(min=1, help="Into which they are divided.")] = 2048,
) -> None:
    """Say what a number of live sessions needs on many machines, and what a worker's death does to them.

    Computed with the measured costs of docs/scaling.md. Needs the extra `scaled`.
    """
    from app.scaled.capacity import report

    report.capacity(sessions, partitions)


@cli.command()
def edge(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Port = 8000,
) -> None:
    """Start an edge of a service on many machines: gateways and browsers reach it. Needs the extra `scaled`."""
    from app.commands import scaled as command

    command.edge(host, port)


@cli.command()
def worker(
    host: Annotated[str, typer.Option(help="Address for health and metrics.")] = "127.0.0.1",
    port: Port = 8100,
) -> None:
    """Start a worker of a service on many machines: sessions are live in it. Needs the extra `scaled`."""
    from app.commands import scaled as command

    command.worker(host, port)


@cli.command("nats-config")
def nats_config(
    out: Annotated[
        Path, typer.Argument(help="File to write; it holds a password, and only you may read it.")
    ],
    listen: Annotated[str, typer.Option(help="Where edges and workers connect.")] = "127.0.0.1:4222",
    mqtt: Annotated[str, typer.Option(help="Where gateways connect by MQTT.")] = "127.0.0.1:1883",
    store: Annotated[str, typer.Option(help="Folder of the server's streams.")] = "var/nats",
    name: Annotated[str, typer.Option(help="Of the server.")] = "telemotion",
    tls: Annotated[str, typer.Option(help="CERTIFICATE,KEY: files of the TLS for gateways.")] = "",
    listen_tls: Annotated[
        str, typer.Option(help="CERTIFICATE,KEY: files of the TLS for edges and workers.")
    ] = "",
) -> None:
    """Write the configuration of a NATS server that takes gateways by MQTT, where edges say which of them may connect.

    TELEMOTION_SECRET_KEY and TELEMOTION_NATS_URL, with user and password, are those of the edges.
    """
    from app.commands import scaled as command

    command.nats_config(listen, mqtt, store, name, tls, listen_tls, out)


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
    password: NewPassword = "",
    password_file: PasswordFile = None,
) -> None:
    """Create a clinic and its first administrator, on the server's own machine; asks for the password."""
    from app.commands import store as command

    if password_file is not None:
        password = password_file.read_text("utf-8").partition("\n")[0].rstrip("\r")
    elif not password:
        password = typer.prompt("Password", hide_input=True, confirmation_prompt=True)
    command.create_clinic(clinic, email, name, password)


@cli.command()
def process(
    recording: RecordingFiles,
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
    rate: Rate = None,
    pose: Pose = None,
    parameters: Annotated[str, typer.Option(help="Estimator parameters as JSON.")] = "{}",
    force: Annotated[
        bool, typer.Option("--force", help="Estimate although units, axes or signs cannot be right.")
    ] = False,
    hemisphere: Hemisphere = "",
) -> None:
    """Estimate a recording without a server; writes frames.parquet, frames.csv, columns.json, setup.json.

    Example: telemotion process walk.mat --pipeline orientation --orientation vqf --out results
    """
    from app.commands import process as command
    from app.commands.options.several import as_one

    with as_one(recording) as one:
        command.process(
            one,
            out,
            pipeline,
            orientation,
            format,
            mapping,
            rate,
            pose,
            parameters,
            force,
            hemisphere or "north",
            guess,
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
    register: Annotated[
        list[Path] | None,
        typer.Option(
            help="A register (ended.jsonl) of another data folder, or a newer backup, which carries one.",
            exists=True,
            dir_okay=False,
        ),
    ] = None,
) -> None:
    """Fill the empty database of TELEMOTION_DATABASE_URL from a backup; refuses a database with data.

    Whoever was erased and whatever was revoked after it is so again, as the register in TELEMOTION_DATA_DIR says.
    """
    from app.commands import store as command

    command.restore(archive, register or ())


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
