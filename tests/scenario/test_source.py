"""What cannot be read at all, and the lines of what can."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from irsim_gym.errors import ScenarioError, UnknownNameError
from irsim_gym.scenario import MissingFileError, load_scenario
from irsim_gym.scenario.text.source import MAX_BYTES, read_file

LAUGHS = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{b}: &{b} [{', '.join(['*' + a] * 10)}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
MERGED_LAUGHS = "a: &a {x: 1}\n" + "".join(
    f"{b}: &{b} {{<<: [{', '.join(['*' + a] * 10)}]}}\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
UNREADABLE = {
    "empty": (b"", "0 the file is empty"),
    "comment only": (b"# nothing\n", "0 the file is empty"),
    "null": (b"~\n", "1 must be a mapping with sections such as world, robot and obstacle, got nothing"),
    "scalar": (b"hello\n", "1 must be a mapping with sections such as world, robot and obstacle, got 'hello'"),
    "list": (b"- 1\n- 2\n", "1 must be a mapping with sections such as world, robot and obstacle, got [1, 2]"),
    "tab": (b"world:\n\twidth: 3\n", "2 tabs cannot indent YAML: use spaces"),
    "tab after spaces": (
        b"robot:\n  - shape: {name: circle}\n  \tstate: [1, 2]\n",
        "3 tabs cannot indent YAML: use spaces",
    ),
    "two documents": (b"world: {}\n---\nworld: {}\n", "2 only one document per file: a second '---' begins here"),
    "indentation": (
        b"world:\n  width: 3\n   height: 4\n",
        "3 not valid YAML: indented deeper than line 2, whose key already has a value",
    ),
    "NUL": (b"world:\n  name: \x00\n", "2 not YAML: it contains a character that is not text"),
    "control character": (b"world:\n  name: a\x07b\n", "2 not YAML: it contains a character that is not text"),
    "latin-1": (b"world:\n  name: caf\xe9\n", "2 not UTF-8 text (byte 0xe9)"),
    "utf-16": ("world: {}".encode("utf-16"), "1 not UTF-8 text (byte 0xff)"),
    "open brackets": (b"a: " + b"[" * 5000, "1 nested deeper than 40 levels"),
    "deep": (b"a: " + b"[" * 100 + b"]" * 100, "1 nested deeper than 40 levels"),
    "laughs": (LAUGHS.encode(), "1 more than 100000 values (after aliases are expanded)"),
    "merged laughs": (MERGED_LAUGHS.encode(), "1 more than 100000 values (after aliases are expanded)"),
    "anchor in itself": (b"world: &a\n  width: 3\n  plot: *a\n", "3 world.plot: anchor '&a' contains itself"),
    "list in itself": (b"robot: &r\n  - *r\n", "2 robot[0]: anchor '&r' contains itself"),
    "merge in itself": (b"world: &a\n  <<: *a\n", "2 world: anchor '&a' contains itself"),
    "no anchor": (b"world: *w\n", "1 world: no anchor named '&w'"),
    "python object": (
        b"world: !!python/object/apply:os.system ['true']\n",
        "1 world: the tag '!!python/object/apply:os.system' is not allowed",
    ),
    "own tag": (b"world:\n  width: !foo 3\n", "2 world.width: the tag '!foo' is not allowed"),
    "binary": (b"world: {name: !!binary aGVsbG8=}\n", "1 world.name: the tag '!!binary' is not allowed"),
    "number as key": (b"world:\n  1: 2\n", "2 world: keys must be text, got 1"),
    "list as key": (b"world:\n  [1, 2]: 2\n", "2 world: keys must be text, got a list or mapping"),
    "true as key": (b"world:\n  yes: 2\n", "2 world: keys must be text, got true"),
    "huge integer": (b"world:\n  width: " + b"9" * 5000 + b"\n", "2 world.width: not a readable number: " + "9" * 40),
    "merge of a number": (b"world:\n  <<: 3\n", "2 world: '<<' merges mappings only"),
}


@pytest.mark.parametrize("case", UNREADABLE)
def test_unreadable(case: str, tmp_path: Path) -> None:
    content, expected = UNREADABLE[case]
    file = tmp_path / "bad.yaml"
    file.write_bytes(content)
    with pytest.raises(ScenarioError) as caught:
        load_scenario(file)
    (problem,) = caught.value.problems
    assert f"{problem.line} {problem.path + ': ' if problem.path else ''}{problem.message}" == expected
    assert str(caught.value).startswith(f"1 problem in {file}\n  {file}")


def test_duplicate_keys_are_all_told(problems: Callable[[str], list[str]]) -> None:
    text = "world:\n  width: 3\n  height: 2\n  width: 4\nrobot:\n  - {name: a,\n     name: b}\nplot: 1\nplot: 2\n"
    assert problems(text) == [
        "4 world.width: given twice (first in line 2)",
        "7 robot[0].name: given twice (first in line 6)",
        "9 plot: must be a mapping of options, got 2",
    ]


def test_a_large_file_is_not_read(tmp_path: Path) -> None:
    file = tmp_path / "large.yaml"
    with file.open("wb") as stream:
        stream.truncate(50_000_000)
    with pytest.raises(ScenarioError, match=r"too large: 50\.0 MB, at most 2\.1 MB"):
        load_scenario(file)


def test_many_values_are_not_expanded(tmp_path: Path) -> None:
    file = tmp_path / "many.yaml"
    file.write_bytes((b"- [" + b"1," * 997 + b"1]\n") * 1000)
    assert file.stat().st_size < MAX_BYTES
    with pytest.raises(ScenarioError, match="more than 100000 values"):
        load_scenario(file)


def test_a_folder(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="is a directory, not a YAML file"):
        load_scenario(tmp_path)


def test_a_device() -> None:
    with pytest.raises(ScenarioError, match="is not a regular file"):
        load_scenario("/dev/null")


@pytest.mark.parametrize("name", ["no/such.yaml", "such.yml", Path("such")])
def test_no_file(name: str | Path) -> None:
    with pytest.raises(MissingFileError, match="no such file") as caught:
        load_scenario(name)
    assert isinstance(caught.value, ScenarioError)
    assert isinstance(caught.value, FileNotFoundError)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_impossible_paths() -> None:
    for name in ["a\0b.yaml", "x" * 300 + ".yaml"]:
        with pytest.raises(ScenarioError, match="cannot be read"):
            load_scenario(name)


def test_unknown_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        UnknownNameError, match=r"no scenario named 'cluttred_room' \(did you mean 'cluttered_room'\?\)"
    ):
        load_scenario("cluttred_room")
    with pytest.raises(UnknownNameError, match=r"no scenario named 'zzz'; shipped: .*empty_goal"):
        load_scenario("zzz")
    (tmp_path / "my_world.yaml").touch()
    monkeypatch.chdir(tmp_path)
    for name in ("my_world.ymal", "my_world"):  # a file beside the caller, with a misspelt suffix or none
        with pytest.raises(UnknownNameError, match=r"\(did you mean 'my_world.yaml'\?\)"):
            load_scenario(name)


@pytest.mark.parametrize("value", [None, 3, b"cluttered_room", ["a"]])
def test_other_types(value: object) -> None:
    with pytest.raises(TypeError, match="a scenario is a name, a path or a mapping"):
        load_scenario(value)  # type: ignore[arg-type]


def test_byte_order_mark_and_windows_lines(tmp_path: Path) -> None:
    file = tmp_path / "windows.yaml"
    file.write_bytes(b"\xef\xbb\xbfworld:\r\n  width: 3\r\n  height: 4\r\n")
    world = load_scenario(file).world
    assert (world.width, world.height) == (3.0, 4.0)


def test_lines_of_values(tmp_path: Path) -> None:
    file = tmp_path / "lines.yaml"
    file.write_text("a:\n  - b: 1\n    c:\n      [2,\n       3]\n  - &d {e: 4}\nf: *d\n")
    source = read_file(file)
    expected = {
        ("a",): 1,
        ("a", 0): 2,
        ("a", 0, "b"): 2,
        ("a", 0, "c"): 3,
        ("a", 0, "c", 0): 4,
        ("a", 0, "c", 1): 5,
        ("a", 1): 6,
        ("a", 1, "e"): 6,
        ("f",): 7,
        ("f", "e"): 6,
    }
    assert {place: source.line(place) for place in expected} == expected
    assert source.line(("a", 0, "missing", "deep")) == 2
    assert source.line(("nothing",)) == 1


def test_merge_keys(tmp_path: Path) -> None:
    file = tmp_path / "merge.yaml"
    file.write_text("a: &a {x: 1, y: 2}\nb: &b {y: 3, z: 4}\nc: {<<: [*a, *b], x: 0}\nd:\n  <<: *b\n  '<<': 5\n")
    data = read_file(file).data
    assert data["c"] == {"x": 0, "y": 2, "z": 4}
    assert data["d"] == {"y": 3, "z": 4, "<<": 5}


def test_mapping_of_python_values() -> None:
    world = {"width": np.float64(4.0), "offset": np.array([1.0, 2.0]), "height": np.int64(3)}
    scenario = load_scenario({"world": world, "robot": ({"state": (1, 2, "pi")},)})
    assert (scenario.world.width, scenario.world.height, scenario.world.offset) == (4.0, 3.0, (1.0, 2.0))
    assert scenario.bodies[0].state == (1.0, 2.0, np.pi)
    assert scenario.file == ""


def test_mappings_that_cannot_be() -> None:
    loop: dict[str, object] = {}
    loop["custom"] = loop
    with pytest.raises(ScenarioError, match="nested deeper than 40 levels"):
        load_scenario(loop)
    with pytest.raises(ScenarioError, match=r"custom: must be plain data, got an object of type object"):
        load_scenario({"custom": object()})
    with pytest.raises(ScenarioError, match="keys must be text, got 3"):
        load_scenario({"world": {3: 4}})
