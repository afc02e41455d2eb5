"""What changes with every step."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base.arraytypes import Flags, Floats, Ints, Records, Words
from irsim_gym.simulator.world.arrays import Arrays, column

ROOM = np.dtype((np.record, [("x", np.float64), ("y", np.float64), ("gap", np.float64)]))
"""Where a disc was, and how far from its edge nothing was [m]; ``gap`` is 0 where that is unknown."""


@dataclass(repr=False)
class State(Arrays):
    """The moment in every world; one phase of the step writes each field."""

    time: Floats = column("world", np.float64, "s", "elapsed time")
    step: Ints = column("world", np.int64, "", "steps since the start")
    random: Words = column("world", np.uint64, "", "state of the world's random stream")
    pose: Floats = column("world body 3", np.float64, "m, m, rad", "x, y, heading")
    direction: Floats = column(
        "world body 3", np.float64, "-, -, rad", "cosine and sine of a heading, and that heading; see ``angles.turned``"
    )
    steering: Floats = column("world body", np.float64, "rad", "front wheel angle of an Ackermann drive")
    command: Floats = column("world body 3", np.float64, "m/s or rad/s", "what is asked of the drive")
    velocity: Floats = column("world body 3", np.float64, "m/s or rad/s", "what is executed, drive coordinates")
    twist: Floats = column("world body 3", np.float64, "m/s, m/s, rad/s", "velocity in the world frame")
    plan: Floats = column("world body 2", np.float64, "m/s, m/s", "world-frame velocity last chosen in its group")
    segments: Floats = column("world segment 4", np.float64, "m", "outline: x0, y0, x1, y1 in the world frame")
    discs: Floats = column("world disc 3", np.float64, "m", "outline: x, y, radius in the world frame")
    goal: Floats = column("world body 3", np.float64, "m, m, rad", "the goal that is next")
    waypoint: Ints = column("world body", np.int64, "", "index of that goal in model.waypoints")
    waypoint_end: Ints = column("world body", np.int64, "", "number of goals in the present round")
    goal_distance: Floats = column("world body", np.float64, "m", "distance to the goal")
    arrived: Flags = column("world body", np.bool_, "", "within goal_threshold of the last goal")
    collided: Flags = column("world body", np.bool_, "", "touches another body")
    stopped: Flags = column("world body", np.bool_, "", "held in place by a collision")
    hit: Ints = column("world body", np.int64, "", "the body it touches (lowest id), -1 for none")
    room: Records = column("world body", ROOM, "m", "free space around a disc, see ROOM")
    bucket: Ints = column("world body", np.int64, "", "the bucket that the body is in, -1 for none")
    bucket_first: Ints = column("world bucket", np.int64, "", "first body of each bucket, -1 for none")
    bucket_next: Ints = column("world body", np.int64, "", "next body of the same bucket, -1 for none")
    nearby: Ints = column("world body", np.int64, "", "scratch: the bodies in the buckets around one")
    placed: Flags = column("world body", np.bool_, "", "has its start; False only while a level is drawn")
    failed: Ints = column("world", np.int64, "", "body + 1 that found no place in the level as it was drawn, else 0")
