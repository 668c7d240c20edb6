"""The command line: `telemotion COMMAND --help` explains each one.

Commands are thin: each parses its words here and calls one function of `app.commands`, imported only then, so that
`--help` is instant and a command loads only what it needs.
"""

from pathlib import Path
from typing import Annotated

import typer

from app.commands.options.declared import add_commands
from app.commands.options.recordings import CalibrateOptions, FuseOptions, MassCentreOptions, ProcessOptions
from app.commands.options.simulate import SimulateOptions
from app.commands.options.starting import CompileOptions, DemoOptions, NatsOptions, ScaledDemoOptions
from app.commands.options.tables import MappingOptions, UploadOptions
from app.commands.options.validate import ValidateOptions
from app.commands.options.words import NewPassword, PasswordFile, Port

cli = typer.Typer(
    name="telemotion",
    help="Telemotion: body-worn sensors in, motion and comparison with the therapist's template out.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    add_completion=False,
)
add_commands(
    cli,
    MassCentreOptions,
    DemoOptions,
    ScaledDemoOptions,
    CompileOptions,
    UploadOptions,
    MappingOptions,
    SimulateOptions,
    FuseOptions,
    CalibrateOptions,
)


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


add_commands(cli, NatsOptions)


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


add_commands(cli, ProcessOptions)


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


add_commands(cli, ValidateOptions)


def main() -> None:
    """Run the command line; expected failures are one line on standard error and exit code 2."""
    from app.commands.failures import in_one_line

    with in_one_line():
        cli()


if __name__ == "__main__":
    main()
