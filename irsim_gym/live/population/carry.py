"""Recompiles a world whose list of bodies changes, and keeps everything else."""

import numpy as np

from irsim_gym.base.arraytypes import Ints
from irsim_gym.base.errors import PlacementError
from irsim_gym.live.session.goal_writer import make_room
from irsim_gym.scenario import Scenario
from irsim_gym.simulator.contact import body_buckets, contact
from irsim_gym.simulator.engine import Simulation, compile
from irsim_gym.simulator.levels import body_measures
from irsim_gym.simulator.levels.traits import draw_traits
from irsim_gym.simulator.step import arrival, restart
from irsim_gym.simulator.step.step import sense
from irsim_gym.simulator.world.group import Shard
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State

HOLD_INDICES = ("segment_start", "disc_start", "static_partner", "bucketed", "bucket", "bucket_next", "hit")
NOT_CARRIED = frozenset({*HOLD_INDICES, "nearby", "radius", "centroid", "watchers", "seen_row", "leader", "abreast"})
"""Fields of bodies that are computed again: rows, bodies or buckets, and those that not every world needs."""

START_TRIES = 20


def rebuild(old: Simulation, scenario: Scenario) -> Simulation:
    """Return a simulation of the changed list of bodies at the same moment.

    Bodies are identified by name. Remaining ones keep their state and their part of the level, and the world keeps its
    clock and its random stream. New bodies start where their entry says. Random starts are drawn from that stream,
    clear of the present places of all others.

    Raises:
        PlacementError: A new body found no place.
    """
    new = compile(scenario, check_starts=False)
    before = {name: b for b, name in enumerate(old.parts.names)}
    here = np.array([b for b, name in enumerate(new.parts.names) if name in before], np.int64)
    there = np.array([before[new.parts.names[b]] for b in here], np.int64)
    make_room(new.model, old.model.waypoints.shape[2])
    added = np.setdiff1d(new.parts.everyone, here)
    body_buckets.empty(new.model, new.state, Shard(np.zeros(1, np.int64)))
    _carry(old, new, here, there)
    if len(added):
        # Both write fields of all members of a kind: what the remaining bodies had is copied over them once more.
        _draw(new, added)
        _begin(new, added)
        random = new.state.random.copy()
        _carry(old, new, here, there)
        new.state.random[:] = random
    if len(new.parts.measured):
        body_measures.measure(np.zeros(1, np.int64), new.parts.measured, new.model)
    _look(old, new, here, there)
    return new


def _carry(old: Simulation, new: Simulation, here: Ints, there: Ints) -> None:
    """Copy the state of remaining bodies, and of the world, from the old simulation."""
    for name, declared in (*Model.columns().items(), *State.columns().items()):
        sources, targets = (old.model, new.model) if name in Model.columns() else (old.state, new.state)
        source, target = getattr(sources, name), getattr(targets, name)
        if declared.axes == ("world",):
            target[:] = source
        elif "body" in declared.axes and name not in NOT_CARRIED:
            axis = declared.axes.index("body")
            source, target = np.moveaxis(source, axis, 0), np.moveaxis(target, axis, 0)
            # Other axes may differ in length, as the number of goals does: what both have is copied.
            shared = tuple(slice(0, min(lengths)) for lengths in zip(source.shape[1:], target.shape[1:], strict=True))
            target[(here, *shared)] = source[(there, *shared)]
    for table, start, count in (
        ("local_segments", "segment_start", "segment_count"),
        ("local_discs", "disc_start", "disc_count"),
    ):
        for b, was in zip(here, there, strict=True):
            rows = int(getattr(old.model, count)[0, was])
            first, target = int(getattr(old.model, start)[was]), int(getattr(new.model, start)[b])
            getattr(new.model, table)[:, target : target + rows] = getattr(old.model, table)[:, first : first + rows]
    if old.parts.pushing is not None and new.parts.pushing is not None:
        for name in ("drive", "felt"):
            getattr(new.parts.pushing, name)[0, here] = getattr(old.parts.pushing, name)[0, there]
    _carry_map(old, new)
    _carry_fog(old, new)
    _carry_memories(old, new, dict(zip(here.tolist(), there.tolist(), strict=True)))
    new.state.placed[0, here] = True
    new.parts.goal_bodies = np.flatnonzero(new.model.has_goal)
    new.parts.loop_returns = np.concatenate(
        [np.setdiff1d(new.parts.loop_returns, here), here[np.isin(there, old.parts.loop_returns)]]
    )
    new.place(here)


