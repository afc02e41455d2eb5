"""JaxNav of JaxMARL: its own random maps of cells, with the same number of agents and beams."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from worker import Peer, Play, Work, serve

SCANNED = 16
"""Steps of one call where they are scanned in one compiled function, which is JaxNav's fastest way."""


def play(given: Mapping[str, Any], n_agents: int, beams: int, batch: int, scanned: int) -> Play:
    """Return a batch; worlds that end begin anew at states that were drawn beforehand."""
    import os

    # On a GPU another question would be answered; one thread as all others here.
    os.environ["JAX_PLATFORMS"] = "cpu"
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    import jax
    import jax.numpy as jnp
    import numpy as np
    from jaxmarl.environments.jaxnav import JaxNav

    del given
    env = JaxNav(num_agents=n_agents, lidar_num_beams=beams, lidar_max_range=6.0, max_steps=200, rad=0.3)
    key = jax.random.PRNGKey(0)
    _, fresh = jax.jit(jax.vmap(env.reset))(jax.random.split(key, batch))

    lows, highs = jnp.array([env.min_v, -env.max_w]), jnp.array([env.max_v, env.max_w])

    def one(carry: Any, _: Any) -> Any:
        key, states = carry
        key, drawn, stepped = jax.random.split(key, 3)
        numbers = jax.random.uniform(drawn, (n_agents, batch, 2), minval=lows, maxval=highs)
        actions = {name: numbers[k] for k, name in enumerate(env.agents)}
        keys = jax.random.split(stepped, batch)
        observations, states, rewards, dones, _ = jax.vmap(env.step)(keys, states, actions, fresh)
        return (key, states), (observations, rewards, dones["__all__"])

    many = jax.jit(lambda carry: jax.lax.scan(one, carry, None, length=scanned))
    holder = [(key, fresh)]

    def step() -> Any:
        holder[0], outcome = many(holder[0])
        return jax.tree.map(np.asarray, outcome)

    return Play(step, batch * n_agents * scanned)


CELLS = (
    "beams march through a grid in steps of 0.05 m, up to 6 m (approximate)",
    "float32; its own maps: random cells of 1 m in 11 x 11 m",
    "ended worlds restart at states drawn before the run",
)
SCAN = f"{SCANNED} steps in one compiled call, its fastest way"

PEER = Peer(
    "jaxnav",
    "jaxmarl",
    {
        "s1_single": Work(lambda given: play(given, 1, 180, 1, 1), CELLS),
        "s1_batch": Work(lambda given: play(given, 1, 180, given["sizes"]["jaxnav"], SCANNED), (*CELLS, SCAN)),
        "s4": Work(
            lambda given: play(given, 10, 100, given["sizes"]["jaxnav"], SCANNED),
            (*CELLS, SCAN, "no wandering bodies; a robot that collides stands still"),
        ),
    },
)

if __name__ == "__main__":
    serve(PEER)
