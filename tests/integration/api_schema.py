"""Does a value fit a schema of the served OpenAPI document? The part of JSON Schema that the document uses."""

TYPES = {
    "string": lambda v: isinstance(v, str),
    "integer": lambda v: isinstance(v, int) and not isinstance(v, bool),
    "number": lambda v: isinstance(v, (int, float)) and not isinstance(v, bool),
    "boolean": lambda v: isinstance(v, bool),
    "object": lambda v: isinstance(v, dict),
    "array": lambda v: isinstance(v, list),
    "null": lambda v: v is None,
}


def mistakes(value, schema, document, where="$"):
    """A list of what does not fit; empty when all does."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[1]
        return mistakes(value, document["components"]["schemas"][name], document, where)
    if "oneOf" in schema:
        tried = [mistakes(value, one, document, where) for one in schema["oneOf"]]
        return [] if sum(not found for found in tried) == 1 else [f"{where}: fits not exactly one of oneOf: {tried}"]
    found = []
    kinds = schema.get("type")
    if kinds is not None:
        kinds = [kinds] if isinstance(kinds, str) else kinds
        if not any(TYPES[kind](value) for kind in kinds):
            return [f"{where}: {value!r} is not {kinds}"]
    if "enum" in schema and value not in schema["enum"]:
        found.append(f"{where}: {value!r} is none of {schema['enum']}")
    if isinstance(value, dict):
        found += [f"{where}: {name} is missing" for name in schema.get("required", []) if name not in value]
        properties = schema.get("properties", {})
        for name, part in value.items():
            part_schema = properties.get(name, schema.get("additionalProperties"))
            if part_schema:
                found += mistakes(part, part_schema, document, f"{where}.{name}")
    if isinstance(value, list) and "items" in schema:
        for index, part in enumerate(value[:200]):
            found += mistakes(part, schema["items"], document, f"{where}[{index}]")
    return found
