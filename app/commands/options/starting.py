"""Words of the commands that bring something up: the demonstrations, a NATS server, the kernels."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import typer

from app.commands.options.words import Port


@dataclass(frozen=True, kw_only=True)
class DemoOptions:
    """Start a demonstration clinic with invented patients and one who streams live.

    Prints the address and how to sign in. Its secrets are known to everybody: never with real patients.
    """

    command: ClassVar[str] = "demo"
    runs: ClassVar[str] = "app.commands.demo:demo"

    port: Port = 8000
    folder: Annotated[Path, typer.Option(help="Where the demonstration keeps its database.")] = Path(
        "var/demo"
    )
    fresh: Annotated[bool, typer.Option(help="Throw an earlier demonstration away first.")] = False
    stream: Annotated[bool, typer.Option(help="Start the simulated patient who streams live.")] = True
    started_s: Annotated[
        float | None, typer.Option(help="Epoch second from which stages are timed.", hidden=True)
    ] = None


@dataclass(frozen=True, kw_only=True)
class ScaledDemoOptions:
    """Start the demonstration on two edges, two workers, NATS and PostgreSQL. Needs the extra `scaled`."""

    command: ClassVar[str] = "demo-scaled"
    runs: ClassVar[str] = "app.commands.demo_scaled:demo_scaled"

    port: Port = 8000
    """Of the first edge; the next ports are those of the other edge and of the workers."""
    folder: Annotated[Path, typer.Option(help="Where NATS and PostgreSQL store.")] = Path("var/scaled")


@dataclass(frozen=True, kw_only=True)
class CompileOptions:
    """Compile every numerical kernel now, so that no session and no analysis waits for it. Takes some minutes."""

    command: ClassVar[str] = "compile"
    runs: ClassVar[str] = "app.commands.compile_kernels:compile_kernels"

    processes: Annotated[int, typer.Option(help="At once; one for each core is right.", min=1, max=64)] = 2
    into: Annotated[
        Path | None,
        typer.Option(help="Folder for kernels that a package carries: for any x86-64-v3 processor."),
    ] = None


@dataclass(frozen=True, kw_only=True)
class NatsOptions:
    """Write the configuration of a NATS server that takes gateways by MQTT, where edges say which of them may connect.

    TELEMOTION_SECRET_KEY and TELEMOTION_NATS_URL, with user and password, are those of the edges.
    """

    command: ClassVar[str] = "nats-config"
    runs: ClassVar[str] = "app.commands.scaled:nats_config"

    out: Annotated[Path, typer.Argument(help="File to write; it holds a password, and only you may read it.")]
    listen: Annotated[str, typer.Option(help="Where edges and workers connect.")] = "127.0.0.1:4222"
    mqtt: Annotated[str, typer.Option(help="Where gateways connect by MQTT.")] = "127.0.0.1:1883"
    store: Annotated[str, typer.Option(help="Folder of the server's streams.")] = "var/nats"
    name: Annotated[str, typer.Option(help="Of the server.")] = "telemotion"
    tls: Annotated[str, typer.Option(help="CERTIFICATE,KEY: files of the TLS for gateways.")] = ""
    listen_tls: Annotated[
        str, typer.Option(help="CERTIFICATE,KEY: files of the TLS for edges and workers.")
    ] = ""
