"""The command ``irsim-gym check``: validate scenario files."""

import sys
from collections.abc import Sequence

from irsim_gym.base.errors import IrsimGymError, Problem, ScenarioError
from irsim_gym.cli.work.inspection import blocked_start, fitting_task, team_error
from irsim_gym.cli.work.trial import ReadOptions, try_files
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.reading.notes import notes
from irsim_gym.scenario.reading.parameters import describe_parameters
from irsim_gym.tasks import Task
from irsim_gym.tasks.definition.sight import all_of, idle_robots, unseen

Read = tuple[Scenario, Task | None, ScenarioError | None]
"""A scenario, its task (None without learners), and the reason why no robot can learn (None if one can)."""


def check_files(files: Sequence[str], reading: ReadOptions) -> bool:
    """Read files, run each for a few steps, print the results, and return whether all of them are valid.

    Args:
        files: Scenario files or shipped names.
        reading: How the files are read.
    """
    read: dict[str, Read | None] = {}  # None: it is played for further problems, beside those of its task
    failures: dict[str, str] = {}
    for file in dict.fromkeys(files):
        try:
            scenario = load_scenario(file, reading.parameters, strict=reading.strict, warn=False)
            read[file] = None
            read[file] = scenario, *fitting_task(scenario, reading.task, team=reading.team)
        except (IrsimGymError, OSError) as error:
            failures[file] = str(error)
    played = try_files(list(read), reading) if read else {}
    for file, one in played.items():
        if one.failure and one.failure != failures.get(file):
            failures[file] = f"{failures[file]}\n{one.failure}" if file in failures else one.failure
    alone = not reading.team and reading.task is None
    for file, known in read.items():
        if known is not None and file in failures and alone and (blocked := blocked_start(known[0])):
            del failures[file]
            read[file] = known[0], None, blocked
    for file in files:
        found = read.get(file)
        if file in failures or found is None:
            print(failures[file], file=sys.stderr)
            for note in _task_notes(*found[:2]) if found is not None else []:
                print(f"  note: {note.path}: {note.message}", file=sys.stderr)
        else:
            _describe(file, found, played[file].notes, reading)
    return not failures


def _describe(file: str, read: Read, met: Sequence[Problem], reading: ReadOptions) -> None:
    """Print that a file is valid, with its learners, parameters and notes; ``met`` are those on its levels."""
    scenario, task, unfit = read
    refused = None if reading.team or unfit else team_error(scenario, reading.task)
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
    found = (*notes(scenario), *_task_notes(scenario, task), *met)
    for note in found:
        print(f"  {file}:{note.line}   {note.path}: {note.message}")
    if found:
        print("  (notes only: the file can be used, and the exit status stays 0)")


def _task_notes(scenario: Scenario, task: Task | None) -> list[Problem]:
    """Return notes on robots that nobody drives, and on bodies that no observation of the learners shows."""
    if task is None:
        return []
    idle, hidden = idle_robots(scenario, task), unseen(scenario, task)
    body = scenario.bodies[task.agents[0]]
    found = [Problem(body.line, body.name, f"{idle}; --team trains {all_of(scenario)}")] if idle else []
    message = (
        f"the learner observes nothing of {hidden}: a sensor and the observation scan, "
        "or nearest_bodies, which needs none, would show it"
    )
    return [*found, *([Problem(body.line, body.name, message)] if hidden else [])]
