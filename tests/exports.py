"""Reads what a server exports with readers of others; `tests/exports.sh` starts the server and calls this.

usage: exports.py URL FOLDER, where the files are kept.
"""

import csv
import io
import json
import math
import sys
import time
import urllib.parse
import urllib.request
from pathlib import Path

import numpy as np
import trimesh
import yaml

URL, FOLDER = sys.argv[1], Path(sys.argv[2])
METERS = {"m": 1.0, "mm": 0.001, "in": 0.0254}


def get(path):
    with urllib.request.urlopen(URL + path, timeout=60) as answer:
        return answer.read()


def post(path, body, kind):
    request = urllib.request.Request(URL + path, body, {"content-type": kind})
    with urllib.request.urlopen(request, timeout=60) as answer:
        return json.load(answer)


def close(found, wanted, size):
    """Whether points are the same, to single precision on a body of some size."""
    assert np.allclose(found, wanted, rtol=0, atol=1e-5 * size), (found, wanted)


def upload(name):
    kind = {".stl": "model/stl", ".obj": "model/obj", ".ply": "model/ply"}[name.suffix]
    return post("/meshes", name.read_bytes(), kind)


def plan(mesh, settings):
    settings = {"mesh_id": mesh["id"], "seed": 1, "population": 50, "generations": 10, **settings}
    job = post("/jobs", json.dumps(settings).encode(), "application/json")
    while job["state"] in ("queued", "running"):
        time.sleep(0.1)
        job = json.loads(get(f"/jobs/{job['id']}"))
    assert job["state"] == "succeeded", job
    assert job["result"]["force_closure"], job["result"].get("explanation")
    return job


def load(path, file, kind):
    """A file of the server as trimesh reads it, kept in the folder."""
    data = get(path)
    (FOLDER / file).write_bytes(data)
    return trimesh.load(io.BytesIO(data), file_type=kind, process=False)


def distance(mesh, points):
    """How far points are from the surface of a mesh."""
    corners = mesh.triangles
    return max(
        np.linalg.norm(
            trimesh.triangles.closest_point(corners, np.tile(point, (len(corners), 1))) - point, axis=1
        ).min()
        for point in points
    )


def check_scene(job, name, grasp, contacts):
    result, units = job["result"], job["result"].get("units")
    scale = METERS[units] if units else 1.0
    scene = load(f"/jobs/{job['id']}/grasp.glb?grasp={grasp}", f"{name}.glb", "glb")
    nodes = set(scene.graph.nodes)
    wanted = {"mesh", "center of mass"}
    parts = ["arrow", "cone"] if "friction" in result else ["arrow"]
    wanted |= {f"contact {n + 1}/{part}" for n in range(len(contacts)) for part in parts}
    assert wanted <= nodes, wanted - nodes
    assert any(node.endswith("/cone") for node in nodes) == ("friction" in result)

    def placed(node):
        matrix, geometry = scene.graph[node]
        return scene.geometry[geometry].copy().apply_transform(matrix)

    body = placed("mesh")
    size = body.extents.max()
    close(placed("center of mass").bounds.mean(axis=0), np.multiply(result["center_of_mass"], scale), size)
    for number, contact in enumerate(contacts, 1):
        position, normal = np.multiply(contact["position"], scale), np.array(contact["normal"])
        # Deepest along the normal where the finger is, and nowhere beyond it.
        arrow = placed(f"contact {number}/arrow").vertices
        depths = (arrow - position) @ normal
        close(arrow[depths.argmax()], position, size)
        assert depths.min() < -0.1 * size, depths
        if "friction" in result:
            cone = placed(f"contact {number}/cone").vertices - position
            cone = cone[np.linalg.norm(cone, axis=1) > 1e-4 * size]
            angles = np.arccos(np.clip(cone @ -normal / np.linalg.norm(cone, axis=1), -1, 1))
            outermost = angles[np.linalg.norm(cone, axis=1) > 0.1 * size]
            assert np.allclose(outermost.max(), math.atan(result["friction"]), atol=1e-3), outermost
    weakest = [node for node in nodes if node.startswith("weakest")]
    assert bool(weakest) == (grasp == "best"), nodes
    for mark in [f"contact {n + 1}/arrow" for n in range(len(contacts))] + ["center of mass", *weakest]:
        assert placed(mark).is_watertight and placed(mark).volume > 0, f"{mark} is open or inside out"
    close([distance(body, [np.multiply(contact["position"], scale)]) for contact in contacts], 0, size)
    return body


def check_tables(job, grasp, contacts):
    rows = list(csv.DictReader(io.StringIO(get(f"/jobs/{job['id']}/grasp.csv?grasp={grasp}").decode(), newline="")))
    assert len(rows) == len(contacts)
    for row, contact in zip(rows, contacts):
        for names, key in [(("x", "y", "z"), "position"), (("normal_x", "normal_y", "normal_z"), "normal")]:
            assert [float(row[name]) for name in names] == contact[key], row
        assert int(row["triangle"]) == contact["triangle"]
    rows = list(csv.DictReader(io.StringIO(get(f"/jobs/{job['id']}/convergence.csv").decode(), newline="")))
    history = job["result"]["history"]
    assert [int(row["evaluations"]) for row in rows] == [entry["evaluations"] for entry in history]
    assert [float(row["best"]) for row in rows if row["best"]] == [e["best"] for e in history if e["best"] is not None]


