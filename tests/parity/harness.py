"""One scenario in ir-sim 2.12.0 and in irsim_gym, compared step by step."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import imageio.v3 as imageio
import numpy as np
import ours
import ties
from beams import compare_scans
from contacts import grazes
from ir_sim import IrSim, Snapshot
from translation import to_ir_sim
from views import compare_fog, compare_views

EXACT = 1e-9
SINGLE = 2e-6
"""Rounding of positions [m] in single precision, in which ir-sim's orca computes (decision ``orca_precision``)."""

HOLD = 5
RARE = 0.005
"""Share of moves that may be ties where bodies look at each other."""


@dataclass
class Report:
    """What was compared, and what was found.

    Attributes:
        steps: Steps.
        moves: Moves of bodies that can move.
        beams: Beams.
        ties: Decisions that ir-sim itself turns over when its state is moved by 1e-12.
        grazes: Flags that differ because a disc is not a polygon of 64 corners.
        grazing_beams: Beams that pass an edge within the rounding of their direction.
        decisions: Names of the differences that the comparison relied on.
        event: What ended a free run.
    """

    steps: int = 0
    moves: int = 0
    beams: int = 0
    ties: int = 0
    grazes: int = 0
    grazing_beams: int = 0
    decisions: set[str] = field(default_factory=set)
    event: str = ""


