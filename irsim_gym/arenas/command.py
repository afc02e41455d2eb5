"""The command ``irsim-gym arena``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from irsim_gym.arenas.contest import Arena, arena
from irsim_gym.arenas.entrants import check_entrants
from irsim_gym.evaluation.tables import print_table
from irsim_gym.training.folders import evaluation_folder
from irsim_gym.training.inputs import check_inputs
from irsim_gym.training.interruption import ctrl_c_as_error
from irsim_gym.training.remembered import remembered_parameters, report_changes


def run_arena(
    scenario: str,
    policies: Sequence[str],
    out: Path | None,
    parameters: Mapping[str, object] | None = None,
    *,
    split: str,
    resume: bool,
    overwrite: bool,
    strict: bool,
    **chosen: Any,
) -> Arena:
    """Play an arena, and print its tables and the path of its page.

    Args:
        scenario: Shipped name, environment id, or path of a scenario file.
        policies: The policies, as ``load_policy`` takes them.
        out: Folder of the results; None for a folder in ``runs``.
        parameters: Values for the scenario's parameters.
        split: ``"test"``, ``"dev"`` or ``"train"``.
        resume: Continue the arena in the folder.
        overwrite: Replace the arena in the folder.
        strict: False ignores unused keys.
        **chosen: Further arguments of ``arena``: levels, task, team, mix, replays.

    Raises:
        TrainingInterruptedError: If the user presses Ctrl-C; the rows of finished policies are on disk.
    """
    given: dict[str, Any] = {"task": chosen.get("task"), "parameters": parameters, "policies": policies}
    entered = partial(check_entrants, policies)
    check_inputs(scenario, entered, split=split, folder=out, team=bool(chosen.get("team")), strict=strict, **given)
    used = remembered_parameters(scenario, policies, parameters, strict=strict)
    report_changes(scenario, policies, chosen.get("task"), strict=strict)
    of_teams = bool(chosen.get("team") or chosen.get("mix"))
    folder = out or evaluation_folder(scenario, split, used, of_teams, overwrite=overwrite, resume=resume, kind="arena")
    kept = f"stopped; policies that have finished are in {folder}. To continue, run the same command with --resume."
    with ctrl_c_as_error(kept):
        how: dict[str, Any] = {"resume": resume, "overwrite": overwrite, "parameters": used, "strict": strict}
        found = arena(scenario, policies, folder, split=split, **how, **chosen)
    for table in found.standings.tables(found.title):
        print_table(table)
    print(f"rows, figures and table: {folder}")
    print(f"page: {found.page}")
    return found
