#!/usr/bin/env python3
"""From mesh files to a table of qualities, with nothing but Python's standard library.

    python3 examples/batch.py http://127.0.0.1:8080 examples/meshes/box.stl examples/meshes/duck.obj contacts=4

Every NAME=VALUE among the arguments is a planning setting, a JSON value or a word. GRASPD_KEY in the environment is the
API key, if the server requires one. graspd batch does the same and resumes where it was interrupted.
"""

import json
import os
import sys
import urllib.error
import urllib.request
import uuid


def call(url, body=None, headers=None):
    """The open answer; a problem ends the program in the server's words."""
    key = os.environ.get("GRASPD_KEY")
    headers = {**({"Authorization": f"Bearer {key}"} if key else {}), **(headers or {})}
    try:
        return urllib.request.urlopen(urllib.request.Request(url, body, headers), timeout=90)
    except urllib.error.HTTPError as error:
        problem = json.load(error)
        fields = "".join(f"\n  {e['pointer']}: {e['detail']}" for e in problem.get("errors", []))
        sys.exit(f"{error.code}: {problem['detail']}{fields}")


def upload(server, path):
    """The id of a mesh; sending it again does no harm."""
    with open(path, "rb") as file:
        content = {"Content-Type": "application/octet-stream"}
        return json.load(call(f"{server}/meshes", file.read(), content))["id"]


def value(text):
    try:
        return json.loads(text)
    except ValueError:
        return text


def main():
    settings = dict(word.split("=", 1) for word in sys.argv[2:] if "=" in word)
    files = [word for word in sys.argv[2:] if "=" not in word]
    if not files:
        sys.exit("usage: batch.py SERVER MESH... [NAME=VALUE]...")
    server = sys.argv[1].rstrip("/")
    batch = {
        "meshes": [upload(server, path) for path in files],
        "request": {name: value(text) for name, text in settings.items()},
    }
    # However often it has to be sent, it is one batch.
    headers = {"Content-Type": "application/json", "Idempotency-Key": str(uuid.uuid4())}
    with call(f"{server}/batches", json.dumps(batch).encode(), headers) as answer:
        path = answer.headers["Location"]
    while True:
        # Answered once the batch has ended, or after so many seconds.
        batch = json.load(call(f"{server}{path}?wait=20"))
        print(batch["jobs"], file=sys.stderr)
        if batch["state"] == "ended":
            break
    with call(f"{server}{path}/results") as lines:
        for line in map(json.loads, lines):
            result = line.get("result")
            outcome = result["quality"] if result else line.get("problem", {}).get("detail")
            print(f"{files[line['index']]}\t{line['state']}\t{outcome}")


if __name__ == "__main__":
    main()
