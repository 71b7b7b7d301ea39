"""What `sixdial --json` really prints against doc/schemas: schema_test.py SOURCE_DIR BIN_DIR.

With --keep FOLDER the documents are written there, one file each.
"""
import argparse
import copy
import json
import pathlib
import sys
import tempfile

import jsonschema

from verbs import Rig, documents


def name_of(what, document):
    """The schema that a document says it keeps; notifications and answers of the socket say none."""
    if what == "event":
        return "event"
    if what == "events.subscribe":
        return "subscription"
    said = document.get("schema", "")
    if not said.startswith("sixdial."):
        sys.exit(f"{what}: no schema is named in {json.dumps(document)[:300]}")
    if not isinstance(document.get("schema_version"), int):
        sys.exit(f"{what}: no schema_version")
    return said[len("sixdial."):]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("source")
    parser.add_argument("binaries")
    parser.add_argument("--keep")
    options = parser.parse_args()
    validators = {}
    for path in sorted(pathlib.Path(options.source, "doc/schemas").glob("*.json")):
        schema = json.loads(path.read_text(encoding="utf-8"))
        jsonschema.Draft202012Validator.check_schema(schema)
        validators[path.stem] = jsonschema.Draft202012Validator(schema)
    troubles, used, checked = [], set(), 0
    with tempfile.TemporaryDirectory(prefix="sixdial-schemas-", ignore_cleanup_errors=True) as folder:
        rig = Rig(options.source, options.binaries, folder)
        try:
            for what, document in documents(rig):
                name = name_of(what, document)
                checked += 1
                if options.keep:
                    kept = pathlib.Path(options.keep, f"{name}.{checked:03d}.json")
                    kept.write_text(json.dumps(document, indent=1), encoding="utf-8")
                if name not in validators:
                    troubles.append(f"{what}: doc/schemas/{name}.json is missing")
                    continue
                used.add(name)
                for error in list(validators[name].iter_errors(document))[:5]:
                    at = "/".join(str(part) for part in error.absolute_path)
                    troubles.append(f"{what} against {name}.json at /{at}: {error.message[:300]}")
                # A key that nobody declared is noticed.
                strange = copy.deepcopy(document)
                strange["nobody_declared_this"] = 1
                if validators[name].is_valid(strange):
                    troubles.append(f"{name}.json lets an undeclared key pass")
        finally:
            rig.close()
    troubles += [f"doc/schemas/{name}.json: no document was checked against it" for name in set(validators) - used]
    if troubles:
        sys.exit("\n".join(dict.fromkeys(troubles)))
    print(f"{checked} documents, {len(used)} schemas")


if __name__ == "__main__":
    main()
