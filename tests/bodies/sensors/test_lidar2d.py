"""lidar2d against IR-SIM's numbers, shapely and hand-worked scenes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import shapely

import irsim_gym as ig

DIFF: dict[str, Any] = {"kinematics": {"name": "diff"}, "shape": {"name": "circle", "radius": 0.2}}


def ranges(robot: dict[str, Any], obstacles: list[dict[str, Any]], **lidar: Any) -> np.ndarray:
    sensor = {"name": "lidar2d", "range_max": 6, **lidar}
    data = {"robot": {**DIFF, "state": [5, 5, 0], "sensors": [sensor], **robot}, "obstacle": obstacles}
    sim = ig.compile(ig.load_scenario(data))
    sim.reset()
    group, member = sim.scan(0)
    return np.array(group.arrays["ranges"][0, member])


def test_scan_follows_ir_sim() -> None:
    # Golden vector of ir-sim 2.12.0; its disc is a 64-gon, the third beam is worked out for an exact disc.
    obstacles = [
        {"shape": {"name": "circle", "radius": 1}, "state": [8, 5, 0]},
        {"shape": {"name": "rectangle", "length": 1, "width": 2}, "state": [5, 8, 0.4]},
        {"shape": {"name": "linestring", "vertices": [[6, 2], [9, 3]]}, "state": [0, 0, 0]},
    ]
    lidar = {"number": 7, "angle_range": 3.0, "offset": [0.1, 0.05, 0.2]}
    found = ranges({"state": [5, 5, 0.25]}, obstacles, **lidar)
    expected = [3.269534762, 4.187017579, 1.918133, 6.0, 6.0, 1.992900571, 6.0]
    assert found == pytest.approx(expected, abs=2e-5)


@pytest.mark.parametrize(("number", "expected"), [(1, [2.5]), (3, [6.0, 2.5, 6.0])])
def test_beams_include_both_ends_and_a_single_one_looks_ahead(number: int, expected: list[float]) -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[7.5, 4], [7.5, 6]]}}
    assert ranges({}, [wall], number=number) == pytest.approx(expected)


def test_full_circle_begins_and_ends_behind() -> None:
    wall = {"shape": {"name": "linestring", "vertices": [[3, 4], [3, 6]]}}
    found = ranges({}, [wall], number=5, angle_range="2 * pi")
    assert found == pytest.approx([2.0, 6.0, 6.0, 6.0, 2.0])


def test_a_segment_on_the_line_of_a_beam_ends_it_at_its_nearer_end() -> None:
    for vertices in ([[6, 5], [8, 5]], [[8, 5], [6, 5]]):
        line = {"shape": {"name": "linestring", "vertices": vertices}}
        assert ranges({}, [line], number=3, angle_range=1.0) == pytest.approx([6.0, 1.0, 6.0])
    slanted = {"shape": {"name": "linestring", "vertices": [[5.6, 5.8], [6.2, 6.6]]}}
    assert ranges({"state": [5, 5, np.arctan2(4, 3)]}, [slanted], number=1) == pytest.approx([1.0], abs=1e-5)


def test_what_another_world_sees_from_within_a_disc_is_forgotten() -> None:
    """In the first world the edge is half a metre ahead, in the second one three metres away all around."""
    ring = {"shape": {"name": "circle", "radius": 3}, "state": [5, 5, 0], "kinematics": {"name": "diff"}}
    sensor = {"name": "lidar2d", "range_max": 8, "number": 9, "angle_range": "2 * pi"}
    sim = ig.compile(
        ig.load_scenario({"robot": {**DIFF, "state": [9, 9, 0], "sensors": [sensor]}, "obstacle": ring}), 2
    )
    sim.reset(seed=0)
    sim.state.pose[:, 0] = [[7.5, 5, 0], [5, 5, 0]]
    sim.place(np.array([0]))
    sim.refresh()
    group, member = sim.scan(0)
    found = group.arrays["ranges"][:, member]
    assert found[0, 4] == pytest.approx(0.5, abs=1e-5)
    assert found[0, 0] == pytest.approx(5.5, abs=1e-5)
    assert found[1] == pytest.approx(np.full(9, 3.0), abs=1e-5)


def test_linestrings_are_seen_from_both_sides() -> None:
    for vertices in ([[7, 4], [7, 6]], [[7, 6], [7, 4]]):
        assert ranges({}, [{"shape": {"name": "linestring", "vertices": vertices}}], number=1) == pytest.approx([2.0])


@pytest.mark.parametrize("reverse", [False, True])
def test_a_sensor_inside_a_polygon_sees_the_exit(reverse: bool) -> None:
    corners = [[-2, -2], [3, -2], [3, 2], [-2, 2]]
    shape = {"name": "polygon", "vertices": corners[::-1] if reverse else corners}
    obstacle = {"shape": shape, "state": [5, 5, 0], "kinematics": {"name": "diff"}}
    assert ranges({}, [obstacle], number=3) == pytest.approx([2.0, 3.0, 2.0])


def test_a_sensor_inside_a_disc_sees_the_exit() -> None:
    disc = {"shape": {"name": "circle", "radius": 2}, "state": [5.5, 5, 0], "kinematics": {"name": "diff"}}
    assert ranges({}, [disc], number=1) == pytest.approx([2.5])


def test_more_primitives_than_a_chunk_holds() -> None:
    turns = np.linspace(-np.pi, np.pi, 151)[:-1]
    ring = {"name": "polygon", "vertices": [[4.0 * np.cos(turn), 4.0 * np.sin(turn)] for turn in turns]}
    posts = [
        {"shape": {"name": "circle", "radius": 0.03}, "state": [5 + 3 * np.cos(turn), 5 + 3 * np.sin(turn), 0]}
        for turn in np.linspace(-np.pi, np.pi, 181)[::2]
    ]
    fence = {"shape": ring, "state": [5, 5, 0], "kinematics": {"name": "diff"}}
    found = ranges({}, [fence, *posts], number=181, angle_range="2 * pi")
    assert found[::2] == pytest.approx(np.full(91, 2.97), abs=1e-5)
    assert found[1::2] == pytest.approx(np.full(90, 4.0), abs=1e-3)


def test_unobstructed_bodies_are_transparent_and_short_ranges_are_cut() -> None:
    ghost = {"shape": {"name": "circle", "radius": 0.5}, "state": [6, 5, 0], "unobstructed": True}
    disc = {"shape": {"name": "circle", "radius": 0.5}, "state": [7, 5, 0]}
    assert ranges({}, [ghost, disc], number=1) == pytest.approx([1.5])
    assert ranges({}, [disc], number=1, range_min=2.0) == pytest.approx([2.0])


def test_a_free_beam_reports_exactly_range_max() -> None:
    assert ranges({}, [], number=4, range_max=5.3).tolist() == [np.float32(5.3)] * 4


def test_own_extent_is_the_distance_to_the_own_outline() -> None:
    robot = {**DIFF, "shape": {"name": "rectangle", "length": 1.0, "width": 0.5}, "state": [5, 5, 0]}
    sensors = [{"name": "lidar2d", "number": 5, "angle_range": "2 * pi", "offset": [0.2, 0, 0]}]
    sim = ig.compile(ig.load_scenario({"robot": {**robot, "sensors": sensors}}))
    footprint = sim.scan(0)[0].arrays["footprint"][0]
    assert footprint == pytest.approx([0.7, 0.25, 0.3, 0.25, 0.7], abs=1e-6)


def outline(sim: Any, w: int, b: int) -> shapely.Geometry:
    model, state = sim.model, sim.state
    start, count = model.segment_start[b], model.segment_count[w % len(model.segment_count), b]
    discs = state.discs[w, model.disc_start[b] :][: model.disc_count[0, b]]
    if len(discs):
        return shapely.Point(*discs[0, :2]).buffer(discs[0, 2], quad_segs=4000).exterior
    rows = state.segments[w, start : start + count]
    return shapely.multilinestrings(shapely.linestrings(rows.reshape(-1, 2, 2)))


@pytest.mark.parametrize("name", ["cluttered_room", "dense_room"])
def test_scans_of_random_rooms_agree_with_shapely(name: str) -> None:
    sim = ig.compile(ig.load_scenario(name), 12)
    sim.reset(seed=100)
    group, member = sim.scan(0)
    apart = []
    for w in range(12):
        bodies = [b for b in range(1, len(sim.model.role)) if sim.model.present[w, b]]
        scene = shapely.union_all([outline(sim, w, b) for b in bodies])
        x, y, heading = sim.state.pose[w, 0]
        for angle, found in zip(group.arrays["angles"], group.arrays["ranges"][w, member], strict=True):
            ends = [(x, y), (x + 6 * np.cos(heading + angle), y + 6 * np.sin(heading + angle))]
            hit = shapely.intersection(shapely.linestrings(ends), scene)
            expected = 6.0 if hit.is_empty else shapely.distance(shapely.Point(x, y), hit)
            apart.append(abs(expected - float(found)))
    # A beam that grazes a corner may fall to either side of it in float32.
    assert np.quantile(apart, 0.998) < 1e-4
