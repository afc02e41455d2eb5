"""What an agent sees.

One file for each observation, named as in YAML, by what it is about.
"""

from irsim_gym.base.families import OBSERVATIONS
from irsim_gym.tasks.observations.bodies.exact_free_travel import ExactFreeTravel
from irsim_gym.tasks.observations.bodies.movable_bodies import MovableBodies
from irsim_gym.tasks.observations.bodies.nearest_bodies import NearestBodies
from irsim_gym.tasks.observations.bodies.neighbors import Neighbors
from irsim_gym.tasks.observations.bodies.time_to_collision import TimeToCollision
from irsim_gym.tasks.observations.goal.goal import Goal
from irsim_gym.tasks.observations.goal.goal_heading import GoalHeading
from irsim_gym.tasks.observations.goal.goal_record import GoalRecord
from irsim_gym.tasks.observations.goal.route import Route
from irsim_gym.tasks.observations.images.occupancy_image import OccupancyImage
from irsim_gym.tasks.observations.images.seen_map_image import SeenMapImage
from irsim_gym.tasks.observations.own.contact import Contact
from irsim_gym.tasks.observations.own.drive import Drive
from irsim_gym.tasks.observations.own.has_arrived import HasArrived
from irsim_gym.tasks.observations.own.heading import Heading
from irsim_gym.tasks.observations.own.last_action import LastAction
from irsim_gym.tasks.observations.own.own_body import OwnBody
from irsim_gym.tasks.observations.own.pending import Pending
from irsim_gym.tasks.observations.own.position import Position
from irsim_gym.tasks.observations.own.trail import Trail
from irsim_gym.tasks.observations.own.velocity import Velocity
from irsim_gym.tasks.observations.scan.free_travel import FreeTravel
from irsim_gym.tasks.observations.scan.past_scans import PastScans
from irsim_gym.tasks.observations.scan.scan import Scan
from irsim_gym.tasks.observations.seen_map.way_on_seen_map import WayOnSeenMap
from irsim_gym.tasks.observations.seen_map.yielding_way import YieldingWay
from irsim_gym.tasks.observations.tracks.time_to_tracks import TimeToTracks
from irsim_gym.tasks.observations.tracks.tracks import Tracks

OBSERVATIONS.register("scan", Scan)
OBSERVATIONS.register("past_scans", PastScans)
OBSERVATIONS.register("way_on_seen_map", WayOnSeenMap)
OBSERVATIONS.register("yielding_way", YieldingWay)
OBSERVATIONS.register("free_travel", FreeTravel)
OBSERVATIONS.register("exact_free_travel", ExactFreeTravel)
OBSERVATIONS.register("time_to_collision", TimeToCollision)
OBSERVATIONS.register("goal", Goal)
OBSERVATIONS.register("goal_heading", GoalHeading)
OBSERVATIONS.register("velocity", Velocity)
OBSERVATIONS.register("last_action", LastAction)
OBSERVATIONS.register("pending", Pending)
OBSERVATIONS.register("drive", Drive)
OBSERVATIONS.register("own_body", OwnBody)
OBSERVATIONS.register("nearest_bodies", NearestBodies)
OBSERVATIONS.register("neighbors", Neighbors)
OBSERVATIONS.register("movable_bodies", MovableBodies)
OBSERVATIONS.register("contact", Contact)
OBSERVATIONS.register("goal_record", GoalRecord)
OBSERVATIONS.register("has_arrived", HasArrived)
OBSERVATIONS.register("route", Route)
OBSERVATIONS.register("trail", Trail)
OBSERVATIONS.register("position", Position)
OBSERVATIONS.register("heading", Heading)
OBSERVATIONS.register("occupancy_image", OccupancyImage)
OBSERVATIONS.register("seen_map_image", SeenMapImage)
OBSERVATIONS.register("tracks", Tracks)
OBSERVATIONS.register("time_to_tracks", TimeToTracks)
