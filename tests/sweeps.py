"""Runs what examples/sweeps shows, and holds each result against `graspd plan` called by itself.

    sweeps.py BINARY
"""

import csv
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

SWEEPS = Path("examples/sweeps").resolve()
MESHES = ["meshes/box.stl", "meshes/duck.obj", "meshes/more/duck.obj", "meshes/knight.stl", "meshes/rabbit.ply"]
UNUSABLE = "meshes/no mesh.stl"
# One under which grasps are found, and one under which there can be none.
SETTINGS = {"four": "--contacts 4 --generations 4 --seed 7", "two": "--contacts 2 --friction 0"}
PATIENCE_S = 120

binary = sys.argv[1]
work = Path(tempfile.mkdtemp(prefix="graspd-sweeps-"))
# Ray keeps a token in the home folder, and sends statistics by default.
os.environ |= {"HOME": str(work), "RAY_USAGE_STATS_ENABLED": "0", "RAY_TMPDIR": str(work)}


def lay_out():
    shutil.copytree("examples/meshes", work / "meshes", ignore=shutil.ignore_patterns("*.md", "*.png"))
    (work / "meshes" / "more").mkdir()
    shutil.copy(work / "meshes" / "box.stl", work / "meshes" / "more" / "duck.obj")
    (work / UNUSABLE).write_text("this is not a mesh")
    (work / "meshes.txt").write_text("".join(f"{mesh}\n" for mesh in [*MESHES, UNUSABLE]))
    # Takes note of each run. The first on the knight is killed, as one is that takes too much memory.
    (work / "graspd").write_text(
        f"""#!/bin/sh
echo "$2" >>{work}/runs
[ "$2" != meshes/knight.stl ] || ! mkdir {work}/killed 2>/dev/null || kill -KILL $$
exec {binary} "$@"
"""
    )
    (work / "graspd").chmod(0o755)


def call(*command, **environment):
    return subprocess.run(
        [str(part) for part in command], cwd=work, env=os.environ | environment, capture_output=True, text=True,
        timeout=PATIENCE_S,
    )


def runs():
    """The meshes that the program was run on since this was asked last."""
    try:
        return sorted((work / "runs").read_text().splitlines())
    except FileNotFoundError:
        return []
    finally:
        (work / "runs").unlink(missing_ok=True)


def timeless(text):
    return re.sub(r'"elapsed_s":[^,}]+', '"elapsed_s":0', text)


expected = {}


def check_results(out, name):
    """Every mesh has the result of `graspd plan`, to the byte but for the times, and nothing else lies about."""
    flags = shlex.split(SETTINGS[name])
    for mesh in MESHES:
        if (mesh, name) not in expected:
            seed = [] if "--seed" in flags else ["--seed", "1"]
            direct = call(binary, "plan", mesh, "--json", *flags, *seed)
            assert direct.returncode == (0 if name == "four" else 3), direct.stderr
            expected[mesh, name] = timeless(direct.stdout)
        found = timeless((work / out / f"{mesh}.json").read_text())
        assert found == expected[mesh, name], f"{out}, {mesh}: another result than of graspd plan"
    files = {str(path.relative_to(work / out)) for path in (work / out).rglob("*") if path.is_file()}
    assert files - {f"{UNUSABLE}.error"} == {f"{mesh}.json" for mesh in MESHES} | {"flags"}, files
    assert not list((work / out).glob(".new-*"))


def identities(out):
    return {path: (path.stat().st_ino, path.stat().st_mtime_ns) for path in (work / out).rglob("*.json")}


