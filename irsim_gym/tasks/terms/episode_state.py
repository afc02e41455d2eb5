"""The state of the running episodes."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Rays, Words
from irsim_gym.simulator.world.arrays import Arrays, column

EXTRAS = {
    "shield": "steps of the episode in which the shield has changed the command",
    "cost": "1 in a step with a contact, or nearer to another body than the task's ``near``; else 0",
}
"""What infos of some tasks hold besides, and what it means."""


@dataclass(repr=False)
class EpisodeState(Arrays):
    """The present state of all episodes, beside the ``State``; agents are numbered within a world."""

    together: ClassVar[tuple[tuple[str, ...], ...]] = (
        ("path_length", "min_clearance", "goal_distance", "stalled"),
        ("outcome", "hit", "hit_kind", "steps", "level"),
        ("success", "deadlocked"),
        ("reward_term",),
        ("extra",),
        ("reward",),
        ("terminated", "truncated"),
    )

    base: Words = column("world", np.uint64, "", "key of the split that levels are drawn from, or its first row")
    count: Ints = column("world", np.int64, "", "levels of that split in a file; 0 where they are drawn")
    first_level: Ints = column("world", np.int64, "", "first level of the world's chain of levels")
    episode: Ints = column("world", np.int64, "", "number of the episode in that chain, from 0")
    chosen: Ints = column("world", np.int64, "", "level of the next episode; -1 for the chain's")
    stream: Words = column("world", np.uint64, "", "random stream of the current level, or its row in a file")
    level: Ints = column("world agent", np.int64, "", "level under way")
    given: Floats = column("world agent action", np.float64, "", "continuous action as the learner gave it")
    choice: Ints = column("world agent", np.int64, "", "discrete action as the learner gave it")
    action: Floats = column("world agent action", np.float64, "", "latest action, in [-1, 1]; at rest at the start")
    previous_action: Floats = column("world agent action", np.float64, "", "the action before the latest")
    position: Floats = column("world agent 2", np.float64, "m", "x and y, as last added to the path")
    clearance: Floats = column("world agent", np.float64, "m", "distance to the nearest body, as far as it matters")
    min_clearance: Floats = column("world agent", np.float64, "m", "least clearance so far, the start included")
    path_length: Floats = column("world agent", np.float64, "m", "distance travelled, up to an arrival")
    goal_distance: Floats = column("world agent", np.float64, "m", "distance to the next goal")
    steps: Ints = column("world agent", np.int64, "", "steps taken")
    arrival: Ints = column("world agent", np.int64, "", "step in which it arrived, if ``arrived`` waits; else 0")
    stalled: Floats = column("world agent", np.float64, "s", "time stalled away from its goal")
    deadlocked: Flags = column("world agent", np.bool_, "", "it has been stalled for deadlock_time")
    hit: Ints = column("world agent", np.int64, "", "the touched body (lowest id), -1 for none")
    hit_kind: Ints = column("world agent", np.int64, "", "kind of the touched body, a HitKind")
    outcome: Ints = column("world agent", np.int64, "", "an Outcome")
    success: Flags = column("world agent", np.bool_, "", "the outcome is SUCCESS")
    began: Flags = column("world agent", np.bool_, "", "the agent's episode begins now; its memory is cleared")
    over: Flags = column("world agent", np.bool_, "", "the agent's episode had ended before the latest step")
    ending: Flags = column("world agent ending", np.bool_, "", "which endings apply now")
    terminated: Flags = column("world agent", np.bool_, "", "the task has ended")
    truncated: Flags = column("world agent", np.bool_, "", "the time limit has truncated the episode")
    reward_term: Floats = column("world agent reward", np.float64, "", "weighted reward terms of the latest step")
    extra: Ints = column("world agent extra", np.int64, "", "what this task alone tells, see EXTRAS")
    reward: Floats = column("world agent", np.float64, "", "their sum")
    observation: Rays = column("world agent feature", np.float32, "", "observations of the agents, in [-1, 1]")
