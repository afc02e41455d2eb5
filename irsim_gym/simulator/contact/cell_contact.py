"""Contact with the cells of the obstacle map. Worlds without a map do not need these kernels."""

from irsim_gym.simulator.cell_maps.cell_room import room_about
from irsim_gym.simulator.cell_maps.cells import outline_cells_distance, outline_meets_cells
from irsim_gym.simulator.cell_maps.world_maps import map_of
from irsim_gym.simulator.contact.pairs import note_contact
from irsim_gym.simulator.world.names import CellMaps, Floats, Ints, Model, State, kernel, outline_of, row_of


@kernel
def find_cell_contacts(worlds: Ints, bodies: Ints, cells: CellMaps, model: Model, state: State) -> None:
    """Note which bodies touch an occupied cell, both for them and for the body of the map.

    Reads: model (disc_count, disc_start, present, reach, segment_count, segment_start, solid, unobstructed), state
        (discs, hit, pose, segments).
    Writes: state (collided, hit).
    """
    map_body = cells.body
    for w in worlds:
        grid = map_of(cells, w)
        for b in bodies:
            if b == map_body or model.unobstructed[b] or not model.present[w, b] or not model.present[w, map_body]:
                continue
            # The origin is certainly farther from all occupied cells than the outline reaches.
            if room_about(grid, state.pose[w, b, 0], state.pose[w, b, 1])[0] > model.reach[row_of(model.reach, w), b]:
                continue
            if outline_meets_cells(grid, outline_of(model, state, w, b)):
                note_contact(w, b, map_body, state)


@kernel
def measure_cell_clearance(
    worlds: Ints, bodies: Ints, cells: CellMaps, model: Model, state: State, distance: Floats
) -> None:
    """Lower surface distances [m], shape ``(n_worlds, n_bodies)``, to those from the nearest occupied cell.

    Reads: model (disc_count, disc_start, present, reach, segment_count, segment_start, solid), state (discs, pose,
        segments).
    Writes: distance.
    """
    map_body = cells.body
    for w in worlds:
        grid = map_of(cells, w)
        for k in range(bodies.shape[0]):
            b = bodies[k]
            if b == map_body or not model.present[w, map_body]:
                continue
            least = room_about(grid, state.pose[w, b, 0], state.pose[w, b, 1])[0]
            # No nearer than the origin's least distance minus the reach: measure only if that may lower the distance.
            if least - model.reach[row_of(model.reach, w), b] < distance[w, k]:
                distance[w, k] = outline_cells_distance(grid, outline_of(model, state, w, b), distance[w, k])
