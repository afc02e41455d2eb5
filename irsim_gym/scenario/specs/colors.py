"""Known colours (matplotlib's names, and numbers), so that misspelt ones are reported with their line."""

import re
from typing import Any

from irsim_gym.base.errors import suggestion

_TEXT = """
aliceblue antiquewhite aqua aquamarine azure beige bisque black blanchedalmond blue blueviolet brown
burlywood cadetblue chartreuse chocolate coral cornflowerblue cornsilk crimson cyan darkblue darkcyan
darkgoldenrod darkgray darkgreen darkgrey darkkhaki darkmagenta darkolivegreen darkorange darkorchid darkred
darksalmon darkseagreen darkslateblue darkslategray darkslategrey darkturquoise darkviolet deeppink
deepskyblue dimgray dimgrey dodgerblue firebrick floralwhite forestgreen fuchsia gainsboro ghostwhite gold
goldenrod gray green greenyellow grey honeydew hotpink indianred indigo ivory khaki lavender lavenderblush
lawngreen lemonchiffon lightblue lightcoral lightcyan lightgoldenrodyellow lightgray lightgreen lightgrey
lightpink lightsalmon lightseagreen lightskyblue lightslategray lightslategrey lightsteelblue lightyellow
lime limegreen linen magenta maroon mediumaquamarine mediumblue mediumorchid mediumpurple mediumseagreen
mediumslateblue mediumspringgreen mediumturquoise mediumvioletred midnightblue mintcream mistyrose moccasin
navajowhite navy oldlace olive olivedrab orange orangered orchid palegoldenrod palegreen paleturquoise
palevioletred papayawhip peachpuff peru pink plum powderblue purple rebeccapurple red rosybrown royalblue
saddlebrown salmon sandybrown seagreen seashell sienna silver skyblue slateblue slategray slategrey snow
springgreen steelblue tan teal thistle tomato turquoise violet wheat white whitesmoke yellow yellowgreen
"""
NAMES = frozenset(_TEXT.split())

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
    if name is None or name.lower() in NAMES or _OTHER.fullmatch(name):
        return ""
    return f"no colour named '{name[:40]}'{suggestion(name[:40].lower(), NAMES)}"
