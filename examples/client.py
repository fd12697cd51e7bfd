#!/usr/bin/env python3
"""From a mesh file to printed contacts, with nothing but Python's standard library.

    python3 examples/client.py http://127.0.0.1:8080 examples/meshes/duck.obj contacts=4 friction=0.5

Everything after the file is a planning setting, sent as a field of the form. The environment may hold
GRASPD_API_KEY, where the server asks for one, and GRASPD_DEADLINE, the most seconds that all may take
(default 600). What fails for a while is tried again until then.
"""

import http.client
import json
import os
import random
import sys
import time
import urllib.error
import urllib.request
import uuid

# Too early, too slow, too often, or a server that is busy or not there: the same request may do later.
RETRIED = {408, 425, 429, 502, 503, 504}
# Longest that a pause grows by itself, and that one answer is waited for, in seconds.
LONGEST_PAUSE, PATIENCE = 10, 40


def form(mesh_path, settings):
    """The body of a multipart form and its content type."""
    boundary = uuid.uuid4().hex
    lines = []
    for name, value in settings:
        lines += [f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n'.encode(), value.encode(), b"\r\n"]
    file_name = os.path.basename(mesh_path).replace('"', "%22")
    lines.append(
        f'--{boundary}\r\nContent-Disposition: form-data; name="mesh"; filename="{file_name}"\r\n'
        "Content-Type: application/octet-stream\r\n\r\n".encode()
    )
    try:
        with open(mesh_path, "rb") as mesh:
            lines.append(mesh.read())
    except OSError as error:
        sys.exit(f"cannot read the mesh: {error}")
    lines.append(f"\r\n--{boundary}--\r\n".encode())
    return b"".join(lines), f"multipart/form-data; boundary={boundary}"


class Caller:
    """Asks one server, again and again if it must, until the deadline."""

    def __init__(self, server, seconds):
        self.server = server
        self.deadline = time.monotonic() + seconds
        key = os.environ.get("GRASPD_API_KEY")
        self.headers = {"Authorization": f"Bearer {key}"} if key else {}

    def call(self, path, body=None, headers=None):
        """The JSON and the headers of the answer; a problem ends the program in the server's words."""
        request = urllib.request.Request(self.server + path, body, {**self.headers, **(headers or {})})
        attempt = 0
        while True:
            left = max(0.1, self.deadline - time.monotonic())
            try:
                with urllib.request.urlopen(request, timeout=min(PATIENCE, left)) as response:
                    return json.load(response), response.headers
            except urllib.error.HTTPError as error:
                why = describe(error)
                # A request under the same Idempotency-Key is still being dealt with.
                in_flight = error.code == 409 and body is not None and "Retry-After" in error.headers
                if error.code not in RETRIED and not in_flight:
                    sys.exit(why)
                wanted = seconds(error.headers.get("Retry-After"), 0)
            except (OSError, http.client.HTTPException, ValueError) as error:
                why, wanted = f"no answer from the server: {getattr(error, 'reason', error)}", 0
            # Twice as long each time, and at random, so that clients do not come back all at once.
            pause = max(wanted, random.uniform(0, min(LONGEST_PAUSE, 0.2 * 2**attempt)))
            if time.monotonic() + pause > self.deadline:
                sys.exit(why)
            print(f"{why}; again in {pause:.1f} s", file=sys.stderr, flush=True)
            time.sleep(pause)
            attempt += 1


def describe(error):
    """An error answer in words."""
    try:
        problem = json.load(error)
        fields = "".join(f"\n  {e['pointer']}: {e['detail']}" for e in problem.get("errors") or [])
        return f"{error.code}: {problem['detail']}{fields}"
    except (ValueError, KeyError, TypeError, AttributeError):
        # A proxy may answer in its own words.
        return f"{error.code}: {error.reason}"


def seconds(text, default):
    try:
        return float(text)
    except (TypeError, ValueError):
        return default


def show(result):
    if not result["force_closure"]:
        print("no force closure:", result["explanation"]["detail"])
        return
    print(f"quality   {result['quality']:.5f} (first grasp {result['initial']['quality']:.5f}), seed {result['seed']}")
    print("weakest  ", result["weakest_wrench"]["description"])
    for number, contact in enumerate(result["contacts"], start=1):
        position = " ".join(f"{x:10.4f}" for x in contact["position"])
        normal = " ".join(f"{x:10.4f}" for x in contact["normal"])
        print(f"contact {number}  at {position}  pushing along {normal}")


def main():
    if len(sys.argv) < 3 or any("=" not in setting for setting in sys.argv[3:]):
        sys.exit("usage: client.py SERVER MESH [NAME=VALUE]...")
    if not sys.argv[1].startswith(("http://", "https://")):
        sys.exit(f"{sys.argv[1]}: the address of the server has to begin with http:// or https://")
    caller = Caller(sys.argv[1].rstrip("/"), seconds(os.environ.get("GRASPD_DEADLINE"), 600))
    body, content_type = form(sys.argv[2], [setting.split("=", 1) for setting in sys.argv[3:]])
    # The same key over all tries: however often it has to be sent, it is one job.
    submission = {"Content-Type": content_type, "Idempotency-Key": str(uuid.uuid4())}
    job, headers = caller.call("/jobs", body, submission)
    path = headers["Location"]
    print("job      ", caller.server + path, flush=True)
    while job["state"] in ("queued", "running"):
        if time.monotonic() > caller.deadline:
            sys.exit(f"the job is still {job['state']}")
        # Answered once the job has ended, or after so many seconds, or at once by a server that is shutting down.
        job, _ = caller.call(path + "?wait=20")
        time.sleep(0.1 if job["state"] in ("queued", "running") else 0)
        if job["state"] == "running" and job.get("progress"):
            print("generation {generation} of {generations}, best quality {best_quality}".format(**job["progress"]))
    if job["state"] != "succeeded":
        sys.exit(f"the job {job['state']}: {(job.get('problem') or {}).get('detail', '')}")
    show(job["result"])


if __name__ == "__main__":
    main()
