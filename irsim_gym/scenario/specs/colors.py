"""Known colours (matplotlib's names, and numbers), so that misspelt ones are reported with their line."""

import re
from typing import Any

from irsim_gym.base.errors import suggestion

_OTHER = re.compile(
    r"#([0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})|[bgrcmykw]|c[0-9]|none|0?\.[0-9]+|[01](\.0*)?"
    r"|tab:(blue|orange|green|red|purple|brown|pink|gr[ae]y|olive|cyan)",
    re.IGNORECASE,
)


def as_text(color: object) -> Any:
    """Convert red, green, blue and optional opacity from 0 to 1 to ``#rrggbb[aa]``; return other values unchanged."""
    if not isinstance(color, list | tuple) or len(color) not in (3, 4):
        return color
    if not all(isinstance(part, int | float) and not isinstance(part, bool) and 0 <= part <= 1 for part in color):
        return color
    return "#" + "".join(f"{round(255 * part):02x}" for part in color)


def color_problem(name: str | None) -> str:
    """Return what is wrong with a colour name; empty if it is valid or None."""
    if name is None or _OTHER.fullmatch(name):
        return ""
    from PIL.ImageColor import colormap  # the names of CSS, as in matplotlib

    lower = name.lower()
    return "" if lower in colormap else f"no colour named '{name[:40]}'{suggestion(lower[:40], colormap)}"
