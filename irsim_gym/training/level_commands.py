"""What ``irsim-gym levels`` does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress

from irsim_gym.engine import Simulation, compile
from irsim_gym.errors import IrsimGymError, several
from irsim_gym.evaluation.tables import write_bytes
from irsim_gym.levels.draw import draw_levels
from irsim_gym.scenario import load_scenario
from irsim_gym.scenario.level_set import LevelSet, set_hash
from irsim_gym.tasks.levels import check_split
from irsim_gym.training.episode_setup import make_episodes

WORLDS = 64


@dataclass(frozen=True)
class Wanted:
    """A scenario as it is asked for.

    Attributes:
        scenario: Shipped name, environment id, or path of a file.
        task: Shipped name or path of a task; None for the scenario's own.
        team: All robots are agents, unless the task names some.
        parameters: Values for the scenario's parameters.
        strict: Unknown keys are errors.
    """

    scenario: str
    task: str | None = None
    team: bool = False
    parameters: Mapping[str, object] | None = None
    strict: bool = True

    def simulation(self, n_worlds: int) -> Simulation:
        """Return its worlds, with the agents of its task; without agents where it has no task and no robot can learn.

        Agents matter to levels: each of them has a way to its goal.
        """
        loaded = load_scenario(self.scenario, self.parameters, strict=self.strict)
        chosen: dict[str, Any] = {"task": self.task, "team": self.team, "strict": self.strict}
        try:
            return make_episodes(loaded, n_worlds=n_worlds, **chosen).simulation
        except IrsimGymError:
            if loaded.task or self.task is not None or self.team:
                raise
            return compile(loaded, n_worlds)


def run_draw(wanted: Wanted, splits: Sequence[str], count: int, out: Path) -> LevelSet:
    """Draw levels and write them."""
    check_suffix(out)
    for split in splits:
        check_split(split)
    if len(set(splits)) < len(splits):
        raise IrsimGymError(f"--split: a split is there twice: {','.join(splits)}")
    simulation = wanted.simulation(min(WORLDS, count))
    with bar("drawing", count * len(splits)) as advance:
        drawn = draw_levels(simulation, splits, count, advance)
    write_bytes(out, drawn.content())
    print(f"{out}: {several(drawn.count, 'level')} of {', '.join(splits)}, hash {set_hash(drawn.hashes())}")
    return drawn


def check_suffix(out: Path) -> None:
    """Refuse a name that NumPy would not read.

    Raises:
        IrsimGymError: It does not end in ``.npz``.
    """
    if out.suffix != ".npz":
        raise IrsimGymError(f"a file of levels ends in .npz, got '{out.name}'")


@contextmanager
def bar(words: str, total: int) -> Iterator[Any]:
    """Yield a function that advances a progress bar; only terminals show it."""
    console = Console(stderr=True)
    with Progress(console=console, disable=not console.is_terminal, transient=True) as shown:
        line = shown.add_task(words, total=total)
        yield lambda steps: shown.advance(line, steps)
