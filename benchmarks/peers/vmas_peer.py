"""VMAS: S1 as a scenario of ours in its language, and its own scenario `navigation`."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

from worker import Peer, Play, Work, random_actions, serve


def room(given: Mapping[str, Any], batch: int) -> Any:
    """Return S1 as an environment of VMAS with ``batch`` worlds."""
    import torch
    from vmas import make_env

    torch.set_num_threads(1)
    return make_env(_scenario(given), num_envs=batch, device="cpu", continuous_actions=True, seed=0)


def _scenario(given: Mapping[str, Any]) -> Any:
    import torch
    from vmas.simulator.core import Agent, Box, Landmark, Line, Sphere, World
    from vmas.simulator.dynamics.diff_drive import DiffDrive
    from vmas.simulator.scenario import BaseScenario
    from vmas.simulator.sensors import Lidar

    scenario = given["scenario"]
    side, sensor = scenario["world"]["width"], scenario["robot"][0]["sensors"][0]
    starts = torch.tensor(given["starts"], dtype=torch.float32)
    shapes = {"circle": lambda s: Sphere(s["radius"]), "rectangle": lambda s: Box(s["length"], s["width"])}

    class Room(BaseScenario):
        """One robot among things that never move."""

        def make_world(self, batch_dim: int, device: Any, **options: Any) -> Any:
            world = World(batch_dim, device, dt=0.1, substeps=1, drag=0.0)
            self.fixed, bodies = [], [e for e in scenario["obstacle"] if e["shape"]["name"] in shapes]
            for k, entry in enumerate(bodies):
                landmark = Landmark(f"body {k}", shape=shapes[entry["shape"]["name"]](entry["shape"]), collide=True)
                world.add_landmark(landmark)
                self.fixed.append((landmark, entry["state"]))
            for k in range(4):
                wall = Landmark(f"wall {k}", shape=Line(side), collide=True)
                turn = k * math.pi / 2.0
                place = [side / 2.0 - side / 2.0 * math.sin(turn), side / 2.0 - side / 2.0 * math.cos(turn), turn]
                world.add_landmark(wall)
                self.fixed.append((wall, place))
            lidar = Lidar(world, n_rays=sensor["number"], max_range=sensor["range_max"])
            robot = Agent(
                "robot",
                shape=Sphere(0.2),
                collide=True,
                sensors=[lidar],
                dynamics=DiffDrive(world, integration="euler"),
                u_multiplier=[1.0, 1.5],
            )
            world.add_agent(robot)
            self.cursor = 0
            self.goal, self.way = torch.zeros(batch_dim, 2), torch.zeros(batch_dim)
            self.steps, self.ended = torch.zeros(batch_dim), torch.zeros(batch_dim, dtype=torch.bool)
            return world

        def reset_world_at(self, env_index: Any = None) -> None:
            for landmark, (x, y, turn) in self.fixed:
                landmark.set_pos(torch.tensor([x, y]), batch_index=env_index)
                landmark.set_rot(torch.tensor([turn]), batch_index=env_index)
            self.restart(torch.ones(self.world.batch_dim, dtype=torch.bool))

        def restart(self, ended: Any) -> None:
            """Put the robots of some worlds at the next starts of the list, all at once."""
            count = int(ended.sum())
            rows = starts[(self.cursor + torch.arange(count)) % len(starts)]
            self.cursor += count
            state = self.world.agents[0].state
            for name, values in {"pos": rows[:, :2], "rot": rows[:, 2:3]}.items():
                whole = getattr(state, name).clone()
                whole[ended] = values
                setattr(state, name, whole)
            state.vel = torch.where(ended[:, None], 0.0, state.vel)
            state.ang_vel = torch.where(ended[:, None], 0.0, state.ang_vel)
            self.goal[ended] = rows[:, 3:]
            self.way[ended] = torch.linalg.vector_norm(rows[:, 3:] - rows[:, :2], dim=1)
            self.steps[ended] = 0.0

        def process_action(self, agent: Any) -> None:
            agent.action.u[:, 0] = 0.5 + 0.5 * agent.action.u[:, 0]

        def reward(self, agent: Any) -> Any:
            self.steps += 1.0
            way = torch.linalg.vector_norm(self.goal - agent.state.pos, dim=1)
            gaps = [self.world.get_distance(agent, landmark) for landmark, _ in self.fixed]
            hit = torch.stack(gaps).amin(dim=0) <= 0.0
            arrived = (way < 0.3) & ~hit
            gain = 4.0 * (self.way - way) / (side * math.sqrt(2.0))
            self.way = way
            # Here, before anything is observed: so one scan serves those that go on and those that begin anew.
            self.ended = hit | arrived | (self.steps >= 200)
            if bool(self.ended.any()):
                self.restart(self.ended)
            return gain - 0.01 + 5.0 * arrived - 4.0 * hit

        def observation(self, agent: Any) -> Any:
            state = agent.state
            ranges = 1.0 - torch.clamp(agent.sensors[0].measure() - 0.2, min=0.0) / sensor["range_max"]
            gap = self.goal - state.pos
            bearing = torch.atan2(gap[:, 1], gap[:, 0]) - state.rot[:, 0]
            way = torch.linalg.vector_norm(gap, dim=1)
            rest = [way / (side * math.sqrt(2.0)), torch.cos(bearing), torch.sin(bearing), torch.exp(-way)]
            return torch.cat([ranges, torch.stack(rest, dim=1), state.vel], dim=1)

        def done(self) -> Any:
            return self.ended

    return Room()


def s1(given: Mapping[str, Any], batch: int) -> Play:
    """Return S1 with random driving."""
    import torch

    env = room(given, batch)
    rows = itertools.cycle(torch.tensor(random_actions(64, 2 * batch)).reshape(64, batch, 2))

    def step() -> Any:
        observations, rewards, dones, _ = env.step([next(rows)])
        return observations[0].numpy(), rewards[0].numpy(), dones.numpy()

    return Play(step, batch)


def navigation(given: Mapping[str, Any], batch: int) -> Play:
    """Return VMAS's own scenario with 10 agents of 100 rays."""
    import torch
    from vmas import make_env

    del given
    torch.set_num_threads(1)
    env = make_env(
        "navigation", num_envs=batch, device="cpu", seed=0, n_agents=10, n_lidar_rays=100, world_spawning_x=3,
        world_spawning_y=3,
    )  # fmt: skip
    rows = itertools.cycle(torch.tensor(random_actions(64, 20)).reshape(64, 10, 1, 2))

    def step() -> Any:
        observations, rewards, *_ = env.step(list(next(rows).expand(10, batch, 2)))
        return [values.numpy() for values in (*observations, *rewards)]

    return Play(step, 10 * batch)


FLOATS = "state and rays in float32"
ROOM = (FLOATS, "touching bodies are pushed apart", "starts come from a list")
TEAM = (
    FLOATS,
    "no wandering bodies; beams see only the other agents",
    "omnidirectional agents driven by forces, in two half-steps",
    "no terminations, no restarts",
)

PEER = Peer(
    "vmas",
    "vmas",
    {
        "s1_single": Work(lambda given: s1(given, 1), ROOM),
        "s1_batch": Work(lambda given: s1(given, given["sizes"]["vmas"]), ROOM),
        "s4": Work(lambda given: navigation(given, given["sizes"]["vmas"]), TEAM),
    },
)

if __name__ == "__main__":
    serve(PEER)
