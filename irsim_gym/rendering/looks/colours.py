"""Colours by matplotlib's names, without matplotlib."""

import re

from PIL import ImageColor

Colour = tuple[float, float, float, float]

CLEAR: Colour = (0.0, 0.0, 0.0, 0.0)
LETTERS = {
    "b": (0.0, 0.0, 255.0),
    "g": (0.0, 127.5, 0.0),
    "r": (255.0, 0.0, 0.0),
    "c": (0.0, 191.25, 191.25),
    "m": (191.25, 0.0, 191.25),
    "y": (191.25, 191.25, 0.0),
    "k": (0.0, 0.0, 0.0),
    "w": (255.0, 255.0, 255.0),
}
TABLEAU = {
    "blue": "#1f77b4",
    "orange": "#ff7f0e",
    "green": "#2ca02c",
    "red": "#d62728",
    "purple": "#9467bd",
    "brown": "#8c564b",
    "pink": "#e377c2",
    "gray": "#7f7f7f",
    "olive": "#bcbd22",
    "cyan": "#17becf",
}


def colour(name: str, opacity: float) -> Colour:
    """Return red, green, blue [0, 255] and the opacity; the colour ``none`` is transparent.

    Args:
        name: A CSS name, ``tab:`` with a Tableau name, ``C0`` to ``C9``, one letter, a grey from ``0`` to ``1``, or
            ``#`` with three, four, six or eight digits, of which those of the opacity are ignored.
        opacity: The opacity [0, 1].
    """
    text = name.lower()
    if text == "none":
        return CLEAR
    if text in LETTERS:
        return (*LETTERS[text], opacity)
    if re.fullmatch(r"c\d", text):
        text = list(TABLEAU.values())[int(text[1])]
    elif text.startswith("tab:"):
        text = TABLEAU[text[4:].replace("grey", "gray")]
    elif re.fullmatch(r"[01]?\.?\d*", text):
        grey = 255.0 * float(text)
        return grey, grey, grey, opacity
    red, green, blue = ImageColor.getrgb(text)[:3]
    return float(red), float(green), float(blue), opacity


def shade(name: str, share: float, opacity: float) -> Colour:
    """Return a colour darkened to a share of its red, green and blue."""
    red, green, blue, opacity = colour(name, opacity)
    return share * red, share * green, share * blue, opacity
