"""Names of the files to which pictures, films and pages are written."""

from collections.abc import Mapping
from pathlib import Path

FILMS = (".mp4", ".gif")
PAGES = (".html",)
FIGURES = (".png", ".pdf", ".svg", ".jpg", ".jpeg", ".eps", ".ps", ".tif", ".tiff", ".webp")


def target(path: str | Path | None, name: str) -> Path:
    """Return the file of a path, by default one with this name.

    Raises:
        ValueError: It is a folder.
    """
    chosen = Path(name if path is None else path)
    if path is not None and chosen.is_dir():
        inside = chosen / name
        raise ValueError(
            f"'{path}' is a folder: name a file, such as '{inside}' in it or '{chosen.name or name}.png' beside it"
        )
    return chosen


def with_suffix(path: Path, suffixes: tuple[str, ...], default: str) -> Path:
    """Return the path with a suffix; a point in a name such as ``run-0.5`` begins none."""
    if not path.stem.strip(" .") or path.name.lower() in suffixes:
        raise ValueError(f"a file needs a name before its suffix, such as 'world.{default}', got '{path.name}'")
    if path.suffix.lower() in suffixes:
        return path
    if path.suffix and not path.suffix[1:].isdigit():
        raise ValueError(f"the file's name must end in {', '.join(suffixes)}, got '{path.name}'")
    return path.with_name(f"{path.name}.{default}")


def film_file(options: Mapping[str, object], name: str) -> Path:
    """Return the file of a film: the given one, else the name of the world, with the given suffix."""
    chosen, suffix = Path(str(options.get("ani_name") or name)), options.get("suffix")
    return chosen.with_name(f"{chosen.name}{suffix}") if suffix and chosen.suffix.lower() not in FILMS else chosen