def _carry_map(old: Simulation, new: Simulation) -> None:
    """Copy the map, which may be that of the level."""
    before, now = old.model.cells, new.model.cells
    if before is not None and now is not None:
        for field in ("squares", "boxes", "n_boxes", "room"):
            getattr(now, field)[:] = getattr(before, field)


def _carry_fog(old: Simulation, new: Simulation) -> None:
    """Copy what was explored, unless the cells have changed with the map."""
    before, now = old.explored, new.explored
    if before is not None and now is not None and before.shape == now.shape:
        now[:] = before


def _carry_memories(old: Simulation, new: Simulation, was_at: dict[int, int]) -> None:
    """Hand over the memories of kinds that are written as functions."""
    for group in new.parts.remembering:
        for source in old.parts.remembering:
            if source.kind is group.kind:
                for b in map(int, group.members):
                    if was_at.get(b) in source.members:
                        group.arrays["memory"][0, b] = source.arrays["memory"][0, was_at[b]]


def _draw(new: Simulation, added: Ints) -> None:
    """Draw the outlines and starts of new bodies.

    Raises:
        PlacementError: One of them found no place.
    """
    parts, model, state, shard = new.parts, new.model, new.state, Shard(np.zeros(1, np.int64))
    failed = np.zeros(1, np.int64)
    for _ in range(START_TRIES):
        failed[0] = 0
        state.placed[0, added] = False
        draw_traits(shard.worlds, parts.traits[np.isin(parts.traits["body"], added)], model, state)
        for group in parts.footprints:
            chosen = np.flatnonzero(np.isin(group.members, added))
            if len(chosen):
                group.kind.draw(group.select(chosen), model, state, shard)
        for group in parts.placements:
            if np.isin(group.members, added).any():
                group.kind.draw(group, model, state, shard, failed)
                new.place(group.members)
        if failed[0] == 0:
            return
    raise PlacementError(f"no place found for {parts.places[failed[0] - 1]} among the bodies that are here")


def _begin(new: Simulation, added: Ints) -> None:
    """Begin the episode for new bodies: velocities, and first goals, which only they draw."""
    parts, model, state, shard = new.parts, new.model, new.state, Shard(np.zeros(1, np.int64))
    parts.goal_bodies = np.intersect1d(parts.goal_bodies, added)
    body_buckets.empty(model, state, shard)
    body_buckets.refresh(parts.everyone, model, state, shard)
    restart.begin_moment(parts, model, state, shard)
    for group in parts.kinematics:
        group.kind.begin(group, model, state, shard)
    arrival.measure_distance(shard.worlds, parts.goal_bodies, state)


def _look(old: Simulation, new: Simulation, here: Ints, there: Ints) -> None:
    """Update contacts and readings. The next step updates which bodies are held in place."""
    shard, state = Shard(np.zeros(1, np.int64)), new.state
    now_at = {int(was): int(b) for b, was in zip(here, there, strict=True)}
    new.model.static_known[:] = False
    contact.find_static(new.parts.fixed, new.model, state, shard)
    state.collided[0], state.hit[0] = new.model.static_partner[0] >= 0, new.model.static_partner[0]
    for b, was in zip(here, there, strict=True):
        partner = now_at.get(int(old.state.hit[0, was]), -1)
        state.collided[0, b], state.hit[0, b] = bool(old.state.collided[0, was]), partner
    sense(new.parts, new.model, state, shard)
