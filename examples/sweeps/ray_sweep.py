"""A grasp on every mesh of a list, under one or several settings, on a Ray cluster or on this machine.

    pip install ray
    find meshes -name '*.obj' >meshes.txt
    python ray_sweep.py meshes.txt results
    python ray_sweep.py meshes.txt results --set hard '--contacts 4' --set soft '--contacts 3 --contact-model soft'

Each mesh and setting is one task, which runs plan_one.sh beside this file: results/SETTING/MESH.json is never left
half-written. Run the same again after an interruption, or with more meshes: meshes that are done are skipped. A task
that was interrupted, or whose node was lost, is tried again. The sweep ends with a table and results/summary.csv.

What to change: --address for a cluster that was not started on this machine, --threads for the processors of one
task. Meshes, results, graspd and this folder must have the same path on all nodes, for example on NFS.

Exit codes: 0 every mesh has its JSON; 1 some cannot be planned, the reasons are in .error files beside the
results; 2 the arguments cannot be used.
"""

import argparse
import csv
import json
import os
import re
import shlex
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

import ray

PLAN_ONE = Path(__file__).resolve().with_name("plan_one.sh")
# Tasks handed to Ray at a time: enough for any cluster to have work, few enough to be looked through quickly.
AT_A_TIME = 1000
UNUSABLE_MESH, UNUSABLE_FLAGS = 1, 2


class BrokenOff(Exception):
    """A run that ended without an answer, by a signal for example: the next try may do better."""


def plan(task, folder, meshes, program, threads):
    """Runs one task and returns its exit code and standard error. Paths are relative to `folder`."""
    index, out, flags = task
    ended = subprocess.run(
        ["sh", PLAN_ONE, meshes, str(index), out, *flags],
        cwd=folder,
        env=os.environ | {"GRASPD": program, "THREADS": str(threads)},
        capture_output=True,
        text=True,
        # Ctrl-C is for the sweep.
        start_new_session=True,
    )
    if ended.returncode not in (0, UNUSABLE_MESH, UNUSABLE_FLAGS):
        raise BrokenOff(f"exit code {ended.returncode}: {ended.stderr.strip()[-500:]}")
    return ended.returncode, ended.stderr.strip()


def refuse(what):
    print(f"ray_sweep.py: {what}", file=sys.stderr)
    sys.exit(UNUSABLE_FLAGS)


def path_of(mesh, out):
    return Path(f"{out}/{mesh.removeprefix('/')}.json")


def has_other_flags(out, flags):
    """Whether `out` has results of other flags, as plan_one.sh checks it."""
    if not any(re.match("--seed(=|$)", flag) for flag in flags):
        flags = [*flags, "--seed", "1"]
    try:
        return Path(f"{out}/flags").read_text() != "".join(f"{flag}\n" for flag in flags)
    except FileNotFoundError:
        return False


def is_done(mesh, out):
    """Whether the mesh has a result that is no older, as plan_one.sh checks it."""
    result = path_of(mesh, out)
    try:
        return result.stat().st_mtime_ns >= os.stat(mesh).st_mtime_ns
    except FileNotFoundError:
        return False


def run(tasks, arguments):
    """Runs the tasks and returns those that failed, with the reason."""
    remote = ray.remote(num_cpus=arguments.threads, max_retries=arguments.retries, retry_exceptions=[BrokenOff])(plan)
    given = (os.getcwd(), arguments.list, arguments.graspd, arguments.threads)
    waiting, running, failed, ended = list(reversed(tasks)), {}, [], 0
    while waiting or running:
        while waiting and len(running) < AT_A_TIME:
            task = waiting.pop()
            running[remote.remote(task, *given)] = task
        for reference in ray.wait(list(running))[0]:
            task = running.pop(reference)
            ended += 1
            try:
                code, said = ray.get(reference)
            except (BrokenOff, ray.exceptions.RayError) as fault:
                code, said = None, str(fault).strip().splitlines()[-1]
            if code == UNUSABLE_FLAGS:
                refuse(said)
            if code != 0:
                failed.append((task, said))
            print(f"\r{ended} of {len(tasks)}", end="", file=sys.stderr, flush=True)
    if tasks:
        print(file=sys.stderr)
    return failed


