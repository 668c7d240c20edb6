"""A command whose words are the fields of one dataclass: said once, read by the command line and by the command."""

import dataclasses
import inspect
from collections.abc import Callable
from importlib import import_module
from typing import Any, ClassVar, Protocol, TypeVar, get_type_hints

import typer

_Made = TypeVar("_Made")


class CommandOptions(Protocol):
    """A frozen dataclass: each field is an argument or option, the docstring is what `--help` says."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    command: ClassVar[str]
    """Name on the command line."""

    runs: ClassVar[str]
    """`module:function` that is called with an instance; imported only then, so that `--help` is instant."""


def add_commands(cli: typer.Typer, *declared: type[CommandOptions]) -> None:
    """Add a command for each class of options.

    Parameters
    ----------
    *declared : type[CommandOptions]
        The fields' annotations carry `typer.Option` or `typer.Argument`; the field's default is that of the option.
    """
    for options in declared:
        cli.command(options.command, help=inspect.getdoc(options))(_function(options))


def shared(kind: type[_Made], options: object, **changed: Any) -> _Made:
    """Return an instance of the dataclass `kind` from the fields of `options` that it has too, some of them changed."""
    names = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    common = {name: value for name, value in vars(options).items() if name in names}
    return kind(**common | changed)


def _function(options: type[CommandOptions]) -> Callable[..., None]:
    """Return the function that typer sees: the fields as its parameters."""

    def run(**given: Any) -> None:
        module, name = options.runs.split(":")
        getattr(import_module(module), name)(options(**given))

    fields = dataclasses.fields(options)
    hints = get_type_hints(options, include_extras=True)
    run.__annotations__ = {field.name: hints[field.name] for field in fields}
    run.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
        [
            inspect.Parameter(
                field.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default,
                annotation=hints[field.name],
            )
            for field in fields
        ]
    )
    return run
