"""Pairs of bodies that may touch, in the order in which IR-SIM treats them."""

import numpy as np

from irsim_gym.simulator.geometry.buckets import put_in_order
from irsim_gym.simulator.pushing.matter import Matter
from irsim_gym.simulator.pushing.memory import PAIRS, Pushing, greatest_travel
from irsim_gym.simulator.world.names import Floats, Ints, Model, State, kernel, outline_of
from irsim_gym.simulator.world.outline import CIRCLE_CORNERS

SLOP = 1e-6
"""By how much bodies that were taken apart are farther apart than touching [m]."""
NODE = 10
"""Boxes in a node of the tree whose order the pairs have."""


@kernel
def find_pairs(w: int, slot: int, push: Pushing, matter: Matter, model: Model, state: State) -> None:
    """Write the pairs of bodies whose boxes meet, or may meet in this step, and their order.

    Reads: push (boxes, counts, items, motions, order, pairs, sequence), matter (map_box, substance), model (disc_count,
        disc_start, map_frame, movable, present, segment_count, segment_start, solid, step_time, unobstructed,
        velocity_max), state (discs, pose, segments, twist).
    Writes: push (boxes, counts, items, margin, motions, order, pairs, sequence).
    """
    boxes, pairs, sequence, by_left = push.boxes[slot], push.pairs[slot], push.sequence[slot], push.order[slot, 4]
    n_bodies, count, is_crowded = boxes.shape[0], 0, False
    margin = 2.0 * greatest_travel(w, matter, model, state) * model.step_time[0] + SLOP
    push.margin[slot] = margin
    for b in range(n_bodies):
        bound_body(w, b, boxes[b], matter, model, state)
    sort_by_left(by_left, boxes)
    for s in range(n_bodies):
        p = by_left[s]
        if not takes_part(w, p, model):
            continue
        for t in range(s + 1, n_bodies):
            q = by_left[t]
            # Twice the margin, so that rounding leaves nobody out.
            if boxes[q, 0] > boxes[p, 2] + 2.0 * margin:
                break
            if boxes[q, 1] > boxes[p, 3] + 2.0 * margin or boxes[q, 3] < boxes[p, 1] - 2.0 * margin:
                continue
            if max(matter.substance[p].inverse, matter.substance[q].inverse) <= 0.0 or not takes_part(w, q, model):
                continue
            i, j = min(p, q), max(p, q)
            x0, y0, x1, y1 = boxes[i, 0] - margin, boxes[i, 1] - margin, boxes[i, 2] + margin, boxes[i, 3] + margin
            if boxes[j, 0] <= x1 and boxes[j, 2] >= x0 and boxes[j, 1] <= y1 and boxes[j, 3] >= y0:
                sequence[count] = i * n_bodies + j
                count += 1
    if count > 1:
        put_in_order(sequence, count)
    for k in range(count):
        pair, i = pairs[k], sequence[k] // n_bodies
        pair.a, pair.b, pair.report, pair.impulse, pair.rank, pair.moves = i, sequence[k] % n_bodies, -1, 0.0, 0, -1
        is_crowded = is_crowded or (k > 0 and pairs[k - 1].a == i)
        sequence[k] = k
    push.counts[slot, PAIRS] = count
    place = push.order[slot, 1]
    if is_crowded:
        order_bodies(w, slot, push, model)
    if count > 1:
        rank_pairs(slot, push, matter)
        for k in range(count):
            # First by what stands between, then by body a, then by the place of body b; the last digit is the pair.
            sequence[k] = ((pairs[k].rank * n_bodies + pairs[k].a) * n_bodies + place[pairs[k].b]) * count + k
        put_in_order(sequence, count)
        for k in range(count):
            sequence[k] %= count


@kernel
def sort_by_left(row: Ints, boxes: Floats) -> None:
    """Sort bodies by the left ends of their boxes, from the order of before, in which most of them still are.

    Reads: boxes.
    Writes: row.
    """
    for k in range(1, row.shape[0]):
        moved, i = row[k], k
        while i > 0 and boxes[row[i - 1], 0] > boxes[moved, 0]:
            row[i] = row[i - 1]
            i -= 1
        row[i] = moved


@kernel(inlined=True)
def takes_part(w: int, b: int, model: Model) -> bool:
    """Return whether a body can touch others. The body of a map is hidden from all else.

    Reads: model (map_frame, present, unobstructed).
    """
    return bool(model.present[w, b] and (not model.unobstructed[b] or b == model.map_frame[0].body))


