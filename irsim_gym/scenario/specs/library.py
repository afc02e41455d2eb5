"""Locates the shipped configs; no other module knows their place."""

import functools
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from irsim_gym.base.errors import IrsimGymError, UnknownNameError, suggestion

SUFFIXES = (".yaml", ".yml")


@functools.cache
def configs_folder() -> Path:
    """Return the folder of the shipped configs: in an installed package, else in the repository."""
    package = Path(__file__).resolve().parents[2]
    inside = package / "configs"
    return inside if inside.is_dir() else package.parent / "configs"


def names(section: str = "scenarios") -> dict[str, Path]:
    """Return the shipped configs of a section, in alphabetical order. No file is read.

    Args:
        section: ``scenarios`` (examples), ``benchmarks`` (scenarios of the suite), ``mixtures``, ``robots`` or
            ``tasks``.
    """
    folder = configs_folder() / section
    files = sorted(folder.iterdir()) if folder.is_dir() else []
    return {file.stem: file for file in files if file.suffix in SUFFIXES}


@functools.cache
def assets(folder: str) -> Mapping[str, Path]:
    """Return the shipped files in ``maps``, ``images`` or ``recordings`` by file name, in alphabetical order."""
    files = sorted((configs_folder() / folder).iterdir())
    return MappingProxyType({file.name: file for file in files if file.suffix in (".png", ".txt")})


def asset(folder: str, name: str, scenario_file: str) -> Path:
    """Return a file that a scenario names: beside the scenario, else a shipped one. It need not exist."""
    file, shipped = Path(scenario_file).parent / name, assets(folder)
    return shipped[name] if name in shipped and not file.is_file() else file


def write_template(file: Path) -> None:
    """Write a commented scenario to start from.

    Raises:
        IrsimGymError: If the file exists, has another suffix, or its folder does not exist.
    """
    if file.suffix not in SUFFIXES:
        raise IrsimGymError(f"a scenario is a .yaml file, got '{file}'")
    if not file.parent.is_dir():
        raise IrsimGymError(f"there is no folder {file.parent}")
    text = (configs_folder() / "templates" / "scenario.yaml").read_text(encoding="utf-8")
    try:
        with file.open("x", encoding="utf-8") as out:
            out.write(text.replace("FILE", str(file)).replace("FILM.gif", f"{file.stem}.gif"))
    except FileExistsError:
        raise IrsimGymError(f"{file} exists; choose another name") from None


def scenario_names() -> tuple[str, ...]:
    """Return the names of the shipped scenarios, except benchmarks."""
    return tuple(names("scenarios"))


def benchmark_names() -> tuple[str, ...]:
    """Return the names of the shipped scenarios in ``configs/benchmarks``."""
    return tuple(names("benchmarks"))


def suite_file() -> Path:
    """Return the file that lists the benchmarks of the suite."""
    return configs_folder() / "suite.yaml"


def references_file() -> Path:
    """Return the file with the results of the reference policies on the suite."""
    return configs_folder() / "suite_references.json"


def every_scenario() -> dict[str, Path]:
    """Return all shipped scenarios, benchmarks last."""
    return {**names("scenarios"), **names("benchmarks")}


def find(name: str | Path, section: str = "scenarios") -> Path:
    """Return the file of a shipped name or a path.

    A name without folder and suffix is looked up among the shipped files first.

    Args:
        name: A name, or the path of a file, which need not exist.
        section: Folder of the shipped files, such as ``"scenarios"`` or ``"tasks"``.

    Raises:
        UnknownNameError: If nothing is shipped under the name; the message suggests the nearest name, also of files in
            the working directory.
    """
    path = Path(name)
    if isinstance(name, Path) or path.suffix in SUFFIXES or len(path.parts) != 1:
        return path
    shipped = every_scenario() if section == "scenarios" else names(section)
    if str(name) in shipped:
        return shipped[str(name)]
    if path.is_file() or path.is_dir():
        return path
    one = section.removesuffix("s")
    shown = str(name)[:60]
    here = sorted(file.name for file in Path().glob("*.y*ml") if file.suffix in SUFFIXES)
    offer = f"; shipped: {', '.join(shipped) or 'none'}; a file needs its suffix, .yaml"
    near = suggestion(shown, [*shipped, *here]) or offer
    raise UnknownNameError(f"no {one} named '{shown}'{near}")
