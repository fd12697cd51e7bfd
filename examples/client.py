#!/usr/bin/env python3
"""From a mesh file to printed contacts, with nothing but Python's standard library.

    python3 examples/client.py http://127.0.0.1:8080 examples/meshes/duck.obj contacts=4 friction=0.5

Everything after the file is a planning setting, sent as a field of the form.
"""

import json
import os
import sys
import time
import urllib.error
import urllib.request
import uuid


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


def call(request):
    """The JSON and the headers of the answer; a problem ends the program in the server's words."""
    try:
        with urllib.request.urlopen(request, timeout=60) as response:
            return json.load(response), response.headers
    except urllib.error.HTTPError as error:
        problem = json.load(error)
        fields = "".join(f"\n  {e['pointer']}: {e['detail']}" for e in problem.get("errors", []))
        sys.exit(f"{error.code}: {problem['detail']}{fields}")
    except urllib.error.URLError as error:
        sys.exit(f"no answer from the server: {error.reason}")


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
    server, mesh_path = sys.argv[1].rstrip("/"), sys.argv[2]
    body, content_type = form(mesh_path, [setting.split("=", 1) for setting in sys.argv[3:]])
    request = urllib.request.Request(f"{server}/jobs", body, {"Content-Type": content_type})
    job, headers = call(request)
    job_url = server + headers["Location"]
    print("job      ", job_url)
    while job["state"] in ("queued", "running"):
        time.sleep(float(headers.get("Retry-After", 1)))
        job, headers = call(job_url)
        if job["state"] == "running" and job.get("progress"):
            print("generation {generation} of {generations}, best quality {best_quality}".format(**job["progress"]))
    if job["state"] != "succeeded":
        sys.exit(f"the job {job['state']}: {(job.get('problem') or {}).get('detail', '')}")
    show(job["result"])


if __name__ == "__main__":
    main()
