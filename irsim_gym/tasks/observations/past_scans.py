"""Past scans: what the range sensor saw a while ago, as it would be seen from where the agent is now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from irsim_gym.arraytypes import Floats, Ints, Rays
from irsim_gym.engine import Shard, Simulation
from irsim_gym.jit import kernel
from irsim_gym.scenario.options import kind, option
from irsim_gym.structs import Struct
from irsim_gym.tasks.episode_state import EpisodeState
from irsim_gym.tasks.observations.ranges import (
    WITHOUT_SENSOR,
    Code,
    RangeCode,
    code_problems,
    encode,
    range_code,
    shared_sensors,
)
from irsim_gym.tasks.term import Bound, Term
from irsim_gym.tasks.words import Columns, coded, evenly
from irsim_gym.world.model import WorldModel
from irsim_gym.world.state import WorldState

LONGEST = 1000


@dataclass
class Memory(Struct):
    """Earlier scans, and what they were taken with.

    Attributes:
        ranges: Live readings [m], shape ``(n_worlds, n_members, n_beams)``.
        members: Each agent's row in ``ranges``, shape ``(n_agents,)``.
        beams: Directions in the body frame, shape ``(n_agents, 2, n_beams)``.
        mount: Place of the sensor in the body frame [m], shape ``(n_agents, 2)``.
        reach: Radius of the disc that holds the agent [m], shape ``(n_agents,)``.
        far: Greatest range [m], shape ``(n_agents,)``.
        ago: How old the scans are that are shown [steps], shape ``(n_shown,)``.
        scans: The latest scans [m], shape ``(n_worlds, n_agents, n_kept, n_beams)``; a scan's place is the number of
            its step modulo ``n_kept``.
        poses: The poses that they were taken from [m, m, rad], shape ``(n_worlds, n_agents, n_kept, 3)``.
    """

    ranges: Rays
    members: Ints
    beams: Floats
    mount: Floats
    reach: Floats
    far: Rays
    ago: Ints
    scans: Rays
    poses: Floats


@kind
class PastScans:
    """Earlier scans, seen from the agent's current pose: free depth in sectors, encoded as in ``scan``.

    What was hit then is put where it would be seen now, by the way that the agent itself has gone since. What stands
    still therefore reads as in the present scan, and what differs has moved: a policy without memory sees who goes
    where. As long as an episode is younger than that, its first scan is taken.
    """

    only_kernels: ClassVar[bool] = True
    needs_goal: ClassVar[bool] = False
    needs_scan: ClassVar[bool] = True

    ago: tuple[int, ...] = option((3, 6), unit="steps", meaning="Ages of the scans.")
    sectors: int = option(36, ge=1, le=1024, meaning="Number of sectors; the first begins straight behind.")
    code: Code = option("inverse", meaning="How to encode a depth; see scan.")
    near: float = option(
        0.5, gt=0.0, unit="m", meaning="With code inverse, the depth at which the slope is half its maximum."
    )
    zero: float = option(0.3, ge=0.0, unit="1/m", meaning="Code inverse: value of 1 / (m + near) that becomes 0.")
    without_sensor: str | tuple[str, ...] = WITHOUT_SENSOR

    def problems(self) -> list[tuple[str, str]]:
        """Return what is wrong with options that are right one by one: key and message."""
        problems = code_problems(self)
        if not self.ago or not all(1 <= steps <= LONGEST for steps in self.ago):
            problems.append(("ago", f"must be whole numbers from 1 to {LONGEST}, got {list(self.ago)}"))
        return problems

    def arrays(self, simulation: Simulation, agents: Ints) -> Memory:
        """Return the memory."""
        group, members = shared_sensors(simulation, agents, "past_scans")
        table, mounts = group.arrays, [group.options[k] for k in members]
        turned = np.array([table["angles"] + mount.offset[2] for mount in mounts])
        shape = (simulation.n_worlds, len(agents), max(self.ago, default=0) + 1)
        return Memory(
            ranges=table["ranges"],
            members=members,
            beams=np.stack([np.cos(turned), np.sin(turned)], axis=1),
            mount=np.array([mount.offset[:2] for mount in mounts], np.float64),
            reach=simulation.model.reach[:, agents].max(axis=0),
            far=np.array([mount.range_max for mount in mounts], np.float32),
            ago=np.array(self.ago, np.int64),
            scans=np.zeros((*shape, len(table["angles"])), np.float32),
            poses=np.zeros((*shape, 3)),
        )

    def bounds(self, term: Term, model: WorldModel) -> tuple[Rays, Rays]:
        """Return the codes of the greatest depth and of contact."""
        width = self.sectors * len(self.ago)
        far = term.arrays.far.max()
        low, high = np.full(width, far, np.float32), np.zeros(width, np.float32)
        for values in (low, high):
            encode(values, RangeCode.of(self, far))
        return low, high

    def columns(self, term: Term, model: WorldModel, agent: int) -> Sequence[Columns]:
        """Return the sectors of each scan."""
        far = float(term.arrays.far[agent])
        scale = f"d = free depth beyond its reach, as {coded(self, 'd', far)}"
        sectors = evenly(self.sectors)
        return [
            Columns(f"scan of {steps} steps ago, seen from the current pose", scale, self.sectors, sectors)
            for steps in self.ago
        ]

    @staticmethod
    def write(term: Term, model: WorldModel, state: WorldState, episode: EpisodeState, shard: Shard) -> None:
        """Remember the present scan, and write the sectors of earlier ones."""
        note_scans(shard.worlds, term.agents, term.arrays, state, episode)
        write_past(shard.worlds, term.bound, term.arrays, state, episode)


@kernel
def note_scans(worlds: Ints, agents: Ints, memory: Memory, state: WorldState, episode: EpisodeState) -> None:
    """Put each agent's scan, and the pose that it was taken from, in place of the oldest one.

    Reads: memory (members, ranges), state (pose), episode (steps).
    Writes: memory (poses, scans).
    """
    for w in worlds:
        for a in range(agents.shape[0]):
            slot = episode.steps[w, a] % memory.scans.shape[2]
            for k in range(memory.scans.shape[3]):
                memory.scans[w, a, slot, k] = memory.ranges[w, memory.members[a], k]
            for axis in range(3):
                memory.poses[w, a, slot, axis] = state.pose[w, agents[a], axis]


@kernel
def write_past(worlds: Ints, term: Bound, memory: Memory, state: WorldState, episode: EpisodeState) -> None:
    """Write the depths of earlier scans, encoded.

    Reads: term (agents, column, options), memory (ago, beams, far, mount, poses, reach, scans), state (pose), episode
        (observation, steps).
    Writes: episode (observation).
    """
    options, ago = term.options[0], memory.ago
    sectors = options.sectors
    for w in worlds:
        for a in range(term.agents.shape[0]):
            newest, far, now = episode.steps[w, a], memory.far[a], state.pose[w, term.agents[a]]
            for j in range(ago.shape[0]):
                slot = (newest - min(ago[j], newest)) % memory.scans.shape[2]
                column = term.column + j * sectors
                row = episode.observation[w, a, column : column + sectors]
                row[:] = far
                scan, then = memory.scans[w, a, slot], memory.poses[w, a, slot]
                project(scan, then, now, memory.mount[a], memory.beams[a], far, memory.reach[a], row)
                encode(row, range_code(options, far))


@kernel
def project(
    scan: Rays, then: Floats, now: Floats, mount: Floats, beams: Floats, far: np.float32, reach: float, row: Rays
) -> None:
    """Lower the sectors' depths [m] to what a scan shows from another pose.

    Args:
        scan: Ranges [m], ``(n_beams,)``.
        then: Pose of the body when it was taken [m, m, rad].
        now: Pose from which it is looked at.
        mount: Position of the sensor in the body frame [m].
        beams: Directions in the body frame, ``(2, n_beams)``.
        far: Range from which on a beam has met nothing [m].
        reach: Depth 0 [m], measured from the body's origin.
        row: Written, ``(n_sectors,)``; the first sector begins straight behind.
    """
    n_sectors = row.shape[0]
    turn = then[2] - now[2]
    cosine, sine = np.cos(turn), np.sin(turn)
    ahead, left = np.cos(now[2]), np.sin(now[2])
    dx, dy = then[0] - now[0], then[1] - now[1]
    along, aside = ahead * dx + left * dy, ahead * dy - left * dx
    for k in range(scan.shape[0]):
        if scan[k] >= far:
            continue
        x, y = mount[0] + scan[k] * beams[0, k], mount[1] + scan[k] * beams[1, k]
        there_x, there_y = along + cosine * x - sine * y, aside + sine * x + cosine * y
        depth = np.float32(max(np.sqrt(there_x * there_x + there_y * there_y) - reach, 0.0))
        sector = int((np.arctan2(there_y, there_x) / (2.0 * np.pi) + 0.5) * n_sectors) % n_sectors
        row[sector] = min(row[sector], depth)
