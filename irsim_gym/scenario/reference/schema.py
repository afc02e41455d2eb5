"""The scenario language as a JSON Schema (draft 2020-12), for editors; it includes registered kinds of plugins."""

from typing import Any

from pydantic import TypeAdapter

from irsim_gym.base import families
from irsim_gym.base.registry import Registry
from irsim_gym.scenario.entries.entries import NO_DRIVE
from irsim_gym.scenario.reading.parameters import SECTION, ParameterSpec
from irsim_gym.scenario.specs import library
from irsim_gym.scenario.specs.gui_spec import GuiSpec
from irsim_gym.scenario.specs.plot_spec import ObjectPlot
from irsim_gym.scenario.specs.spec import BodyOptions
from irsim_gym.scenario.specs.world_spec import WorldSpec
from irsim_gym.scenario.text.source import ROLES, WRAPPER

Schema = dict[str, Any]

_PARAMETER = r"\$[A-Za-z_][A-Za-z0-9_]*"
EXPRESSION: Schema = {"type": "string", "pattern": rf"^(?:[-+*/(), .0-9eE]|pi|min|max|floor|{_PARAMETER})+$"}
PARAMETER: Schema = {"type": "string", "pattern": f"^{_PARAMETER}$"}
_REFERENCE = "#/$defs/{model}"


def json_schema() -> Schema:
    """Return the JSON Schema of scenario files."""
    families.load()
    definitions: Schema = {}
    sections = {
        "world": _optional(_world(definitions)),
        **{role: _section(role, definitions) for role in ROLES},
        "gui": _optional(_options(GuiSpec, definitions)),
        "plot": _optional(_options(ObjectPlot, definitions)),
        "task": _task(definitions),
        "levels": {"anyOf": [{"type": "string"}, {"type": "null"}], "description": "File of levels, .npz."},
        "custom": {"description": "Anything; the simulator does not read it."},
        SECTION: _optional(_parameters()),
    }
    wrapped = {"type": "object", "properties": sections, "additionalProperties": False}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scenario of irsim_gym",
        "type": "object",
        "properties": {**sections, WRAPPER: {**wrapped, "description": "All sections may stand under this key."}},
        "additionalProperties": False,
        "$defs": definitions,
    }


def _parameters() -> Schema:
    """Return the schema of the section ``parameters``."""
    schema: Schema = _with_expressions(TypeAdapter(ParameterSpec).json_schema())
    names = {"pattern": "^[A-Za-z_][A-Za-z0-9_]*$"}
    return {"type": "object", "propertyNames": names, "additionalProperties": {**schema, "additionalProperties": False}}


def _world(definitions: Schema) -> Schema:
    """Return the schema of the section ``world``, with the forms of ``obstacle_map``."""
    schema = _options(WorldSpec, definitions)
    info = schema["properties"]["obstacle_map"]
    columns: Schema = {"type": "array", "items": {"type": "array"}, "minItems": 1}
    choices = [{"type": "string"}, _named(families.MAPS, definitions), columns, {"type": "null"}]
    schema["properties"]["obstacle_map"] = {**info, "anyOf": choices}
    return schema


