"""Writes a contact; used by all searches for contacts."""

from irsim_gym.simulator.world.names import State, kernel


@kernel(inlined=True)
def note_contact(w: int, b: int, q: int, state: State) -> None:
    """Note that bodies b and q touch; ``state.hit`` is the lowest index that a body touches.

    Reads: state (hit).
    Writes: state (collided, hit).
    """
    state.collided[w, b], state.collided[w, q] = True, True
    state.hit[w, b] = q if state.hit[w, b] < 0 else min(state.hit[w, b], q)
    state.hit[w, q] = b if state.hit[w, q] < 0 else min(state.hit[w, q], b)
