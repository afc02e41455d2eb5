"""The theme: default colours, line widths and type sizes.

Widths and type sizes are points of a figure whose resolution grows with its size, so that a large frame is an
enlarged small one.
"""

FONT = "DejaVu Sans"

PAPER = "#F6F7F9"
CARD = "#FFFFFF"
GRID = "#EDF0F3"
RULE = "#C5CCD4"
INK = "#1F2933"
INK_LIGHT = "#7B8794"
SHADOW = "#1F2933"

ROBOT = "#009E73"
BEAM = "#F97316"
FIELD = "#56B4E9"
FIELD_EDGE = "#0072B2"
MAP = "#334155"
FOG = "#C3CAD3"
HEADING = "#FFFFFF"
GOAL_ARROW = (7.0, 6.0, 3.0, 0.55)
"""Dimensions of the arrow at a goal with a heading: minimum length of the shaft, length and half width of the head, and
half width of the shaft [point]. The shaft ends at the circle."""
SHADOWS = ((2.2, 0.05), (1.2, 0.07))
"""Shift [point] and opacity of each shadow."""
FLAG = (6.5, 10.5)
"""Width and height of a goal's flag [point]."""
FLAG_POLE = ((0.0, 0.0), (0.0, 10.0))
FLAG_PENNANT = ((0.0, 10.0), (6.25, 7.75), (0.0, 5.5))
"""Corners of a flag's parts, relative to its foot, y upwards [point]."""
GOAL_FILL, REACHED_FILL, FILLED_RADIUS = 0.14, 0.30, 18.0
"""Opacity of a goal's circle before and after arrival, and the radius [point] above which it falls with the area."""
PATH_WIDTH = 1.9
"""Default width of a path [point]."""
IMPACT = "#DC2626"

OUTCOMES = {
    "success": "#0B9F6E",
    "arrived": "#0B9F6E",
    "collision": IMPACT,
    "timeout": "#D97706",
    "left_world": "#7C3AED",
    "misplaced": "#DB2777",
}
RUNNING = "#3B82F6"


def status_colour(status: str) -> str:
    """Return the colour of a status, by default that of a running episode."""
    return OUTCOMES.get(status_key(status), RUNNING)


def ends_episode(status: str) -> bool:
    """Return whether a status is an outcome, which tints the frame."""
    return status_key(status) in OUTCOMES


def status_key(status: str) -> str:
    """Return a status in the spelling of outcomes: ``"Left world"`` becomes ``left_world``."""
    return status.strip().lower().replace(" ", "_")