def scenario_of(case: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the scenario of a case; its map is drawn into the folder."""
    scenario = {key: value for key, value in case.items() if key != "parity"}
    rows = (case.get("parity") or {}).get("map")
    if rows:
        scenario["world"] = {**(case.get("world") or {}), "obstacle_map": draw_map(rows, folder)}
    return scenario


def looks_around(scenario: Mapping[str, Any]) -> Iterator[bool]:
    """Yield for each behaviour of a scenario whether it looks at other bodies: then rounding may decide."""
    for way in mappings(scenario):
        yield way.get("name") in ("rvo", "sfm", "orca")


def mappings(data: Any) -> Iterator[Mapping[str, Any]]:
    """Yield all mappings within some data."""
    if isinstance(data, Mapping):
        yield data
    for item in data.values() if isinstance(data, Mapping) else data if isinstance(data, list) else ():
        yield from mappings(item)


def draw_map(rows: list[str], folder: Path) -> str:
    """Write a picture, one pixel for each letter: # is black, + gray just dark enough, - just not, the rest white."""
    shades = {"#": 0, "+": 127, "-": 128}
    pixels = np.array([[shades.get(letter, 255) for letter in row] for row in rows], np.uint8)
    file = folder / "map.png"
    imageio.imwrite(file, np.stack([pixels] * 3, axis=-1))
    return str(file)


class Pair:
    """A scenario in both simulators."""

    def __init__(self, case: Mapping[str, Any], folder: Path, seed: int = 0) -> None:
        self.report = Report()
        self.scenario = scenario_of(case, folder)
        plan = case.get("parity") or {}
        self.steps = int(plan.get("steps", 30))
        self.most_ties = float(plan.get("ties", RARE if any(looks_around(self.scenario)) else 0.0))
        self.actions: dict[int, Any] = plan.get("actions") or {}
        self.random = np.random.default_rng(seed)
        self.held: dict[int, Any] = {}
        self.reference = IrSim(to_ir_sim(self.scenario, self.report.decisions), folder, seed)
        self.sim = ours.build(self.scenario, list(self.actions))
        assert len(self.reference.objects) == len(self.sim.model.role), "not the same number of bodies"
        if plan.get("random_placement"):
            self.report.decisions.add("random_streams")
            ours.adopt_placement(self.sim, self.reference)
        self.check_start()

    def check_start(self) -> None:
        """Both begin in the same place."""
        for b, theirs in enumerate(self.reference.objects):
            found = self.sim.state.pose[0, b]
            assert np.allclose(found, theirs._state[:3, 0], rtol=0, atol=1e-12), (b, found, theirs._state)

    def commands(self, step: int) -> dict[int, Any]:
        """Return the commands of this step: those of the case in turn, or random ones held for some steps."""
        if step % HOLD == 0:
            for b, rows in self.actions.items():
                if rows == "random":
                    size = self.reference.objects[b].vel_dim
                    self.held[b] = self.random.uniform(-1.3, 1.3, size).round(3)
                else:
                    self.held[b] = np.array(rows[(step // HOLD) % len(rows)], float)
        return self.held

    def advance_ours(self, commands: Mapping[int, Any]) -> None:
        """Step ours with the agents' commands."""
        given = np.zeros((1, len(self.sim.agents), 3))
        for k, b in enumerate(self.sim.agents):
            given[0, k, : len(commands[int(b)])] = ours.from_body_frame(self.sim, int(b), commands[int(b)])
        self.sim.step(given if len(self.sim.agents) else None)

    def obey_decisions(self) -> None:
        """Set in ir-sim what differs by decision: an unobstructed body is neither flagged nor stopped."""
        for one in self.reference.objects:
            if one.unobstructed:
                one.collision_flag, one.stop_flag, one.collision_obj = False, False, []

    def step_both(self, step: int) -> tuple[Snapshot, Snapshot]:
        """Step both; return ir-sim's state before and after."""
        before = self.reference.snapshot()
        commands = self.commands(step)
        self.reference.step(commands)
        self.obey_decisions()
        after = self.reference.snapshot()
        ours.renew_wandering(self.sim, before, after)
        self.advance_ours(commands)
        self.report.steps += 1
        return before, after

    def single_steps(self) -> Report:
        """Compare one step at a time, each from ir-sim's state."""
        for step in range(self.steps):
            ours.set_state(self.sim, self.reference.snapshot(), self.reference)
            before, after = self.step_both(step)
            moved = self.differences(after)
            for b in moved:
                ties.confirm(self, b, before, after)
            self.report.ties += len(moved)
            self.compare_flags(after, skip=set(moved))
            compare_scans(self)
            compare_views(self)
        compare_fog(self)
        assert self.report.ties <= self.most_ties * self.report.moves, self.report
        return self.report

    def free_run(self, steps: int = 200) -> Report:
        """Let both run by themselves until the first tie or graze."""
        for step in range(steps):
            before, after = self.step_both(step)
            moved = self.differences(after)
            if moved:
                ties.confirm(self, moved[0], before, after)
                self.report.event = f"tie of body {moved[0]}"
                break
            if self.compare_flags(after, skip=set()):
                self.report.event = "grazing discs"
                break
        else:
            self.report.event = "end"
        return self.report

    def differences(self, after: Snapshot) -> list[int]:
        """Return the bodies that did not move alike."""
        self.report.moves += int(self.sim.model.movable.sum())
        return [b for b in range(len(after.states)) if self.apart(b, after) > self.tolerance(b)]

    def tolerance(self, b: int) -> float:
        """Return how far apart a body's states may be."""
        planned = any(b in members for members in self.reference.groups_of_planners)
        return SINGLE / min(0.1, float(self.sim.model.step_time[0])) if planned else EXACT

    def apart(self, b: int, after: Snapshot) -> float:
        """Return the largest difference between the body's states: pose, steering, velocity and twist."""
        model, state = self.sim.model, self.sim.state
        if not model.movable[b]:
            return 0.0
        expected, velocity = after.states[b][:, 0], after.velocities[b][:, 0]
        twist = np.asarray(self.reference.objects[b].kf.velocity_to_xy(after.states[b], after.velocities[b]), float)
        found = [state.pose[0, b] - expected[:3], state.twist[0, b, :2] - twist.reshape(-1)[:2]]
        if len(expected) > 3:
            found.append(state.steering[0, b : b + 1] - expected[3:4])
        found.append(ours.velocity_in_body_frame(self.sim, b)[: len(velocity)] - velocity)
        gaps = np.abs(np.concatenate(found))
        return float(np.max(np.where(np.isnan(gaps), np.inf, gaps)))

    def compare_flags(self, after: Snapshot, skip: set[int]) -> bool:
        """Compare arrival, goals, collision and stop; return whether grazing discs made a difference."""
        state, model = self.sim.state, self.sim.model
        grazed = False
        for b, theirs in enumerate(self.reference.objects):
            if b in skip or theirs.shape == "map":  # decision map_flag
                continue
            arrived, collided, stopped = after.flags[b]
            where = (self.report.steps, theirs.name)
            if model.has_goal[b] and not ties.on_threshold(theirs):
                assert bool(state.arrived[0, b]) == arrived, ("arrived", *where)
                goal = np.asarray(after.goals[b][0], float).reshape(-1)
                known = 2 if len(goal) < 3 or np.isnan(state.goal[0, b, 2]) else 3
                assert np.allclose(state.goal[0, b, :known], goal[:known], rtol=0, atol=EXACT), ("goal", *where)
            if (bool(state.collided[0, b]), bool(state.stopped[0, b])) != (collided, stopped):
                assert grazes(self, b, skip), ("collided", *where, state.collided[0, b], collided)
                self.report.grazes += 1
                self.report.decisions.add("exact_disc")
                grazed = True
            elif collided:
                touched = {one.id for one in after.touched[b] if not one.unobstructed}
                assert int(state.hit[0, b]) == min(touched) or grazes(self, b, skip), ("hit", *where)
        return grazed