def check_ray():
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    try:
        cluster.add_node(num_cpus=1)
        cluster.wait_for_nodes()

        def sweep(**settings):
            named = [part for name, flags in settings.items() for part in ("--set", name, flags)]
            program = [sys.executable, SWEEPS / "ray_sweep.py", "meshes.txt", "out", *named]
            return call(*program, "--graspd", work / "graspd", "--address", cluster.address)

        first = sweep(**SETTINGS)
        assert first.returncode == 1, first.stderr
        assert first.stdout.startswith("12 to plan, 0 done before"), first.stdout
        assert "failed: meshes/no mesh.stl under four" in first.stderr, first.stderr
        assert first.stderr.count("failed: ") == 2, first.stderr
        for name in SETTINGS:
            check_results(f"out/{name}", name)
            assert "not a mesh" in (work / "out" / name / f"{UNUSABLE}.error").read_text()
        # The one that was killed was run again.
        assert runs() == sorted(2 * [*MESHES, UNUSABLE] + ["meshes/knight.stl"])
        with open(work / "out" / "summary.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        assert [(row["setting"], row["mesh"]) for row in rows] == [(name, mesh) for name in SETTINGS for mesh in MESHES]
        assert {row["force_closure"] for row in rows if row["setting"] == "four"} == {"True"}, rows
        assert re.search(r"^four +6 +5 +0 +1 +0\.\d+", first.stdout, re.M), first.stdout
        assert re.search(r"^two +6 +0 +5 +1$", first.stdout, re.M), first.stdout

        before = identities("out")
        second = sweep(**SETTINGS)
        assert second.stdout.startswith("2 to plan, 10 done before"), second.stdout
        assert runs() == [UNUSABLE, UNUSABLE], "something was planned twice"
        assert identities("out") == before

        # What has been lost or has changed since is planned again, that alone.
        (work / "out" / "four" / "meshes" / "box.stl.json").unlink()
        os.utime(work / "meshes" / "duck.obj")
        (work / UNUSABLE).rename(work / "aside")
        shutil.copy(work / "meshes" / "box.stl", work / UNUSABLE)
        third = sweep(four=SETTINGS["four"])
        assert third.returncode == 0 and runs() == sorted(["meshes/box.stl", "meshes/duck.obj", UNUSABLE]), third
        assert not (work / "out" / "four" / f"{UNUSABLE}.error").exists()
        (work / "aside").rename(work / UNUSABLE)

        # Other flags under the same name, and flags that do not exist.
        other = sweep(four="--contacts 5")
        assert other.returncode == 2 and "results of other flags" in other.stderr, other
        wrong = sweep(wrong="--contacts none")
        assert wrong.returncode == 2 and "--contacts: must be a whole number" in wrong.stderr, wrong
        runs()
    finally:
        cluster.shutdown()
    print("sweeps: Ray plans each mesh once, also when a run is killed, and as graspd plan does")


def check_slurm():
    script = (SWEEPS / "slurm_array.sh").read_text()
    assert re.search(r"^#SBATCH --cpus-per-task=\d+$", script, re.M)

    def task(index):
        return call(
            "bash", SWEEPS / "slurm_array.sh", "meshes.txt", "slurm", *shlex.split(SETTINGS["four"]),
            GRASPD=str(work / "graspd"), SLURM_ARRAY_TASK_ID=str(index), SLURM_CPUS_PER_TASK="2",
            SLURM_SUBMIT_DIR=str(SWEEPS.parent.parent),
        )

    ended = [task(index).returncode for index in range(len(MESHES) + 1)]
    assert ended == [0] * len(MESHES) + [1], ended
    check_results("slurm", "four")
    runs()
    again = task(0)
    assert again.returncode == 0 and again.stdout == "meshes/box.stl: done before\n" and runs() == [], again
    beyond = task(len(MESHES) + 1)
    assert beyond.returncode == 2 and "no mesh in line 7" in beyond.stderr, beyond
    print("sweeps: the task of Slurm plans as graspd plan does")


def check_kubernetes():
    job = yaml.safe_load((SWEEPS / "kubernetes_job.yaml").read_text())["spec"]
    container = job["template"]["spec"]["containers"][0]
    mounts = {mount["name"]: mount["mountPath"] for mount in container["volumeMounts"]}
    assert container["workingDir"] == mounts["sweep"]
    assert job["completionMode"] == "Indexed"
    shell, flag, line = container["command"]
    assert f"{mounts['scripts']}/plan_one.sh" in line and line.endswith("results --contacts 4")
    line = line.replace(f"{mounts['scripts']}/", f"{shlex.quote(str(SWEEPS))}/")
    line = line.removesuffix("--contacts 4") + SETTINGS["two"]
    path = f"{work}:{os.environ['PATH']}"
    environment = {variable["name"]: variable["value"] for variable in container["env"]}

    def pod(index):
        return call(shell, flag, line, PATH=path, JOB_COMPLETION_INDEX=str(index), **environment).returncode

    ended = [pod(index) for index in range(len(MESHES) + 1)]
    assert ended == [0] * len(MESHES) + [1], ended
    check_results("results", "two")
    # The Job gives up for it.
    assert pod(len(MESHES) + 1) == 2
    actions = {
        code: rule["action"]
        for rule in job["podFailurePolicy"]["rules"]
        for code in rule.get("onExitCodes", {}).get("values", [])
    }
    assert actions == {1: "FailIndex", 2: "FailJob"}, actions
    print("sweeps: the container of the Kubernetes Job plans as graspd plan does")


def check_end():
    """A task that is ended leaves no result, nothing half done, and no planner."""
    flags = ["--generations", "100000", "--population", "1000"]
    task = subprocess.Popen(
        ["sh", SWEEPS / "plan_one.sh", "meshes.txt", "1", "ended", *flags], cwd=work,
        env=os.environ | {"GRASPD": binary}, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )
    end = time.monotonic() + PATIENCE_S
    children = Path(f"/proc/{task.pid}/task/{task.pid}/children")

    def is_planner(pid):
        try:
            return Path(f"/proc/{pid}/cmdline").read_text().split("\0")[:2] == [binary, "plan"]
        except FileNotFoundError:
            return False

    while not (found := [pid for pid in children.read_text().split() if is_planner(pid)]):
        assert time.monotonic() < end and task.poll() is None, "the planner does not start"
        time.sleep(0.05)
    task.send_signal(signal.SIGTERM)
    # The pipes close once nobody holds them, the planner neither.
    task.communicate(timeout=PATIENCE_S)
    assert task.returncode == 143, task.returncode
    assert not Path(f"/proc/{found[0]}").exists()
    assert [path.name for path in (work / "ended").rglob("*") if path.is_file()] == ["flags"]
    print("sweeps: a task that is ended leaves nothing behind")


try:
    lay_out()
    check_ray()
    check_slurm()
    check_kubernetes()
    check_end()
finally:
    shutil.rmtree(work, ignore_errors=True)
