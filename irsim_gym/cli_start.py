"""The commands ``irsim-gym new`` and ``irsim-gym doctor``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write, .yaml.")],
) -> None:
    """Write a commented scenario to start from."""
    from irsim_gym.scenario.library import write_template

    write_template(file)
    print(f"{file}: change it, then\n  irsim-gym check {file}\n  irsim-gym train {file}")


def doctor() -> None:
    """Show versions, the cache of kernels, processors, display and graphics card, and what commands need."""
    from irsim_gym.training.doctor import print_examination

    if not print_examination():
        raise typer.Exit(1)
