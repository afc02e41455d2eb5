"""Random levels: nothing overlaps, goals can be reached, and a full world says so."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig
from irsim_gym.errors import PlacementError, ScenarioError
from irsim_gym.simulator.contact import body_buckets
from irsim_gym.simulator.geometry.buckets import gather_nearby

N_WORLDS = 40


def geometry(sim: Any, w: int, b: int) -> shapely.Geometry:
    model, state = sim.model, sim.state
    discs = state.discs[w, model.disc_start[b] :][: model.disc_count[w % len(model.disc_count), b]]
    if len(discs):
        return shapely.Point(*discs[0, :2]).buffer(discs[0, 2], quad_segs=64)
    rows = state.segments[w, model.segment_start[b] :][: model.segment_count[w % len(model.segment_count), b]]
    return shapely.Polygon(rows[:, :2]) if model.solid[b] else shapely.LineString([rows[0, :2], *rows[:, 2:]])


@pytest.fixture(scope="module", params=["cluttered_room", "dense_room"])
def rooms(request: pytest.FixtureRequest) -> Any:
    sim = ig.compile(ig.load_scenario(request.param), N_WORLDS)
    sim.reset(seed=7)
    return sim


def test_nothing_overlaps(rooms: Any) -> None:
    for w in range(N_WORLDS):
        shapes = [geometry(rooms, w, b) for b in np.flatnonzero(rooms.model.present[w])]
        for i, shape in enumerate(shapes):
            assert shape.is_valid
            assert not any(shape.intersects(other) for other in shapes[i + 1 :])


def test_number_ranges_are_kept_and_used(rooms: Any) -> None:
    low, high = (8, 10) if rooms.scenario.name == "cluttered_room" else (16, 18)
    counts = rooms.model.present.sum(axis=1) - 2
    assert set(counts) <= set(range(low, high + 1))
    assert len(set(counts)) == high - low + 1


def test_bodies_that_are_placed_later_keep_the_clearance_of_earlier_ones() -> None:
    posts = [
        {"number": 4, "shape": {"name": "circle", "radius": 0.3}, "distribution": {"name": "random", "clearance": 0.6}},
        {
            "number": 9,
            "shape": {"name": "circle", "radius": 0.3},
            "distribution": {"name": "random", "min_distance": 0},
        },
    ]
    sim = ig.compile(ig.load_scenario({"world": {"width": 9, "height": 9}, "obstacle": posts}), N_WORLDS)
    sim.reset(seed=1)
    places = sim.state.pose[:, :, :2]
    gaps = np.linalg.norm(places[:, :, None] - places[:, None], axis=-1) - 0.6
    later = gaps[:, 4:, 4:][:, *np.triu_indices(9, 1)]
    assert gaps[:, :4, 4:].min() >= 0.6
    assert 0.0 <= later.min() < 0.1


def test_goals_are_far_free_and_reachable(rooms: Any) -> None:
    for w in range(N_WORLDS):
        start, goal = rooms.state.pose[w, 0, :2], rooms.state.goal[w, 0, :2]
        assert np.linalg.norm(goal - start) >= 4.0
        obstacles = [geometry(rooms, w, b) for b in np.flatnonzero(rooms.model.present[w]) if b > 0]
        assert min(shapely.Point(goal).distance(shape) for shape in obstacles) >= 0.2
        free = shapely.box(0, 0, 10, 10).difference(shapely.union_all([s.buffer(0.2, quad_segs=64) for s in obstacles]))
        parts = shapely.get_parts(free)
        assert any(part.contains(shapely.Point(start)) and part.contains(shapely.Point(goal)) for part in parts)


def boxes(count: int, **distribution: Any) -> dict[str, Any]:
    shape = {"name": "rectangle", "length": 2, "width": 2}
    return {"number": count, "shape": shape, "distribution": {"name": "random", "min_distance": 0, **distribution}}


def test_a_world_too_full_names_the_body() -> None:
    sim = ig.compile(ig.load_scenario({"world": {"width": 5, "height": 5}, "obstacle": [boxes(30)]}))
    with pytest.raises(PlacementError, match="no place found for 'obstacle_"):
        sim.reset()


def test_an_unreachable_goal_is_never_handed_out() -> None:
    walls = {"shape": {"name": "linestring", "vertices": [[5, 0], [5, 10]]}}
    robot = {
        "kinematics": {"name": "diff"},
        "distribution": {"name": "random", "min_goal_distance": 3, "reachable": True},
    }
    sim = ig.compile(ig.load_scenario({"robot": robot, "obstacle": [walls]}), 64)
    sim.reset()
    sides = np.sign(sim.state.pose[:, 0, 0] - 5), np.sign(sim.state.goal[:, 0, 0] - 5)
    np.testing.assert_array_equal(*sides)


def test_spacing_and_clearance_are_kept() -> None:
    sim = ig.compile(ig.load_scenario({"obstacle": [boxes(4, min_distance=3.5, clearance=0.4)]}), 20)
    sim.reset(seed=3)
    for w in range(20):
        shapes = [geometry(sim, w, b) for b in range(4)]
        for i in range(4):
            for j in range(i):
                assert shapes[i].distance(shapes[j]) >= 0.4
                assert np.linalg.norm(sim.state.pose[w, i, :2] - sim.state.pose[w, j, :2]) >= 3.5


def crossing(**bounds: Any) -> dict[str, Any]:
    place = {"name": "random", "range_low": [0.5, 0.5, 0], "range_high": [3, 9.5, 1], "min_distance": 0.8, **bounds}
    return {"robot": {"number": 4, "kinematics": {"name": "diff"}, "distribution": place}}


def test_goals_may_have_bounds_of_their_own() -> None:
    bounds = {"goal_low": [7, 1, -1], "goal_high": [9.5, 4, 0]}
    sim = ig.compile(ig.load_scenario(crossing(**bounds)), 30)
    sim.reset(seed=2)
    for points, low, high in ((sim.state.pose, [0.5, 0.5, 0], [3, 9.5, 1]), (sim.state.goal, [7, 1, -1], [9.5, 4, 0])):
        assert (points >= low).all()
        assert (points <= high).all()
        assert (np.ptp(points, axis=(0, 1)) > 0.8 * (np.array(high) - low)).all()
        for one in points[:, :, :2]:
            assert min(np.linalg.norm(one[i] - one[j]) for i in range(4) for j in range(i)) >= 0.8


@pytest.mark.parametrize(
    ("bounds", "said"),
    [
        ({"goal_low": [7, 1, 0], "goal_high": [6, 4, 0]}, r"distribution\.goal_low: must not exceed goal_high"),
        ({"goal_low": [7, 1, 0]}, r"goal_low \[7.0, 1.0, 0.0\] exceeds goal_high \[3.0, .*is that of the starts"),
    ],
)
def test_bounds_of_goals_are_the_right_way_round(bounds: dict[str, Any], said: str) -> None:
    with pytest.raises(ScenarioError, match=said):
        ig.compile(ig.load_scenario(crossing(**bounds)))


def test_random_obstacles_keep_clear_of_a_given_start_and_goal() -> None:
    robot = {"kinematics": {"name": "diff"}, "state": [2, 2, 0], "goal": [8, 8, 0]}
    sim = ig.compile(ig.load_scenario({"robot": robot, "obstacle": [boxes(6)]}), 30)
    sim.reset()
    for w in range(30):
        for b in range(1, 7):
            shape = geometry(sim, w, b)
            assert shape.distance(shapely.Point(2, 2)) > 0.2
            assert shape.distance(shapely.Point(8, 8)) >= 0.2


def test_circle_faces_the_centre_with_opposite_goals() -> None:
    robots = {"number": 4, "kinematics": {"name": "diff"}, "distribution": {"name": "circle", "radius": 3}}
    sim = ig.compile(ig.load_scenario({"robot": robots}))
    sim.reset()
    assert sim.state.pose[0, :, :2] == pytest.approx(np.array([[8, 5], [5, 8], [2, 5], [5, 2]]))
    assert sim.state.goal[0, :, :2] == pytest.approx(np.array([[2, 5], [5, 2], [8, 5], [5, 8]]))
    toward = np.array([5, 5]) - sim.state.pose[0, :, :2]
    heading = sim.state.pose[0, :, 2]
    facing = toward[:, 0] * np.cos(heading) + toward[:, 1] * np.sin(heading)
    assert facing == pytest.approx(np.full(4, 3.0))


def test_one_world_does_not_remember_outlines_of_other_levels() -> None:
    """An obstacle of another size at the same place leaves other ways, also where there is but one world."""
    gate = {"name": "circle", "random_shape": True, "radius_range": [0.2, 3.5]}
    robot = crossing(reachable=True, goal_low=[7, 0.5, 0], goal_high=[9.5, 9.5, 0])["robot"]
    walls = [
        {"shape": {"name": "rectangle", "length": 0.5, "width": 6}, "state": [5, 2.6, 0]},
        {"shape": gate, "state": [5, 8, 0]},
    ]
    one, two = (ig.compile(ig.load_scenario({"robot": robot, "obstacle": walls}), n) for n in (1, 2))
    for seed in range(15):
        one.reset(seed)
        two.reset(seed)
        assert one.state.pose[0].tolist() == two.state.pose[0].tolist()


def test_a_distance_that_nobody_asked_for_is_given_up_where_there_is_no_room() -> None:
    """Some 45 discs 1 m apart fit into 8 m x 8 m, 80 do not; those of a file that IR-SIM runs are so many."""
    entry = {"number": 80, "shape": {"name": "circle", "radius": 0.1}}
    spread = {"name": "random", "range_low": [1, 1, -3.14], "range_high": [9, 9, 3.14]}
    sim = ig.compile(ig.load_scenario({"obstacle": [{**entry, "distribution": spread}]}), 3)
    sim.reset(seed=0)
    for places in sim.state.pose[:, :, :2]:
        apart = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(80, 1)]
        assert (apart >= 0.2).all()
    with pytest.raises(PlacementError, match="min_distance"):
        ig.compile(ig.load_scenario({"obstacle": [{**entry, "distribution": {**spread, "min_distance": 1}}]})).reset(
            seed=0
        )


def crowded(n_obstacles: int) -> dict[str, Any]:
    """A world of many bodies of different sizes, some too large for buckets, some drawn anew, some given."""
    spread = {"name": "random", "clearance": 0.05, "min_distance": 0.6}
    return {
        "world": {"width": 24, "height": 18},
        "robot": [
            {
                "number": 12,
                "kinematics": {"name": "diff"},
                "distribution": {"name": "random", "min_goal_distance": 3, "reachable": True},
            },
            {"kinematics": {"name": "omni"}, "state": [1, 1, 0], "goal": [22, 16]},
        ],
        "obstacle": [
            {"number": n_obstacles, "shape": {"name": "circle", "radius": 0.15}, "distribution": spread},
            {"number": 4, "shape": {"name": "rectangle", "length": 5, "width": 0.2}, "distribution": spread},
            {
                "number": 10,
                "shape": {"name": "polygon", "random_shape": True, "avg_radius_range": [0.2, 0.5]},
                "distribution": spread,
            },
            {"shape": {"name": "rectangle", "length": 1, "width": 1}, "state": [12, 9, 0.4]},
        ],
    }


def test_levels_of_many_bodies_are_those_drawn_without_buckets(monkeypatch: pytest.MonkeyPatch) -> None:
    levels = []
    for fewest in (64, 1000):
        monkeypatch.setattr(body_buckets, "FEWEST_BODIES", fewest)
        sim = ig.compile(ig.load_scenario(crowded(120)), 6)
        assert (sim.model.bucket_frame[0].columns > 0) == (fewest == 64)
        sim.reset(seed=3)
        sim.reset(seed=3, episode=2)
        levels.append((sim.state.pose.copy(), sim.state.goal.copy(), sim.state.segments.copy()))
    for with_buckets, without in zip(*levels, strict=True):
        np.testing.assert_array_equal(with_buckets, without)


def test_each_draw_looks_at_the_neighbours_alone() -> None:
    """The world is too full for 10,000 at a distance of 1 m: some hundred thousand draws find no place."""
    entry = {
        "number": 10_000,
        "shape": {"name": "circle", "radius": 0.1},
        "distribution": {"name": "random", "min_distance": 1},
    }
    sim = ig.compile(ig.load_scenario({"world": {"width": 60, "height": 60}, "obstacle": [entry]}))
    frame = sim.model.bucket_frame[0]
    found = np.zeros(10_000, np.int64)
    with pytest.raises(PlacementError, match="obstacle_"):
        sim.reset(seed=0)
    radius = 1.0 + frame.reach
    first, following = sim.state.bucket_first[0], sim.state.bucket_next[0]
    placed = int(sim.state.placed.sum())
    assert placed > 1500  # as many as there is room for, roughly
    assert gather_nearby(30.0, 30.0, radius, frame, first, following, found) < 20
