"""Records a world: frames for films, figures for replays."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from irsim_gym.base.arraytypes import Bytes
from irsim_gym.live.session import moves
from irsim_gym.simulator.engine import Simulation
from irsim_gym.simulator.engine.telemetry import telemetry

if TYPE_CHECKING:
    from irsim_gym.rendering.looks.packing import PackedFrame
    from irsim_gym.rendering.replay.replay_data import Recording
    from irsim_gym.rendering.scene.scene import Scene

NOTHING_KEPT = "nothing was kept: load the world with record=True"


class Reel:
    """Frames since the last film, and the numbers of all episodes.

    Frames are compressed, as flat colours shrink to a few percent.
    """

    def __init__(self) -> None:
        self._frames: list[PackedFrame] = []
        self._recordings: list[Recording] = []
        self._is_begun = False

    def begin(self) -> None:
        """Begin another episode."""
        self._is_begun = False

    def keep(self, frame: Bytes, scene: Scene, simulation: Simulation) -> None:
        """Keep a moment: its picture, its numbers, and the outcomes of the robots."""
        from irsim_gym.rendering.looks.packing import PackedFrame
        from irsim_gym.rendering.replay.replay_data import Recording

        if self._frames and frame.shape != self._frames[0].shape:
            self._frames = []  # frames of another shape are those of another file
        self._frames.append(PackedFrame.of(frame))
        robots = moves.robots(simulation)
        names = [simulation.parts.names[body] for body in robots.tolist()]
        if not self._is_begun:
            self._recordings.append(Recording(simulation.scenario, names))
            self._is_begun = True
        fares = dict(zip(names, telemetry(simulation, 0, robots), strict=True))
        for name, body in zip(names, robots.tolist(), strict=True):
            fares[name] = {**fares[name], "outcome": _outcome(simulation, body)}
        recording = self._recordings[-1]
        values: list[dict[str, Any]] = [dict(fares.get(name, {"outcome": "gone"})) for name in recording.agents]
        recording.note(scene, simulation.state.pose[0], values)
        recording.name = f"episode {len(self._recordings)}: {scene.status.lower()}, {scene.time:.1f} s"

    def keep_again(self, frame: Bytes, scene: Scene) -> None:
        """Keep the latest moment with other marks over it."""
        from irsim_gym.rendering.looks.packing import PackedFrame

        if self._frames:
            self._frames[-1] = PackedFrame.of(frame)
        self._recordings[-1].redraw(scene)

    def save_film(self, path: Path, fps: float) -> None:
        """Write the frames to a film, and start another one.

        Raises:
            ValueError: There are none.
        """
        from irsim_gym.rendering.films.video import write_video

        if not self._frames:
            raise ValueError(f"no frames: {NOTHING_KEPT}")
        write_video((packed.frame() for packed in self._frames), path, fps, total=len(self._frames))
        self._frames = []

    def save_html(self, path: Path) -> None:
        """Write a page that plays all episodes.

        Raises:
            ValueError: There are none.
        """
        from irsim_gym.rendering.replay.replay_page import save_html

        if not self._recordings:
            raise ValueError(NOTHING_KEPT)
        save_html(path, self._recordings)


def _outcome(simulation: Simulation, body: int) -> str:
    """Return the outcome of a robot so far."""
    state = simulation.state
    return "arrived" if state.arrived[0, body] else "collision" if state.collided[0, body] else "running"