@kernel
def bound_body(w: int, b: int, box: Floats, matter: Matter, model: Model, state: State) -> None:
    """Write the box around a body: x0, y0, x1, y1 [m]; that of a disc is the box of its 64 corners, as in IR-SIM.

    Reads: matter (map_box), model (disc_count, disc_start, map_frame, segment_count, segment_start, solid), state
        (discs, pose, segments).
    Writes: box.
    """
    if b == model.map_frame[0].body:
        for side in range(4):
            box[side] = matter.map_box[side]
        return
    segments, start, n_segments, discs, first, n_discs, _ = outline_of(model, state, w, b)
    x0, y0, x1, y1 = np.inf, np.inf, -np.inf, -np.inf
    for s in range(start, start + n_segments):
        x0, x1 = min(x0, segments[s, 0], segments[s, 2]), max(x1, segments[s, 0], segments[s, 2])
        y0, y1 = min(y0, segments[s, 1], segments[s, 3]), max(y1, segments[s, 1], segments[s, 3])
    for d in range(first, first + n_discs):
        # How far the nearest corner is from each of the four directions.
        turns = state.pose[w, b, 2] * CIRCLE_CORNERS / (2.0 * np.pi)
        half = discs[d, 2] * np.cos((turns - np.round(turns)) * 2.0 * np.pi / CIRCLE_CORNERS)
        x0, x1 = min(x0, discs[d, 0] - half), max(x1, discs[d, 0] + half)
        y0, y1 = min(y0, discs[d, 1] - half), max(y1, discs[d, 1] + half)
    box[0], box[1], box[2], box[3] = x0, y0, x1, y1


@kernel
def order_bodies(w: int, slot: int, push: Pushing, model: Model) -> None:
    """Write the places of bodies in a tree of boxes: packed by x into slices, by y within them, ten by ten.

    It is the order in which a query of GEOS returns them ("Sort-Tile-Recursive", Leutenegger et al. 1997).

    Reads: push (boxes, items, order), model (present).
    Writes: push (items, order).
    """
    boxes, items, nodes = push.boxes[slot], push.items[slot, 0], push.items[slot, 1]
    leaves, place, row, kept = push.order[slot, 0], push.order[slot, 1], push.order[slot, 2], push.order[slot, 3]
    count = 0
    for b in range(boxes.shape[0]):
        if model.present[w, b]:
            leaves[count] = b
            for side in range(4):
                items[count, side] = boxes[b, side]
            items[count, 4], items[count, 5] = count, 1
            count += 1
    n_leaves = count
    while True:
        slices = int(np.ceil(np.sqrt(np.ceil(count / NODE))))
        size = int(np.ceil(count / max(slices, 1)))
        for k in range(count):
            row[k] = k
        sort_row(row, 0, count, 0, items)
        for first in range(0, count, size):
            sort_row(row, first, min(first + size, count), 1, items)
        # The leaves of the items, in their new order.
        n_kept = 0
        for k in range(count):
            begin = int(items[row[k], 4])
            for i in range(begin, begin + int(items[row[k], 5])):
                kept[n_kept] = leaves[i]
                n_kept += 1
        for k in range(n_leaves):
            leaves[k] = kept[k]
        if count <= NODE:
            break
        count = join_items(count, size, row, nodes, items)
    for k in range(n_leaves):
        place[leaves[k]] = k


@kernel
def join_items(count: int, size: int, row: Ints, nodes: Floats, items: Floats) -> int:
    """Replace items by nodes of up to ten of them, slice by slice; return their number."""
    n_nodes, begin = 0, 0
    for first in range(0, count, size):
        for k in range(first, min(first + size, count)):
            item = items[row[k]]
            if (k - first) % NODE == 0:
                n_nodes += 1
                node = nodes[n_nodes - 1]
                node[0], node[1], node[2], node[3] = np.inf, np.inf, -np.inf, -np.inf
                node[4], node[5] = begin, 0
            node = nodes[n_nodes - 1]
            node[0], node[1] = min(node[0], item[0]), min(node[1], item[1])
            node[2], node[3] = max(node[2], item[2]), max(node[3], item[3])
            node[5] += item[5]
            begin += int(item[5])
    for k in range(n_nodes):
        for side in range(6):
            items[k, side] = nodes[k, side]
    return n_nodes


@kernel
def sort_row(row: Ints, begin: int, end: int, axis: int, items: Floats) -> None:
    """Sort a part of a row of items by the middle of their boxes along an axis; equal ones keep their order."""
    for k in range(begin + 1, end):
        moved, i = row[k], k
        key = items[moved, axis] + items[moved, axis + 2]
        while i > begin and items[row[i - 1], axis] + items[row[i - 1], axis + 2] > key:
            row[i] = row[i - 1]
            i -= 1
        row[i] = moved


@kernel
def rank_pairs(slot: int, push: Pushing, matter: Matter) -> None:
    """Rank pairs by how many bodies stand between them and one that nobody pushes.

    Reads: push (counts, motions, pairs), matter (substance).
    Writes: push (motions, pairs).
    """
    motions, pairs, n_pairs = push.motions[slot], push.pairs[slot], push.counts[slot, PAIRS]
    unreached = motions.shape[0] + 1
    for k in range(n_pairs):
        a, b = pairs[k].a, pairs[k].b
        motions[a].level = unreached if matter.substance[a].inverse > 0.0 else 0
        motions[b].level = unreached if matter.substance[b].inverse > 0.0 else 0
    level, goes_on = 0, True
    while goes_on:
        goes_on = False
        for k in range(n_pairs):
            one, other = motions[pairs[k].a], motions[pairs[k].b]
            if min(one.level, other.level) == level and max(one.level, other.level) > level + 1:
                one.level, other.level = min(one.level, level + 1), min(other.level, level + 1)
                goes_on = True
        level += 1
    for k in range(n_pairs):
        one, other = motions[pairs[k].a].level, motions[pairs[k].b].level
        pairs[k].rank = min(one, other) * (unreached + 1) + max(one, other)
