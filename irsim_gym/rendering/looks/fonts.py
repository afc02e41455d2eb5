"""Finds fonts with the letters of a text: the default font, else installed ones, else a box in place of the letter."""

import functools
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from PIL import ImageFont

from irsim_gym.base.errors import IrsimGymError

USUAL = "DejaVuSans.ttf", "DejaVuSans-Bold.ttf"
FAMILY = "DejaVu Sans"
BOX = "\N{WHITE SQUARE}"
NOBODY = "\U0010ffff"
"""A character that no font has, drawn like all missing characters."""
LOOKED_AT = 16
PLAIN = ("400", "normal", "regular", "book")
"""Weights of letters that are not bold."""
Runs = tuple[tuple[str, Path], ...]


def usual(*, bold: bool) -> Path:
    """Return the default font, which is part of matplotlib, without importing matplotlib.

    Raises:
        IrsimGymError: If the font is not found.
    """
    name, spec = USUAL[bold], find_spec("matplotlib")
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        file = Path(folder) / "mpl-data" / "fonts" / "ttf" / name
        if file.is_file():
            return file
    raise IrsimGymError(f"no font {name!r}: it comes with matplotlib, which is not installed as a folder of files")


@functools.lru_cache(maxsize=2048)
def runs(words: str, *, bold: bool = False) -> Runs:
    """Split a text into parts, each with a font that has its letters; a box replaces letters that no font has.

    Invisible characters, such as direction marks, are omitted if the default font lacks them. If a bold letter is
    missing in the default font but another font has it, the whole text is not bold, since few fonts have other scripts
    in bold.
    """
    usual_font, plain = usual(bold=bold), usual(bold=False)
    missing = {letter for letter in words if _is_missing(usual_font, letter)}
    if bold and any(not _is_missing(plain, letter) or _installed_with(letter) for letter in missing):
        return runs(words)
    parts = list[tuple[str, Path]]()
    for letter in words:
        font: Path | None = usual_font
        if letter in missing:
            if not letter.isprintable():
                continue
            font = _installed_with(letter)
            letter, font = (BOX, usual_font) if font is None else (letter, font)
        assert font is not None
        if parts and parts[-1][1] == font:
            parts[-1] = parts[-1][0] + letter, font
        else:
            parts.append((letter, font))
    return tuple(parts)


def families(words: str, *, bold: bool = False) -> tuple[str, dict[str, Any]]:
    """Return the drawable form of a text, and matplotlib's arguments for it: fonts, weight, and that $ is a letter."""
    parts = runs(words, bold=bold)
    usual_fonts = {usual(bold=False), usual(bold=True)}
    names = [_family_of(font) for _, font in parts if font not in usual_fonts]
    weight = "bold" if parts and parts[0][1] == usual(bold=True) else "normal"
    look = {"family": list(dict.fromkeys([FAMILY, *names])), "weight": weight, "parse_math": False}
    return "".join(part for part, _ in parts), look


def label(words: str) -> str:
    """Return a text as matplotlib takes it in legends, where $ begins a formula and a leading _ hides the entry."""
    return ("\N{ZERO WIDTH SPACE}" if words.startswith("_") else "") + words.replace("$", r"\$")


def _is_missing(font: Path, letter: str) -> bool:
    return letter != "\n" and not (letter.isascii() and letter.isprintable()) and not _has(font, letter)


@functools.lru_cache(maxsize=4096)
def _has(font: Path, letter: str) -> bool:
    """Return whether a font has a letter."""
    looked_at = _opened(font)
    # A font draws all letters that it lacks alike: a letter that looks like one that no font has is missing.
    return looked_at is not None and bytes(looked_at.getmask(letter)) != bytes(looked_at.getmask(NOBODY))


@functools.lru_cache(maxsize=4)
def _opened(font: Path) -> Any:
    try:
        return ImageFont.truetype(str(font), LOOKED_AT, layout_engine=ImageFont.Layout.BASIC)
    except OSError:  # a bitmap font, or another unsupported kind
        return None


@functools.lru_cache(maxsize=1024)
def _installed_with(letter: str) -> Path | None:
    """Return the first installed font that has a letter, or None."""
    return next((font for font in (*_installed(), *_unlisted()) if _has(font, letter)), None)


@functools.lru_cache(maxsize=1)
def _installed() -> dict[Path, str]:
    """Return the upright fonts that matplotlib knows, sans-serif ones first, with the names of their families."""
    from matplotlib.font_manager import fontManager

    listed = [font for font in fontManager.ttflist if font.style == "normal" and str(font.weight) in PLAIN]
    listed.sort(key=lambda font: ("Sans" not in font.name, "Mono" in font.name, font.name))
    return {Path(font.fname): font.name for font in listed if font.name != FAMILY}


@functools.lru_cache(maxsize=1)
def _unlisted() -> tuple[Path, ...]:
    """Return fonts that are not in matplotlib's list, for example because they were installed later."""
    from matplotlib.font_manager import findSystemFonts, fontManager

    listed = {font.fname for font in fontManager.ttflist}
    return tuple(Path(file) for file in sorted(findSystemFonts()) if file not in listed)


def _family_of(font: Path) -> str:
    """Return matplotlib's family name of a font, after adding the font to matplotlib's list if necessary."""
    from matplotlib.font_manager import fontManager

    if font in _installed():
        return _installed()[font]
    listed = {entry.fname: entry.name for entry in fontManager.ttflist}
    if str(font) not in listed:
        fontManager.addfont(str(font))
        listed = {entry.fname: entry.name for entry in fontManager.ttflist}
    return listed[str(font)]