def _optional(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _options(cls: type[Any], definitions: Schema) -> Schema:
    """Return the schema of a kind's or spec's options; nested schemas are added to the definitions."""
    schema = TypeAdapter(cls).json_schema(ref_template=_REFERENCE)
    for name, nested in schema.pop("$defs", {}).items():
        definitions.setdefault(name, _with_expressions(nested))
    made: Schema = _with_expressions(schema)
    return made


def _with_expressions(schema: object) -> Any:
    """Allow expressions such as ``pi/2`` in place of numbers; drop empty units and consequences."""
    if isinstance(schema, list):
        return [_with_expressions(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    kept = {key: value for key, value in schema.items() if key not in ("unit", "consequence") or value != ""}
    if "properties" in schema:
        kept["properties"] = {key: _color_or(key, one) for key, one in schema["properties"].items()}
    if schema.get("type") in ("number", "integer"):
        numeric = ("type", "minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
        number = {key: kept.pop(key) for key in numeric if key in kept}
        return {"anyOf": [number, EXPRESSION], **kept}
    if schema.get("type") == "boolean" or "enum" in schema:
        one = {key: kept.pop(key) for key in ("type", "enum") if key in kept}
        return {"anyOf": [one, PARAMETER], **kept}
    return {
        key: value if key in ("default", "const", "enum") else _with_expressions(value) for key, value in kept.items()
    }


def _color_or(key: str, schema: Any) -> object:
    """Allow 3 or 4 numbers from 0 to 1 in place of colours."""
    choices = schema.get("anyOf", [schema])
    if not key.endswith("color") or not any(one.get("type") == "string" for one in choices):
        return schema
    kept = {name: value for name, value in schema.items() if name in ("description", "default", "unit", "title")}
    plain = [{name: value for name, value in one.items() if name not in kept} for one in choices]
    part = {"type": "number", "minimum": 0, "maximum": 1}
    return {**kept, "anyOf": [*plain, {"type": "array", "items": part, "minItems": 3, "maxItems": 4}]}


def _named(registry: Registry, definitions: Schema, synonym: str = "", default: str = "") -> Schema:
    """Return the schema of a choice between the kinds of a family."""
    choices = []
    for entry in registry:
        key = f"{registry.family}.{entry.name}".replace(" ", "_")
        schema = _options(entry.kind, definitions)
        name = {"const": entry.name, "description": "Which one."}
        keys = ["name", synonym] if synonym else ["name"]
        schema["properties"] = {**dict.fromkeys(keys, name), **schema.get("properties", {})}
        if entry.name != default:
            schema["anyOf"] = [{"required": [one]} for one in keys]
        schema["title"] = f"{registry.family} {entry.name}"
        definitions[key] = schema
        choices.append({"$ref": _REFERENCE.format(model=key)})
    if not choices:
        return {"not": {}}
    by_parameter = {"type": "object", "properties": {"name": PARAMETER}, "required": ["name"]}
    return {"anyOf": [*choices, by_parameter]}


def _section(role: str, definitions: Schema) -> Schema:
    declared = _options(BodyOptions, definitions)["properties"]
    properties = {key: _property(key, one, definitions) for key, one in declared.items()}
    properties["role"] = {"const": role, "description": "The name of the section; may be left out."}
    name = f"entry.{role}"
    definitions[name] = {"title": f"One entry of {role}", "type": "object", "properties": properties}
    definitions[name]["additionalProperties"] = False
    entry = {"$ref": _REFERENCE.format(model=name)}
    return {"anyOf": [entry, {"type": "array", "items": entry}, {"type": "null"}]}


def _property(key: str, declared: Schema, definitions: Schema) -> Schema:
    """Return the schema of one key of an entry, including lists of values for its bodies."""
    meaning = declared.get("description", "")
    if key in (*families.KINDS_OF_BODIES, "distribution"):
        named = _named(families.BY_KEY[key], definitions)
        one = {"anyOf": [named, {"type": "null"}, {"type": "object", "maxProperties": 0}]}
        if key == "kinematics":
            name = {"const": NO_DRIVE, "description": "It never moves."}
            one["anyOf"].append({"type": "object", "properties": {"name": name}, "additionalProperties": False})
        return {"description": meaning, **(one if key == "distribution" else _shared(one))}
    if key == "disturbances":
        several: Schema = {"type": "array", "items": _named(families.DISTURBANCES, definitions)}
        return {"description": meaning, "anyOf": [*_shared(several)["anyOf"], {"type": "null"}]}
    if key == "sensors":
        sensor = _named(families.SENSORS, definitions, synonym="type", default="lidar2d")
        sensors = {"anyOf": [sensor, {"type": "array", "items": sensor}]}
        return {"description": meaning, "anyOf": [*_shared(sensors)["anyOf"], {"type": "null"}]}
    if key == "goal":
        return {"description": meaning, "anyOf": [{"type": "array"}, {"type": "null"}]}
    one = dict(declared)
    if key in ("number", "number_range", "role", "preset"):
        return one if key != "preset" else {**one, "anyOf": [{"enum": [None, *library.names("robots")]}, PARAMETER]}
    info: Schema = {name: one.pop(name) for name in ("description", "default", "unit") if name in one}
    shared = _shared(one)
    return {**info, **shared}


def _shared(one: Schema) -> Schema:
    """Return the schema of one value for all bodies of an entry, or a list with one for each."""
    return {"anyOf": [one, {"type": "array", "items": one, "minItems": 1}]}


def _task(definitions: Schema) -> Schema:
    """Return the schema of the section ``task``; no key of a term is required, since terms may be overrides."""
    section = _options(families.SECTIONS.entry("task").kind, definitions)
    properties: Schema = section["properties"]
    for key in ("action", "observations", "rewards", "endings"):
        registry = families.BY_KEY[key]
        _named(registry, definitions)
        terms = []
        for entry in registry:
            definition = definitions.get(f"{registry.family}.{entry.name}".replace(" ", "_"))
            if definition is not None:
                definition.pop("required", None)
                definition["properties"]["use"] = {"type": "boolean", "description": "false leaves the term out."}
                terms.append({"$ref": _REFERENCE.format(model=f"{registry.family}.{entry.name}".replace(" ", "_"))})
        term: Schema = {"anyOf": [*terms, {"type": "string"}]}
        described = {"description": properties[key]["description"]}
        properties[key] = {**described, **(term if key == "action" else {"type": "array", "items": term})}
    section["additionalProperties"] = False
    return {"anyOf": [{"type": "string"}, section, {"type": "null"}]}
