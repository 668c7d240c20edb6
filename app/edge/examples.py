"""An example of what a route takes, made from its schema."""

from typing import Any

_BY_FORMAT = {"date": "1956-03-14", "date-time": "2026-11-22T09:30:00Z", "binary": "(the file)"}
_BY_TYPE: dict[str, Any] = {"string": "text", "integer": 1, "number": 1.0, "boolean": True, "null": None}
_DEEPEST = 6


def example(schema: dict[str, Any], components: dict[str, Any], depth: int = 0) -> Any:
    """Return a value that a schema describes: its own example or default, else required fields only.

    Parameters
    ----------
    schema : dict
        JSON schema, with references into `components`.
    components : dict
        Schemas by name.
    depth : int
        Of the schema in its document; a schema within itself ends.
    """
    if "$ref" in schema:
        schema = components[schema["$ref"].rsplit("/", 1)[-1]]
    for key in ("example", "const", "default"):
        if schema.get(key) is not None:
            return schema[key]
    for key in ("examples", "enum"):
        if schema.get(key):
            return schema[key][0]
    for key in ("anyOf", "oneOf", "allOf"):
        if schema.get(key):
            return example(schema[key][0], components, depth + 1)
    kind = schema.get("type", "string")
    if depth > _DEEPEST:
        return None
    if kind == "object":
        required = schema.get("required", ())
        return {
            name: example(one, components, depth + 1)
            for name, one in schema.get("properties", {}).items()
            if name in required
        }
    if kind == "array":
        items = schema.get("prefixItems") or [schema.get("items", {})] * schema.get("minItems", 1)
        return [example(one, components, depth + 1) for one in items]
    if kind in ("integer", "number"):
        return _number(schema, _BY_TYPE[kind])
    if kind == "string" and "format" not in schema:
        return "text".ljust(schema.get("minLength", 0), "-")[: schema.get("maxLength")]
    return _BY_FORMAT.get(schema.get("format", ""), _BY_TYPE.get(kind))


def _number(schema: dict[str, Any], plain: float) -> float:
    """Return a number inside its bounds, one where that is possible."""
    least = schema.get("minimum", schema.get("exclusiveMinimum", plain))
    most = schema.get("maximum", schema.get("exclusiveMaximum", plain))
    if least < plain < most or plain in (schema.get("minimum"), schema.get("maximum")):
        return plain
    middle = least / 2 + most / 2 if most > least else least
    return type(plain)(middle)
