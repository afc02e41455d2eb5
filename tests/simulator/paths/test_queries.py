import numpy as np
import pytest

from irsim_gym.simulator.cell_paths.queries import free_path, free_path_length, has_free_path, standing_bodies
from irsim_gym.simulator.world.model import Model
from irsim_gym.simulator.world.state import State

RADIUS, START, GOAL = 0.2, (1.0, 3.0), (5.0, 3.0)


def worlds(*, per_world: frozenset[str]) -> tuple[Model, State]:
    """Return two worlds of 6 x 6 m: a robot, a wall with a way around it and a disc, absent from world 1."""
    sizes = {
        "world": 2,
        "body": 3,
        "segment": 2,
        "disc": 1,
        "waypoint": 1,
        "bucket": 1,
        "map_column": 1,
        "map_row": 1,
        "map_box": 1,
        "watching": 1,
    }
    model, state = Model.allocate(sizes, per_world=per_world), State.allocate(sizes)
    model.bounds[:] = [0.0, 0.0, 6.0, 6.0]
    model.movable[0] = True
    model.stands[:] = ~model.movable
    model.present[:] = True
    model.present[1, 2] = False
    model.segment_start[:], model.segment_count[:] = [0, 0, 2], [0, 2, 0]
    model.disc_start[:], model.disc_count[:] = [0, 0, 0], [0, 0, 1]
    state.segments[:, 0], state.segments[:, 1] = [3.0, -1.0, 3.0, 2.0], [3.0, 2.0, 3.0, 4.0]
    state.discs[:, 0] = [3.0, 4.0, 1.0]
    return model, state


@pytest.mark.parametrize("per_world", [frozenset[str](), frozenset({"segment_count", "disc_count"})])
def test_each_world_has_its_own_bodies(per_world: frozenset[str]) -> None:
    model, state = worlds(per_world=per_world)
    assert standing_bodies(model, 0).tolist() == [False, True, True]
    assert standing_bodies(model, 1).tolist() == [False, True, False]
    around_disc = free_path_length(model, state, 0, RADIUS, START, GOAL)
    around_wall = free_path_length(model, state, 1, RADIUS, START, GOAL)
    assert 2.0 * np.hypot(2.0, 1.0) < around_wall < around_disc < 7.5
    path = free_path(model, state, 1, RADIUS, START, GOAL)
    assert path[0].tolist() == list(START)
    assert path[-1].tolist() == list(GOAL)
    assert path[:, 1].max() > 4.0 + 0.9 * RADIUS


def test_what_is_in_the_way_can_be_chosen() -> None:
    model, state = worlds(per_world=frozenset())
    nothing = np.zeros(3, np.bool_)
    assert free_path_length(model, state, 0, RADIUS, START, GOAL, blocks=nothing) == 4.0
    model.unobstructed[1:] = True
    assert free_path(model, state, 0, RADIUS, START, GOAL).tolist() == [list(START), list(GOAL)]


def test_no_way() -> None:
    model, state = worlds(per_world=frozenset())
    state.segments[1, 1, 3] = 7.0
    assert has_free_path(model, state, 0, RADIUS, START, GOAL)
    assert not has_free_path(model, state, 1, RADIUS, START, GOAL)
    assert free_path_length(model, state, 1, RADIUS, START, GOAL) == np.inf
    assert free_path(model, state, 1, RADIUS, START, GOAL).shape == (0, 2)
    assert not has_free_path(model, state, 0, 2.0, START, GOAL)
