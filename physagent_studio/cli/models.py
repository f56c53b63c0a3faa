"""`physagent models`: the learned models of OpenCV's zoo, which are no part of the installation."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from physagent_studio.cli import output
from physagent_studio.cli.guard import NOT_REALISED, Json, guarded
from physagent_studio.errors import InputError

if TYPE_CHECKING:
    from physagent_studio.reconstruction.learned.zoo import ZooModel

models = typer.Typer(
    name="models",
    help="Learned models that make better masks and backgrounds: fetch, check, remove.",
    no_args_is_help=True,
)
Name = Annotated[str | None, typer.Argument(help="efficientsam or lama; without it both.")]


@models.command("list", epilog="Example: physagent models list")
@guarded
def list_models(as_json: Json = False) -> None:
    """What each model is for, its size, and whether it is there."""
    _tell(_wanted(None), as_json)


@models.command(epilog="Example: physagent models fetch efficientsam")
@guarded
def fetch(
    name: Name = None,
    source: Annotated[
        Path | None, typer.Option("--from", help="A copy of the file, where there is no network.")
    ] = None,
) -> None:
    """Fetch models from the zoo's home; what breaks off goes on where it was."""
    from physagent_studio.reconstruction.backends import zoo_files

    if source is not None and name is None:
        raise InputError("--from takes the file of one model: name it, efficientsam or lama")
    for model in _wanted(name):
        if source is not None:
            path = zoo_files.take(model, source)
        else:
            with output.bytes_bar(model.name) as progress:
                path = zoo_files.fetch(model, progress=progress)
        typer.echo(f"{model.name}: {path}")


@models.command(epilog="Example: physagent models verify")
@guarded
def verify(name: Name = None, as_json: Json = False) -> None:
    """Check the files that are there by their SHA-256; exit code 3 where one is damaged."""
    found = _tell(_wanted(name), as_json)
    if "damaged" in found or (name is not None and found != ["ready"]):
        raise typer.Exit(NOT_REALISED)


@models.command(epilog="Example: physagent models remove lama")
@guarded
def remove(name: Name = None) -> None:
    """Delete the files of models."""
    from physagent_studio.reconstruction.backends import zoo_files

    for model in _wanted(name):
        gone = zoo_files.remove(model)
        typer.echo(f"{model.name}: {'removed' if gone else 'was not there'}")


@models.command(epilog="Example: physagent models path efficientsam")
@guarded
def path(name: Name = None) -> None:
    """Where the files belong, whether they are there or not."""
    from physagent_studio.reconstruction.learned.zoo import path_of

    for model in _wanted(name):
        typer.echo(path_of(model))


def _wanted(name: str | None) -> list[ZooModel]:
    from physagent_studio.reconstruction.learned.zoo import ZOO, model_named

    return list(ZOO.values()) if name is None else [model_named(name)]


def _tell(wanted: list[ZooModel], as_json: bool) -> list[str]:
    """Prints how it stands with each model, and returns that."""
    from physagent_studio.reconstruction.learned.zoo import condition, path_of

    found = [condition(model) for model in wanted]
    if as_json:
        keys = ("name", "file", "size", "sha256", "url", "purpose")
        output.print_json(
            [
                {key: getattr(model, key) for key in keys}
                | {"condition": how, "path": str(path_of(model))}
                for model, how in zip(wanted, found, strict=True)
            ]
        )
        return list(found)
    for model, how in zip(wanted, found, strict=True):
        typer.echo(f"{model.name:<13}{how:<9}{model.size / 1e6:>5.0f} MB  {model.purpose}")
    if set(found) & {"absent", "partial"} and sys.stdout.isatty():
        typer.echo("`physagent models fetch` fetches what is not there.")
    return list(found)
