#!/usr/bin/python3
"""Validates JSON documents against a schema: check_schema.py SCHEMA DOCUMENT..."""
import json
import sys

import jsonschema

schema, *documents = sys.argv[1:]
with open(schema, encoding="utf-8") as file:
    validator_schema = json.load(file)
jsonschema.Draft202012Validator.check_schema(validator_schema)
validator = jsonschema.Draft202012Validator(validator_schema)

wrong = 0
for document in documents:
    with open(document, encoding="utf-8") as file:
        for error in validator.iter_errors(json.load(file)):
            where = "/".join(str(part) for part in error.absolute_path)
            print(f"{document}: {where}: {error.message[:200]}", file=sys.stderr)
            wrong += 1
sys.exit(1 if wrong else 0)
