"""What differs between crowd_nav and CrowdNav++ while an episode runs, each difference measured alone.

    python agents/studies/crowd_nav_differences.py      # takes its rows into results/crowd_benchmarks.json
    python agents/studies/crowd_nav_differences.py --only restart_sight restart_belief --scenario crowd_nav_code.yaml

crowd_nav_code.yaml is a copy of crowd_nav.yaml with levels of crowd_nav_levels.py.

- restart: a person that arrives begins anew on the circle, with the goal opposite. In crowd_nav it walks on from where
  it is, to a goal elsewhere on the circle.
- sight: the robot sees people up to a gap of 5 m, and forgets those who are farther away. In crowd_nav it sees 10 m.
- belief: the same, but those whom it no longer sees it believes to walk on as they did last, for ever. Measured for the
  social-force robot, whose forces are worked out here by the formula of Helbing and Molnar (1995) in its circular form.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import irsim_gym
from irsim_gym.evaluation import Policy, conditions, machine, make_episodes, plain, reference_policy, to_actions
from irsim_gym.plugins import Shard
from irsim_gym.tasks import Episodes

Floats, Ints = NDArray[np.float64], NDArray[np.int64]

RESULTS = Path(__file__).parents[1] / "results" / "crowd_benchmarks.json"
SIGHT = 5.0 + 0.3 + 0.3
"""Between centres [m]: a gap of 5 m, the radius of the robot and that of a person."""
SOCIAL, RANGE, FASTEST = 2.0, 1.0, 1.0
"""Of the social-force robot: weight of a push, gap over which it fades [m], greatest speed [m/s]."""


class Restarting:
    """A policy in worlds where people who arrive begin anew, with the goal opposite.

    Args:
        policy: What drives the robot.
    """

    def __init__(self, policy: Policy) -> None:
        self.policy = policy
        self._goals: Floats = np.zeros((0, 0, 2))

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Take note of the goals."""
        self.policy.begin(episodes, worlds, levels)
        goals = episodes.simulation.state.goal[..., :2]
        if self._goals.shape != goals.shape:
            self._goals = goals.copy()
        self._goals[worlds] = goals[worlds]

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64]:
        """Let those begin anew who have got another goal, which only an arrival gives; return the robot's actions."""
        simulation = episodes.simulation
        people, goals = people_of(episodes), simulation.state.goal[..., :2]
        arrived = np.zeros((episodes.n_worlds, len(people)), np.bool_)
        arrived[worlds] = (goals[worlds] != self._goals[worlds]).any(axis=-1)[:, people]
        if arrived.any():
            simulation.respawn(Shard(np.flatnonzero(arrived.any(axis=1))), people, arrived)
        self._goals[worlds] = goals[worlds]
        return self.policy.act(episodes, worlds)


class Believing:
    """The social-force robot with a sight of 5 m, which believes that those out of sight walk on.

    Args:
        sight: How far it sees, from centre to centre [m].
    """

    def __init__(self, sight: float = SIGHT) -> None:
        self.sight = sight
        self._place: Floats = np.zeros((0, 0, 2))
        self._speed: Floats = np.zeros((0, 0, 2))

    def begin(self, episodes: Episodes, worlds: Ints, levels: Ints) -> None:
        """Forget whom it has seen: those who were never seen are far away."""
        shape = episodes.n_worlds, len(people_of(episodes)), 2
        if self._place.shape != shape:
            self._place, self._speed = np.zeros(shape), np.zeros(shape)
        self._place[worlds], self._speed[worlds] = 15.0, 0.0
        self._look(episodes, worlds)

    def _look(self, episodes: Episodes, worlds: Ints) -> None:
        """Take over who is in sight."""
        state, people = episodes.simulation.state, people_of(episodes)
        place, speed = state.pose[worlds][:, people, :2], state.twist[worlds][:, people, :2]
        robot = state.pose[worlds, episodes.simulation.agents[0], None, :2]
        seen = np.linalg.norm(place - robot, axis=-1, keepdims=True) <= self.sight
        self._place[worlds] = np.where(seen, place, self._place[worlds])
        self._speed[worlds] = np.where(seen, speed, self._speed[worlds])

    def act(self, episodes: Episodes, worlds: Ints) -> NDArray[np.float64]:
        """Return the actions that ask for the velocity that the forces lead to."""
        model, state, robot = episodes.simulation.model, episodes.simulation.state, episodes.simulation.agents[0]
        dt = float(model.step_time[0])
        fresh = state.time[worlds] > 0.0
        self._place[worlds[fresh]] += self._speed[worlds[fresh]] * dt
        self._look(episodes, worlds)
        place, velocity = state.pose[worlds, robot, :2], state.twist[worlds, robot, :2]
        away = place[:, None] - self._place[worlds]
        distance = np.linalg.norm(away, axis=-1, keepdims=True)
        push = SOCIAL * np.exp((SIGHT - 5.0 - distance) / RANGE) * away / distance
        ahead = state.goal[worlds, robot, :2] - place
        wanted = FASTEST * ahead / np.linalg.norm(ahead, axis=-1, keepdims=True)
        after = velocity + (wanted - velocity + push.sum(axis=1)) * dt
        speed = np.linalg.norm(after, axis=-1, keepdims=True)
        return to_actions(episodes, worlds, (after * np.minimum(FASTEST / speed, 1.0))[:, None])


def people_of(episodes: Episodes) -> Ints:
    """Return the bodies that are no agents."""
    return np.setdiff1d(np.arange(episodes.simulation.model.present.shape[1]), episodes.simulation.agents)


def variants() -> dict[str, dict[str, Policy | str]]:
    """Return who plays, by difference."""
    near = {"orca": f"orca:neighborDist={SIGHT}", "sfm": f"sfm:neighbor_threshold={SIGHT}"}
    return {
        "restart": {name: Restarting(reference_policy(name)) for name in ("orca", "sfm")},
        "sight": dict(near),
        "belief": {"sfm": Believing(), "sfm that sees all": Believing(np.inf)},
        "restart_sight": {name: Restarting(reference_policy(source)) for name, source in near.items()},
        "restart_belief": {"sfm": Restarting(Believing())},
    }


def main() -> None:
    """Play all differences, or those that are named, and keep their rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="*", choices=tuple(variants()), default=tuple(variants()))
    parser.add_argument("--scenario", default="crowd_nav", help="crowd_nav, or a copy with levels from a file")
    parser.add_argument("--levels", type=int, default=500)
    parser.add_argument("--results", type=Path, default=RESULTS)
    given = parser.parse_args()
    for name in given.only:
        found = irsim_gym.evaluate(given.scenario, variants()[name], levels=given.levels, references=False)
        print(found)
        named = conditions(make_episodes(given.scenario), found.split, given.levels) | found.level_set.conditions()
        rows = json.loads(given.results.read_text(encoding="utf-8"))
        asked = f"--only {name} --levels {given.levels} --scenario {given.scenario}"
        command = f"python agents/studies/crowd_nav_differences.py {asked}"
        figures = {"command": command, "conditions": named, "machine": machine(), "policies": found.summaries}
        rows[f"{Path(given.scenario).stem}_{name}"] = plain(figures)
        given.results.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
