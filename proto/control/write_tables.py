#!/usr/bin/env python3
"""Writes the tables of reference.md in this folder from openrpc.json: what stands between its marks of begin and end.
Breaks the lines of openrpc.json and report.schema.json, which tests write.

    write_tables.py            writes
    write_tables.py --check    ends 1, and says so, where one of them is not what this would write
"""
import json
import pathlib
import re
import sys
import textwrap

HERE = pathlib.Path(__file__).parent
PAGE = HERE / "reference.md"
PROTOCOL = HERE / "openrpc.json"
SCHEMA = HERE / "report.schema.json"
COLUMNS = 140
LONGEST_ANSWER = 400  # of an example that is shown


def bounds(schema):
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is not None and high is not None:
        return f" {low}..{high}"
    return f" from {low}" if low is not None else f" to {high}" if high is not None else ""


def link(name):
    return f"[{name}](#{name.lower().replace('.', '')})"


def kind(schema):
    """A schema's type in a few words."""
    if "$ref" in schema:
        place, name = schema["$ref"].rsplit("/", 1)
        return link(name if place == "#/components/schemas" else f"CalibrationDocument.{name}")
    if "oneOf" in schema:
        return " or ".join(kind(one) for one in schema["oneOf"])
    if "const" in schema:
        return f"`{json.dumps(schema['const'])}`"
    names = schema.get("type", "any")
    names = names if isinstance(names, list) else [names]
    if "enum" in schema:
        return ", ".join("null" if one is None else f"`{one}`" for one in schema["enum"])
    words = []
    for name in names:
        if name == "array":
            size = f"{schema['minItems']} " if schema.get("minItems") == schema.get("maxItems", -1) else ""
            words.append(f"list of {size}{kind(schema.get('items', {}))}")
        else:
            words.append(schema.get("format", name) if name == "string" else name)
    return " or ".join(words) + bounds(schema)


def members(schema, above=""):
    """Of an object and those in it: (name, type, whether always there, description) of each member."""
    for name, member in schema.get("properties", {}).items():
        always = name in schema.get("required", [])
        yield above + name, kind(member), always, member.get("description", "")
        inner = next((one for one in [member, *member.get("oneOf", []), member.get("items", {})] if "properties" in one), None)
        if inner:
            yield from members(inner, f"{above}{name}{'[]' if inner is member.get('items') else ''}.")


def table(heads, rows):
    rows = [[str(cell).replace("|", "\\|").replace("\n", " ") for cell in row] for row in rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in [heads, ["---"] * len(heads), *rows]) + "\n"


def members_table(schema):
    rows = [(f"`{name}`", what, "" if always else "may be left out", text) for name, what, always, text in members(schema)]
    return table(["member", "type", "", "what it is"], rows) if rows else ""


def described(text):
    return "\n" + textwrap.fill(text, COLUMNS, break_long_words=False, break_on_hyphens=False) + "\n" if text else ""


def example(name, given):
    """What goes over the wire, without what is the same in all; a long answer is left out, its type tells of it."""
    params = {param["name"]: param["value"] for param in given["params"]}
    lines = [json.dumps({"method": name, "params": params} if params else {"method": name})]
    answer = json.dumps({"result": given["result"]["value"]})
    return "\n```json\n" + "\n".join(lines + [answer] * (len(answer) <= LONGEST_ANSWER)) + "\n```\n"


def method(one, errors):
    params = [(f"`{param['name']}`", kind(param["schema"]), "required" if param.get("required") else "",
               param["schema"].get("description", "")) for param in one["params"]]
    result = one["result"]["schema"]
    text = f"### {one['name']}\n\n{one['summary']}. Role: {one['x-role']}.\n" + described(one.get("description"))
    if params:
        text += "\n" + table(["parameter", "type", "", "what it is"], params)
    text += f"\nResult: {kind(result)}\n" + ("\n" + members_table(result) if "$ref" not in result else "")
    names = [error["$ref"].rsplit("/", 1)[1] for error in one.get("errors", [])]
    if names:
        text += "\nErrors: " + ", ".join(f"`{errors[name]['data']['code']}`" for name in names) + "\n"
    return text + "".join(example(one["name"], given) for given in one.get("examples", []))


def overview(methods):
    rows = [(f"[{one['name']}](#{re.sub(r'[^a-z0-9_]', '', one['name'].lower())})", one["x-role"], one["summary"]) for one in methods]
    return table(["method", "role", "what it does"], rows)


def event(one):
    data = one["data"]
    text = f"### {one['topic']}\n\n{one['summary']}.\n\nData: {kind(data)}\n"
    return text + ("" if "$ref" in data else "\n" + members_table(data))


def schema_section(name, schema):
    """Of one that is a file of its own also what that defines."""
    if "$ref" in schema:
        schema = json.loads((HERE / schema["$ref"]).read_text())
    text = f"### {name}\n" + described(schema.get("description"))
    text += "\n" + (members_table(schema) if "properties" in schema else kind(schema) + "\n")
    return text + "".join("\n#" + schema_section(f"{name}.{part}", one) for part, one in schema.get("$defs", {}).items())


def sections(document):
    parts = document["components"]
    errors = parts["errors"]
    error_rows = [(one["code"], f"`{one['data']['code']}`", name, one["message"]) for name, one in errors.items()]
    return {
        "protocol": described(document["info"]["description"]),
        "overview": overview(document["methods"]),
        "methods": "\n".join(method(one, errors) for one in document["methods"]),
        "events": "\n".join(event(one) for one in document["x-events"]),
        "errors": table(["code", "data.code", "name", "what it means"], error_rows),
        "schemas": "\n".join(schema_section(name, one) for name, one in parts["schemas"].items()),
    }


def written(page, document):
    for name, text in sections(document).items():
        begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->"
        if begin not in page or end not in page:
            raise SystemExit(f"{PAGE}: has no marks for {name}")
        page = page[:page.index(begin) + len(begin)] + "\n" + text + "\n" + page[page.index(end):]
    return page


def broken(value, indent=""):
    """JSON with a value on one line where it fits."""
    line = json.dumps(value)
    if len(indent) + len(line) < COLUMNS or not isinstance(value, (dict, list)):
        return line
    inner = indent + "  "
    if isinstance(value, dict):
        rows = [f"{inner}{json.dumps(key)}: {broken(one, inner)}" for key, one in value.items()]
    else:
        rows = [inner + broken(one, inner) for one in value]
    opened, closed = "{}" if isinstance(value, dict) else "[]"
    return opened + "\n" + ",\n".join(rows) + "\n" + indent + closed


def main():
    wanted = {PAGE: written(PAGE.read_text(), json.loads(PROTOCOL.read_text()))}
    for file in PROTOCOL, SCHEMA:
        wanted[file] = broken(json.loads(file.read_text())) + "\n"
    for file, text in wanted.items():
        if "--check" not in sys.argv:
            file.write_text(text)
        elif file.read_text() != text:
            raise SystemExit(f"{file} is not up to date: run {pathlib.Path(__file__).name}")


if __name__ == "__main__":
    main()
