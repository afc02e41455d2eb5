"""What ``irsim-gym levels`` does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import Progress

from irsim_gym.engine import Simulation, compile
from irsim_gym.errors import IrsimGymError, several
from irsim_gym.evaluation.behavior_policies import BehaviorPolicy, UnfitBehaviorError
from irsim_gym.evaluation.metrics import OUTCOMES
from irsim_gym.evaluation.policy import Policy
from irsim_gym.evaluation.reference_policies import policy_kinds
from irsim_gym.evaluation.tables import write_bytes
from irsim_gym.levels.certificate import SUFFIX, Certificate
from irsim_gym.levels.certify import certify
from irsim_gym.levels.draw import draw_levels
from irsim_gym.scenario import Scenario, load_scenario
from irsim_gym.scenario.level_checks import with_levels
from irsim_gym.scenario.level_reading import read_levels
from irsim_gym.scenario.level_set import LevelSet, set_hash
from irsim_gym.tasks import Episodes
from irsim_gym.tasks.levels import check_split
from irsim_gym.training.episode_setup import make_episodes
from irsim_gym.training.policies import load_policy

WORLDS = 64
REFERENCES = ("random", "dash", "orca", "dwa", "pursuit")
"""Reference rows of a certificate: at random, straight ahead, by velocity, by a local plan, by the whole map."""


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
        loaded = self.loaded()
        try:
            return self.episodes(n_worlds, loaded).simulation
        except IrsimGymError:
            if loaded.task or self.task is not None or self.team:
                raise
            return compile(loaded, n_worlds)

    def episodes(self, n_worlds: int, loaded: Scenario | None = None) -> Episodes:
        """Return its worlds with its task."""
        chosen: dict[str, Any] = {"task": self.task, "team": self.team, "strict": self.strict}
        return make_episodes(loaded or self.loaded(), n_worlds=n_worlds, **chosen)

    def loaded(self) -> Scenario:
        """Return the scenario; for a file of levels, the one that it names, with these levels.

        Raises:
            IrsimGymError: The file does not name a scenario that is here.
        """
        if Path(self.scenario).suffix != ".npz":
            return load_scenario(self.scenario, self.parameters, strict=self.strict)
        about = read_levels(self.scenario).about
        try:
            drawn = load_scenario(
                str(about["scenario"]), {**about["parameters"], **(self.parameters or {})}, warn=False
            )
        except (KeyError, TypeError, IrsimGymError) as error:
            raise IrsimGymError(
                f"{self.scenario} names no scenario that is here: name a YAML file that has levels: {self.scenario}"
            ) from error
        return with_levels(drawn, read_levels(self.scenario))


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


def run_certify(
    wanted: Wanted, split: str, count: int, policies: Sequence[str] | None, out: Path | None
) -> Certificate:
    """Make a certificate, write it and say what is in it.

    Args:
        wanted: The scenario.
        split: ``train``, ``dev`` or ``test``.
        count: How many levels.
        policies: The reference policies, as ``load_policy`` takes them; None for those that fit.
        out: The file; None for one beside that of the levels, or beside the scenario's in the current folder.
    """
    path = Path(wanted.scenario).with_suffix(SUFFIX) if out is None else out
    check_suffix(path)
    check_split(split)
    episodes = wanted.episodes(min(WORLDS, count))
    chosen = _fitting(episodes) if policies is None else {name: load_policy(name) for name in policies}
    with bar("certifying", count * (1 + len(chosen))) as advance:
        made = certify(episodes, split, count, chosen, advance)
    write_bytes(path, made.content())
    for line in _said(made):
        print(line)
    print(f"{path}: {several(count, 'level')} of {split}, hash {made.set_hash}")
    return made


def _fitting(episodes: Episodes) -> dict[str, Policy]:
    """Return those of the usual reference policies that are there and can drive the agents."""
    fitting: dict[str, Policy] = {}
    for name in (name for name in REFERENCES if name in policy_kinds()):
        policy = load_policy(name)
        try:
            if isinstance(policy, BehaviorPolicy):
                policy.check(episodes)
            fitting[name] = policy
        except UnfitBehaviorError as problem:
            print(f"without {name}: {problem}")
    return fitting


def _said(made: Certificate) -> Iterator[str]:
    """Yield what a certificate says about all levels together."""
    yield f"{made.name}: {100.0 * made.reachable.all(axis=1).mean():.1f} % of {made.count:,} levels are reachable"
    for name in ("length", "clearance", "least_time"):
        low, middle, high = np.nanpercentile(getattr(made, name), (5, 50, 95))
        yield f"  {name:<10} {low:.2f} / {middle:.2f} / {high:.2f}  (5 %, median, 95 %)"
    for policy, outcome in zip(made.policies, made.outcome, strict=True):
        yield f"  {policy:<10} succeeds in {100.0 * (outcome == OUTCOMES.index('success')).mean():.1f} %"


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
