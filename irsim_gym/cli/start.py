"""The commands ``irsim-gym new``, ``options`` and ``schema``."""

from pathlib import Path
from typing import Annotated

import typer

from irsim_gym.cli.options import HELP, Imports
from irsim_gym.cli.tools import print_options


def new(file: Annotated[Path, typer.Argument(metavar="FILE", help=HELP["new file"])]) -> None:
    """Write a commented scenario to start from."""
    from irsim_gym.scenario.specs.library import write_template

    write_template(file)
    print(f"{file}: change it, then\n  irsim-gym check {file}\n  irsim-gym train {file}")


def options(
    name: Annotated[str | None, typer.Argument(help=HELP["options name"])] = None, modules: Imports = None
) -> None:
    """Print the kinds of a family, or the options of one kind; of all as Markdown."""
    from irsim_gym.scenario.reference.option_tables import markdown

    print(markdown()) if name is None else print_options(name)


def schema() -> None:
    """Write the JSON Schema of scenario files, for editors."""
    import json

    from irsim_gym.scenario.reference.schema import json_schema

    print(json.dumps(json_schema(), indent=2))