def rotation(w, x, y, z):
    assert math.isclose(w * w + x * x + y * y + z * z, 1, rel_tol=1e-12)
    return trimesh.transformations.quaternion_matrix([w, x, y, z])[:3, :3]


def check_gripper(job, contacts, units, query, body):
    """Both poses put the jaws where the contacts are, and these on the body."""
    result = job["result"]
    wanted = np.array([contact["position"] for contact in contacts]) * METERS[units]
    size = np.linalg.norm(wanted[1] - wanted[0])

    file = yaml.safe_load(get(f"/jobs/{job['id']}/grasp.isaac.yaml{query}"))
    assert (file["format"], file["format_version"]) == ("isaac_grasp", 1.0), file
    assert set(file) == {"format", "format_version", "object_frame_link", "gripper_frame_link", "grasps"}
    [(name, grasp)] = file["grasps"].items()
    keys = {"confidence", "position", "orientation", "cspace_position", "pregrasp_cspace_position"}
    assert name == "grasp_0" and set(grasp) == keys, grasp
    assert all(isinstance(x, float) for x in grasp["position"] + grasp["orientation"]["xyz"]), grasp
    isaac = (
        np.array(grasp["position"]),
        rotation(grasp["orientation"]["w"], *grasp["orientation"]["xyz"]),
        grasp["cspace_position"]["opening"],
    )
    assert grasp["pregrasp_cspace_position"]["opening"] > isaac[2]
    assert math.isclose(grasp["confidence"], result["quality"])

    message = json.loads(get(f"/jobs/{job['id']}/grasp.moveit.json{query}"))
    pose = message["grasp_pose"]["pose"]
    moveit = (
        np.array([pose["position"][axis] for axis in "xyz"]),
        rotation(*(pose["orientation"][axis] for axis in "wxyz")),
        message["grasp_posture"]["points"][0]["positions"][0],
    )
    assert message["pre_grasp_posture"]["points"][0]["positions"][0] > moveit[2]
    assert math.isclose(message["grasp_quality"], result["quality"])
    direction = message["pre_grasp_approach"]["direction"]["vector"]
    assert np.allclose([direction[axis] for axis in "xyz"], moveit[1][:, 2])

    for position, turn, opening in (isaac, moveit):
        assert math.isclose(np.linalg.det(turn), 1, rel_tol=1e-12)
        ends = np.array([position - turn[:, 0] * opening / 2, position + turn[:, 0] * opening / 2])
        assert np.allclose(ends, wanted, rtol=0, atol=1e-12 * size + 1e-15), (ends, wanted)
        assert distance(body, ends) < 1e-5 * body.extents.max()
        # The hand does not come through what is heavy.
        center = np.array(result["center_of_mass"]) * METERS[units]
        assert turn[:, 2] @ (center - position) > -0.06 * opening


def check_meshes(name, mesh):
    """The mesh as three files and coarser."""
    path = f"/meshes/{mesh['id']}/file"
    report = mesh["report"]
    whole = {kind: load(f"{path}?format={kind}", f"{name}.{kind}", kind) for kind in ("glb", "stl", "ply")}
    for kind, found in whole.items():
        if isinstance(found, trimesh.Scene):
            found = found.to_geometry()
        found.merge_vertices()
        assert len(found.faces) == report["triangles"], kind
        assert found.is_watertight and math.isclose(found.volume, report["volume"], rel_tol=1e-5), kind
    coarse = load(f"{path}?max_triangles=2000", f"{name}-coarse.glb", "glb").to_geometry()
    assert 500 < len(coarse.faces) <= 2000, len(coarse.faces)
    extents = whole["ply"].extents
    assert np.all(np.abs(coarse.extents - extents) < 0.1 * extents.max()), (coarse.extents, extents)


def main():
    examples = Path("examples/meshes")
    duck, knight, box = (upload(examples / name) for name in ("duck.obj", "knight.stl", "box.stl"))
    check_meshes("duck", duck)
    check_meshes("knight", knight)

    hard = plan(knight, {"contacts": 4, "friction": 0.5, "top": 3, "units": "in"})
    frictionless = plan(box, {"contacts": 7, "contact_model": "frictionless"})
    soft = plan(duck, {"contacts": 2, "contact_model": "soft", "units": "mm"})
    unknown = plan(box, {"contacts": 2, "contact_model": "soft", "friction": 0.8})
    for name, job in [("hard", hard), ("frictionless", frictionless), ("soft", soft), ("unknown", unknown)]:
        result = job["result"]
        body = check_scene(job, name, "best", result["contacts"])
        check_tables(job, "best", result["contacts"])
        check_scene(job, f"{name}-initial", "initial", result["initial"]["contacts"])
        check_tables(job, "initial", result["initial"]["contacts"])
        if name == "soft":
            check_gripper(job, result["contacts"], "mm", "", body)
        if name == "unknown":
            units = "?" + urllib.parse.urlencode({"units": "m"})
            check_gripper(job, result["contacts"], "m", units, body)
    check_scene(hard, "hard-3", "3", hard["result"]["top"][2]["contacts"])


main()