def summarise(meshes, settings, out):
    """Writes summary.csv and prints a line for each setting."""
    print(f"{'setting':20} {'meshes':>7} {'grasps':>7} {'none':>7} {'failed':>7} {'quality: least':>15} {'median':>9} {'most':>9}")
    with open(f"{out}/summary.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["setting", "mesh", "force_closure", "quality", "evaluations", "elapsed_s", "seed", "version"])
        for name in settings:
            qualities, none, failed = [], 0, 0
            for mesh in meshes:
                try:
                    result = json.loads(path_of(mesh, f"{out}/{name}").read_text())
                except FileNotFoundError:
                    failed += 1
                    continue
                columns = ("force_closure", "quality", "evaluations", "elapsed_s", "seed", "version")
                table.writerow([name, mesh, *(result[column] for column in columns)])
                if result["force_closure"]:
                    qualities.append(result["quality"])
                else:
                    none += 1
            figures = [min(qualities), statistics.median(qualities), max(qualities)] if qualities else []
            columns = "".join(f" {figure:{width}.4f}" for figure, width in zip(figures, (15, 9, 9)))
            print(f"{name:20} {len(meshes):7} {len(qualities):7} {none:7} {failed:7}{columns}")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("list", help="file with the path of one mesh per line")
    parser.add_argument("out", help="folder of the results")
    parser.add_argument(
        "--set", dest="settings", nargs=2, action="append", metavar=("NAME", "FLAGS"),
        help="a setting: the name of its folder, and flags of `graspd plan` in one argument",
    )
    parser.add_argument("--graspd", default="graspd", help="the program [%(default)s]")
    parser.add_argument("--threads", type=int, default=1, help="threads, and so processors, of a task [%(default)s]")
    parser.add_argument("--retries", type=int, default=3, help="retries of a task that was interrupted [%(default)s]")
    parser.add_argument("--address", help="address of the cluster [one on this machine, else a new one]")
    arguments = parser.parse_args()
    arguments.settings = dict(arguments.settings or [("default", "")])
    for name in arguments.settings:
        if not re.fullmatch(r"[\w.-]*\w", name):
            parser.error(f"--set {name}: the name must be a folder name of letters, digits and . _ -")
    program = shutil.which(arguments.graspd)
    if not program:
        parser.error(f"--graspd: there is no program {arguments.graspd}")
    try:
        meshes = Path(arguments.list).read_text().splitlines()
    except OSError as fault:
        parser.error(f"the list cannot be read: {fault}")
    for line, mesh in enumerate(meshes, 1):
        if not mesh or ".." in Path(mesh).parts:
            parser.error(f"{arguments.list}, line {line}: name one mesh, without '..'")
    if len(set(meshes)) < len(meshes):
        parser.error(f"{arguments.list} names a mesh twice")
    arguments.graspd = os.path.abspath(program)
    return arguments, meshes


def main():
    arguments, meshes = parse()
    tasks, before = [], 0
    for name, flags in arguments.settings.items():
        out, flags = f"{arguments.out}/{name}", shlex.split(flags)
        if has_other_flags(out, flags):
            refuse(f"{out} has results of other flags, those in {out}/flags: give the setting another name")
        for index, mesh in enumerate(meshes):
            if is_done(mesh, out):
                before += 1
            else:
                tasks.append((index, out, flags))
    print(f"{len(tasks)} to plan, {before} done before")
    failed = []
    if tasks:
        ray.init(address=arguments.address, log_to_driver=False)
        failed = run(tasks, arguments)
    summarise(meshes, arguments.settings, arguments.out)
    for (index, out, _), said in failed:
        print(f"failed: {meshes[index]} under {Path(out).name}: {said}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
