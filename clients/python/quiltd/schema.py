"""Checks parameters by the schemas of `hello`, before they are sent."""

import difflib
import inspect
import keyword
import math
import numbers
from typing import Any, Dict, List, Sequence

from .errors import ParameterError

Schema = Dict[str, Any]
_PYTHON = {"string": str, "boolean": bool, "integer": int, "number": float, "object": dict, "array": list, "null": type(None)}


def _simple(value: Any) -> Any:
    """Numbers, strings and arrays of numpy as Python's own; others as they are."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return value
    if isinstance(value, numbers.Integral):
        return int(value)
    if isinstance(value, numbers.Real):
        return float(value)
    return list(value) if isinstance(value, tuple) else value


def _types(schema: Schema) -> List[str]:
    kind = schema.get("type", [])
    return [kind] if isinstance(kind, str) else list(kind)


def _is(value: Any, kind: str) -> bool:
    if isinstance(value, bool):
        return kind == "boolean"
    if kind == "number":
        return isinstance(value, (int, float)) and math.isfinite(value)
    if kind == "integer" and isinstance(value, float):
        return value.is_integer()
    return isinstance(value, _PYTHON.get(kind, object))


def did_you_mean(word: str, words: Sequence[str]) -> str:
    """The end of a message: the nearest of these words, if one is near."""
    near = difflib.get_close_matches(word, words, 1)
    return f'; did you mean "{near[0]}"?' if near else ""


def _value(where: str, value: Any, schema: Schema) -> Any:
    value = _simple(value)
    kinds = _types(schema)
    if kinds and not any(_is(value, kind) for kind in kinds):
        raise ParameterError(f"{where}: expected {' or '.join(kinds)}, not {value!r}")
    if isinstance(value, str):
        words = schema.get("enum", schema.get("words"))
        if value in schema.get("refused", {}):
            raise ParameterError(f"{where}: {value} {schema['refused'][value]}")
        if words is not None and value not in words:
            raise ParameterError(f'{where}: "{value}" is none of {", ".join(map(str, words))}{did_you_mean(value, list(map(str, words)))}')
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        low, high = schema.get("minimum", -math.inf), schema.get("maximum", math.inf)
        if not low <= value <= high or value not in schema.get("enum", [value]):
            allowed = ", ".join(map(str, schema["enum"])) if "enum" in schema else f"{low:g} to {high:g}"
            raise ParameterError(f"{where}: {value} is out of range: {allowed} {schema.get('unit', '')}".rstrip())
    elif isinstance(value, list):
        low, high = schema.get("minItems", 0), schema.get("maxItems", math.inf)
        if not low <= len(value) <= high:
            raise ParameterError(f"{where}: {len(value)} values, expected {low} to {high}")
        return [_value(f"{where}[{i}]", item, schema.get("items", {})) for i, item in enumerate(value)]
    elif isinstance(value, dict):
        return check(where, value, schema)
    return value


def check(where: str, params: Dict[str, Any], schema: Schema) -> Dict[str, Any]:
    """The parameters as they are sent. Raises ParameterError for the first that is wrong."""
    known = schema.get("properties", {})
    for name in params:
        if not isinstance(name, str):
            raise ParameterError(f"{where}: the key {name!r} is no string")
        if name not in known and schema.get("additionalProperties", True) is False:
            raise ParameterError(f'{where}: unknown parameter "{name}"{did_you_mean(name, list(known))}')
    for name in schema.get("required", []):
        if name not in params:
            raise ParameterError(f'{where}: the parameter "{name}" is missing')
    return {name: _value(f"{where}: {name}", value, known[name]) if name in known else value for name, value in params.items()}


def python_name(name: str) -> str:
    """`from` and `for` are words of Python: they get an underscore."""
    return name + "_" if keyword.iskeyword(name) else name


def names_of(method: str, schema: Schema, positional: Sequence[Any], named: Dict[str, Any]) -> Dict[str, Any]:
    """Parameters by the names of the protocol. Required ones may come by position; None leaves one out."""
    required = schema.get("required", [])
    if len(positional) > len(required):
        raise ParameterError(f"{method}: parameters have names: {', '.join(schema.get('properties', {})) or 'none'}")
    params = dict(zip(required, positional))
    protocol_names = {python_name(name): name for name in schema.get("properties", {})}
    for name, value in named.items():
        name = protocol_names.get(name, name)
        if name in params:
            raise ParameterError(f'{method}: "{name}" is given twice')
        if value is not None:
            params[name] = value
    return params


def signature(schema: Schema) -> inspect.Signature:
    """What help() and completion show."""
    parameters = []
    required = schema.get("required", [])
    properties = schema.get("properties", {})
    for name in [*required, *(name for name in properties if name not in required)]:
        about = properties[name]
        if about.get("deprecated"):
            continue
        kinds = [_PYTHON[kind] for kind in _types(about) if kind in _PYTHON]
        parameters.append(
            inspect.Parameter(
                python_name(name),
                inspect.Parameter.POSITIONAL_OR_KEYWORD if name in required else inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if name in required else about.get("default"),
                annotation=kinds[0] if len(kinds) == 1 else inspect.Parameter.empty,
            )
        )
    return inspect.Signature(parameters)


def manual(about: Dict[str, Any]) -> str:
    """The docstring of a method, from its entry in `hello`."""
    lines = [about.get("summary", ""), ""]
    for name, parameter in about.get("params", {}).get("properties", {}).items():
        if parameter.get("deprecated"):
            continue
        unit = f" [{parameter['unit']}]" if "unit" in parameter else ""
        lines.append(f"{python_name(name)}: {parameter.get('description', '')}{unit}")
    return "\n".join(lines).strip()
