"""What stays constant during an episode."""

from dataclasses import dataclass

import numpy as np

from irsim_gym.base import arraytypes
from irsim_gym.base.arraytypes import Bytes, CellMaps, Cells, Flags, Floats, Ints, Rays, Records, Spans, Words
from irsim_gym.base.kernels.structs import record_type
from irsim_gym.simulator.world.arrays import Arrays, column

ROBOT, OBSTACLE = 0, 1
"""Values of ``role``."""
POSITION, STATE = 0, 1
"""Values of ``arrive_mode``: with STATE, the heading decides about arrival too."""
STOP, UNOBSTRUCTED, UNOBSTRUCTED_OBSTACLES, CONTACT = 0, 1, 2, 3
"""Values of ``collision_mode``: a collision stops all that touch, nobody, robots alone, or nobody, but bodies push."""
KEEP_GOAL, WANDER, LOOP = 0, 1, 2
"""Values of ``goal_renewal``: what happens to goals after arrival."""
NO_DRIVE, DIFFERENTIAL, OMNI_WORLD, OMNI_BODY, OMNI_ANGULAR, ACKERMANN = -1, 0, 1, 2, 3, 4
"""How a body's command reads. OMNI_WORLD takes velocities in the world frame, OMNI_BODY in the body frame."""


WANDERING = record_type("radius jitter chance", keeps_first=np.bool_, interval=np.int64)
"""Where the goals of a wandering body lie [m] (radius 0: between its bounds), whether its first one is given, and every
how many steps it gives up its goal with the probability ``chance`` (0: never).
"""


