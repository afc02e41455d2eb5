"""Draw what a robot can observe as pictures, beside the world it stands in: ``python docs/what_a_robot_sees.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import irsim_gym

SCENARIO, LEVEL, STEPS = "cluttered_room", 14, 5
SIDE, GAP, HEAD = 320, 12, 26
OBSERVATIONS: dict[str, dict[str, Any]] = {
    "occupancy_image": {"name": "occupancy_image", "pixels": 64, "metres": 8},
    "occupancy_image, from_scan: true": {"name": "occupancy_image", "pixels": 64, "metres": 8, "from_scan": True},
    "seen_map_image": {"name": "seen_map_image", "pixels": 64, "metres": 8},
}
GREEN = np.array([47, 179, 68])


def seen(observation: dict[str, Any]) -> tuple[Any, Any]:
    """Return what a robot observes after some steps ahead, and a picture of its world."""
    task = {"name": "blank", "observations": [observation]}
    env = irsim_gym.make(SCENARIO, task=task, render_mode="rgb_array")
    picture, _ = env.reset(seed=LEVEL)
    for _ in range(STEPS):
        picture = env.step(np.array([1.0, 0.0], np.float32))[0]
    frame = env.render()
    env.close()
    return picture, frame


def in_colours(picture: Any) -> Any:
    """Return a picture of uint8 ``(height, width, 3)`` in which the second channel, the goal, is green."""
    share = picture[..., 1:].astype(float) / 255
    return np.uint8(picture[..., :1] * (1 - share) + GREEN * share)


def main(path: Path) -> None:
    """Write the picture."""
    shown = {title: seen(observation) for title, observation in OBSERVATIONS.items()}
    (_, frame), *_ = shown.values()
    panels = {"the world": Image.fromarray(frame).resize((SIDE, SIDE), Image.Resampling.LANCZOS)}
    for title, (picture, _) in shown.items():
        panels[title] = Image.fromarray(in_colours(picture)).resize((SIDE, SIDE), Image.Resampling.NEAREST)
    sheet = Image.new("RGB", (len(panels) * (SIDE + GAP) + GAP, SIDE + HEAD + GAP), "white")
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(14)
    for i, (title, panel) in enumerate(panels.items()):
        pen.text((GAP + i * (SIDE + GAP), 5), title, fill="#3d4451", font=font)
        sheet.paste(panel, (GAP + i * (SIDE + GAP), HEAD))
        pen.rectangle((GAP + i * (SIDE + GAP) - 1, HEAD - 1, (i + 1) * (SIDE + GAP), HEAD + SIDE), outline="#aab2bd")
    sheet.save(path, optimize=True)


if __name__ == "__main__":
    main(Path(__file__).with_suffix(".png"))
