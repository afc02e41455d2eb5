"""The command ``irsim-gym check``: validate scenario files."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from irsim_gym.errors import IrsimGymError, Problem, ScenarioError
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.notes import notes
from irsim_gym.scenario.parameters import describe_parameters
from irsim_gym.tasks import Task
from irsim_gym.tasks.sight import unseen
from irsim_gym.training.inspection import blocked_start, fitting_task, team_error
from irsim_gym.training.trial import ReadOptions, try_files

Read = tuple[Scenario, Task | None, ScenarioError | None]
"""A scenario, its task (None without learners), and the reason why no robot can learn (None if one can)."""


def check_files(files: Sequence[str], reading: ReadOptions, *, team: bool) -> bool:
    """Read files, run each for a few steps, print the results, and return whether all of them are valid.

    Args:
        files: Scenario files or shipped names.
        reading: How the files are read. The child process that runs them imports the same plugins.
        team: Whether all robots have to be able to learn together.
    """
    read: dict[str, Read | None] = {}  # None: it is played for further problems, beside those of its task
    failures: dict[str, str] = {}
    for file in dict.fromkeys(files):
        try:
            scenario = load_scenario(file, reading.parameters, strict=reading.strict, warn=False)
            read[file] = None
            read[file] = scenario, *fitting_task(scenario, team=team)
        except (IrsimGymError, OSError) as error:
            failures[file] = str(error)
    played = try_files(list(read), reading) if read else {}
    for file, (message, _) in played.items():
        if message:
            failures[file] = f"{failures[file]}\n{message}" if file in failures else message
    for file, known in read.items():
        if known is not None and file in failures and not team and (blocked := blocked_start(known[0])):
            del failures[file]
            read[file] = known[0], None, blocked
    for file in files:
        found = read.get(file)
        if file in failures or found is None:
            print(failures[file], file=sys.stderr)
        else:
            _describe(file, found, played[file][1], team=team)
    return not failures


def _describe(file: str, read: Read, remark: str, *, team: bool) -> None:
    """Print that a file is valid, with its learners, parameters and notes; ``remark`` is on its wandering bodies."""
    scenario, task, unfit = read
    refused = None if team or unfit else team_error(scenario)
    robots = len(scenario.robots)
    learned = f"task '{task.name}'" if task is not None else f"no robot {'that can' if robots else 'to'} learn"
    obstacles = len(scenario.bodies) - robots
    extent = "fine to run" if unfit else "fine" if refused is None else "fine for one learner"
    print(f"{file}: {extent} (robots: {robots}, obstacles: {obstacles}, {learned})")
    if unfit is not None:
        print("  but no environment, unless a task is given that fits, with")
        print("\n".join(f"  {line}" for line in str(unfit).splitlines()))
    if refused is not None:
        print("  but where all robots learn together it is refused (with --team the exit status is 1), with")
        print("\n".join(f"  {line}" for line in str(refused).splitlines()))
    for line in describe_parameters(scenario.source, scenario.parameters):
        print(f"  {line}")
    standing = [Problem(body.line, body.name, remark) for body in scenario.bodies if remark and body.wanders]
    found = (*notes(scenario), *_blind_spots(scenario, task), *standing[:1])
    for note in found:
        print(f"  {file}:{note.line}   {note.path}: {note.message}")
    if found:
        print("  (notes only: the file can be used, and the exit status stays 0)")


def _blind_spots(scenario: Scenario, task: Task | None) -> list[Problem]:
    """Return a note if the learners may collide with bodies that no observation shows."""
    hidden = "" if task is None else unseen(scenario, task)
    if task is None or not hidden:
        return []
    body = scenario.bodies[task.agents[0]]
    message = (
        f"the learner observes nothing of {hidden}: a sensor and the observation scan, "
        "or nearest_bodies, which needs none, would show it"
    )
    return [Problem(body.line, body.name, message)]