@dataclass(repr=False)
class Model(Arrays):
    """Constants of the episode, first axis the world (length 1: shared by all worlds).

    Bodies are numbered as IR-SIM numbers its objects: robots first, then obstacles. The outline of
    body ``b`` in its own frame is rows ``segment_start[b]`` to ``segment_start[b] + segment_count[w, b]``
    of ``local_segments``, and likewise for discs.
    """

    bounds: Floats = column("4", np.float64, "m", "world rectangle: x_min, y_min, x_max, y_max")
    step_time: Floats = column("1", np.float64, "s", "duration of a step")
    rigid: Flags = column("1", np.bool_, "", "neither outlines nor maps are drawn anew for each level")
    collision_mode: Ints = column("1", np.int64, "", "STOP, UNOBSTRUCTED, UNOBSTRUCTED_OBSTACLES or CONTACT")
    role: Ints = column("body", np.int64, "", "ROBOT or OBSTACLE")
    movable: Flags = column("body", np.bool_, "", "False for a body that never moves")
    drive: Ints = column("body", np.int64, "", "DIFFERENTIAL to ACKERMANN; NO_DRIVE for any other, and without one")
    wheelbase: Floats = column("body", np.float64, "m", "axle distance; NaN without one")
    driven: Flags = column("body", np.bool_, "", "a behaviour or a learner commands the body")
    stands: Flags = column("body", np.bool_, "", "stays where it starts: it cannot move, or nobody commands it")
    unobstructed: Flags = column("body", np.bool_, "", "ignored by collisions and sensors")
    solid: Flags = column("body", np.bool_, "", "the segments are closed boundaries of an area")
    arrive_mode: Ints = column("body", np.int64, "", "POSITION or STATE")
    has_goal: Flags = column("body", np.bool_, "", "the body has a goal")
    kept_clearance: Floats = column("body", np.float64, "m", "distance that bodies which are placed later keep from it")
    goal_renewal: Ints = column("body", np.int64, "", "KEEP_GOAL, WANDER or LOOP after arrival")
    wander_low: Floats = column("body 3", np.float64, "m, m, rad", "lower bounds of a wandering body's goals")
    wander_high: Floats = column("body 3", np.float64, "m, m, rad", "upper bounds of a wandering body's goals")
    wandering: Records = column("body", WANDERING, "", "where and when a wandering body gets its goals, see WANDERING")
    goal_threshold: Floats = column("world* body", np.float64, "m", "distance under which a goal is reached")
    velocity_min: Floats = column("world* body 3", np.float64, "m/s or rad/s", "lower limits, drive coordinates")
    velocity_max: Floats = column("world* body 3", np.float64, "m/s or rad/s", "upper limits, drive coordinates")
    speed_bound: Flags = column("body", np.bool_, "", "the first of velocity_max bounds the speed in any direction too")
    drawn_speed: Floats = column("world* body", np.float64, "m/s", "greatest speed drawn for the level; inf: none")
    heedless: Flags = column("world* body", np.bool_, "", "its behaviour ignores what moves")
    leader: Ints = column("body", np.int64, "", "first body of those that walk together with it; itself if it is alone")
    abreast: Floats = column("body", np.float64, "m", "how far to the left of its leader it walks")
    watchers: Flags = column("watching body", np.bool_, "", "whose behaviour sees the bodies with this row; row 0: all")
    seen_row: Ints = column("body", np.int64, "", "row of watchers that says whose behaviour sees the body")
    acceleration_limit: Floats = column("world* body 3", np.float64, "m/s2 or rad/s2", "largest change; may be inf")
    heading_low: Floats = column("body", np.float64, "rad", "low end of the full turn that headings wrap into")
    segment_start: Ints = column("body", np.int64, "", "first row of the body's segments")
    segment_count: Ints = column("world* body", np.int64, "", "number of the body's segments")
    local_segments: Floats = column("world* segment 4", np.float64, "m", "x0, y0, x1, y1 in the body frame")
    disc_start: Ints = column("body", np.int64, "", "first row of the body's discs")
    disc_count: Ints = column("world* body", np.int64, "", "number of the body's discs")
    local_discs: Floats = column("world* disc 3", np.float64, "m", "x, y, radius in the body frame")
    reach: Floats = column("world* body", np.float64, "m", "radius about the body's origin that holds its footprint")
    radius: Floats = column("world* body", np.float64, "m", "radius of the least circle around the footprint")
    centroid: Floats = column("world* body 2", np.float64, "m", "centre of the footprint's area, in the body frame")
    map_frame: Records = column("1", arraytypes.MAP_FRAME, "m", "where the occupancy map lies; body -1: no map")
    map_squares: Bytes = column("world* 4 map_column map_row", np.uint8, "", "free square by quadrant; 0: occupied")
    map_room: Rays = column("world* map_column map_row", np.float32, "m", "distance of cell centres from the occupied")
    map_boxes: Spans = column("world* map_box 4", np.int32, "", "what is occupied: first, end column; first, end row")
    map_n_boxes: Ints = column("world*", np.int64, "", "how many of these boxes count")
    map_disc: Floats = column("1", np.float64, "m", "radius of the disc that stands for an occupied cell; 0: all of it")
    bucket_frame: Records = column("1", arraytypes.BUCKET_FRAME, "m", "where the buckets' squares lie; columns 0: none")
    bucketed: Flags = column("body", np.bool_, "", "small enough to be found through the buckets")
    present: Flags = column("world body", np.bool_, "", "the body exists in this episode")
    level_stream: Words = column("world", np.uint64, "", "random stream that the level was drawn from, or row in file")
    altered: Flags = column("world", np.bool_, "", "bodies have vanished or begun anew since the level was drawn")
    level_random: Words = column("world", np.uint64, "", "state of the random stream when the level was drawn")
    initial_steering: Floats = column("body", np.float64, "rad", "steering angle at the start")
    initial_velocity: Floats = column("body 3", np.float64, "m/s or rad/s", "velocity at the start")
    start: Floats = column("world body 3", np.float64, "m, m, rad", "pose at the start")
    waypoints: Floats = column("world body waypoint 3", np.float64, "m, m, rad", "goals in order; NaN heading: any")
    waypoint_count: Ints = column("world body", np.int64, "", "number of goals")
    drawn_goals: Ints = column("body", np.int64, "", "goals that each level draws for the body; 0: none")
    static_partner: Ints = column("world body", np.int64, "", "a static body that a static body touches, -1 for none")
    static_pose: Floats = column("world body 3", np.float64, "m, m, rad", "where it stood then; inf where absent")
    static_known: Flags = column("world", np.bool_, "", "static contacts were found, and none has to be found anew")

    @property
    def cells(self) -> Cells:
        """The occupancy maps of all worlds; None without one."""
        x, y, width, height, body = self.map_frame.item()
        arrays = self.map_squares, self.map_boxes, self.map_n_boxes, self.map_room, float(self.map_disc[0])
        return CellMaps(x, y, width, height, body, *arrays) if body >= 0 else None
