#!/usr/bin/env python3
"""Fails where a source writes or reads the members of JSON by hand. What a document has is said once, by the layout of
its record (proto/record/layout.hpp). Fails too where a file of the lists below does not need to be there.

    no_json_by_hand.py ROOT
"""
import pathlib
import re
import sys

MAY = {
    "config/cell_config.cpp": "system.config shows only what is named there: what is not may be a secret",
    "daemon/cell/report_service.cpp": "adds the stream to a document that is passed on as it was stored",
    "daemon/control/audit_files.cpp": "reads lines as they were written, by other versions too",
    "daemon/control/audit_trail.cpp": "writes lines whose bytes are hashed: the order of their members stays",
    "daemon/control/commands.cpp": "likewise",
    "proto/control/audit_chain.cpp": "what links the lines stands in front of records of any kind",
    "proto/control/request.cpp": "the envelope of JSON-RPC is around JSON of any kind",
    "proto/control/schema.cpp": "reads openrpc.json, whose members are those of JSON Schema",
    "proto/rpc/methods.cpp": "writes openrpc.json, likewise",
    "tools/truepose/online/recording_commands.cpp": "adds to an answer that is printed as it came",
    "tools/truepose/online/report_command.cpp": "adds to a document that is printed as it came",
}

KEY = r'"[a-z_$][\w$]*"'
# Other lists begin alike, so that it counts only where there is JSON, and not in a table for people or of commands.
MEMBER = re.compile(rf"\{{\s*\{{\s*{KEY}\s*,")
TABLE = re.compile(r"(Cells>\s*\w+|text_table\(|OnlineRow> \w+\([^)]*\) \{\s*return)\s*\{")
BY_HAND = re.compile(
    r"\bjson::(?:object|value)\s*\w*\s*[({]\s*\{"  # json::object{{"key", value}}
    rf"|\bprint\([\w.]+,\s*\{{\s*\{{\s*{KEY}"  # print(online, {{"key", value}}, text)
    rf"|[\w\])]\[{KEY}\]"  # object["key"]
    rf"|(?:\.|->)(?:at|if_contains|emplace|insert_or_assign)\(\s*{KEY}"  # object.at("key")
    r'|\b(?:at|find)_pointer\([^()"]*"/'  # value.at_pointer("/key")
)


def lines_by_hand(file):
    """The lines in which it writes or reads members by hand."""
    text = TABLE.sub(lambda table: "\n" * table[0].count("\n"), file.read_text(encoding="utf-8"))
    patterns = [BY_HAND] if re.search(r"\bjson", text) else []
    patterns += [MEMBER] if re.search(r"\bjson::(array|object|value)\b", text) else []
    return sorted({text.count("\n", 0, found.start()) + 1 for by in patterns for found in by.finditer(text)})


root = pathlib.Path(sys.argv[1])
by_hand = {}
for room in ("core", "proto", "config", "drivers", "daemon", "tools"):
    for source in root.glob(f"{room}/**/*.[ch]pp"):
        by_hand[str(source.relative_to(root))] = lines_by_hand(source)
wrong = [
    f"{name}:{line}: JSON by hand: give it a record with a layout"
    for name, lines in sorted(by_hand.items())
    for line in lines
    if name not in MAY and not name.startswith("proto/record/")
]
wrong += [f"{name}: has no JSON by hand: take it off the list" for name in MAY if not by_hand.get(name)]
print("\n".join(wrong))
sys.exit(bool(wrong))
