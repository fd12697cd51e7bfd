"""Runs everything that a change has to pass: `make test`.

A group is a command, or one test program that cargo has built. Groups that do not depend on one another run side by
side. Those that use cargo take turns, as they share its build directory. So do those that hold a server against limits
of time; all others run at the lowest priority, so that the processors are there for what is timed. Each writes its own log in target/test-logs,
which is shown when the group fails. At the end come the time of each group and the ten slowest tests, and last a line
with the number of tests that passed and failed. An interrupt ends every group with all its processes.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOGS = ROOT / "target" / "test-logs"
SLOWEST = 10
AT_ONCE = os.cpu_count() or 1
GRACE_S = 10
WORKSPACE = ["--locked", "--workspace"]

# (name, commands, groups that come before). Of what can start, the first starts first: the longest are on top.
GROUPS = [
    ("install: libclang", [["sh", "tests/install.sh", "libclang"]], []),
    ("page", [["make", "page"]], []),
    ("format", [["cargo", "fmt", "--all", "--check"]], []),
    ("build", ["build"], ["install: libclang", "page"]),
    ("install: rest", [["sh", "tests/install.sh"]], ["install: libclang"]),
    ("page: lints", [["npm", "--prefix", "web", "run", "check"]], ["page"]),
    ("page: unit tests", [["npm", "--prefix", "web", "test"]], ["page"]),
    ("conformance", [["sh", "tests/conformance.sh"]], ["build", "install: rest"]),
    ("browser", [["sh", "tests/browser.sh"]], ["build", "install: rest"]),
    ("deploy", [["sh", "tests/deploy.sh"]], ["build", "install: rest"]),
    ("sweeps", [["sh", "tests/sweeps.sh"]], ["build", "install: rest"]),
    # With every feature; what is built and tested has the default ones.
    ("clippy", [["cargo", "clippy", *WORKSPACE, "--all-targets", "--features", "graspd/otel", "--", "-D", "warnings"]], ["build"]),
    ("core alone", [["cargo", "check", "--locked", "-p", "graspd-core"]], ["build", "clippy"]),
    ("documentation", [["env", "RUSTDOCFLAGS=-D warnings", "cargo", "doc", *WORKSPACE, "--no-deps", "--document-private-items"]], ["build", "clippy"]),
    ("doctests", [["cargo", "test", *WORKSPACE, "--doc"]], ["build", "clippy"]),
    ("documented commands", [["sh", "tests/documented_commands.sh"]], ["build", "install: rest"]),
    ("exports", [["sh", "tests/exports.sh"]], ["build", "install: rest"]),
    ("book", [["sh", "tests/book.sh"]], ["install: rest"]),
]
# Groups that hold a server against limits of time, the longest on top.
TIMED = [
    "browser",
    "graspd: http (test)",
    "graspd: fleet (test)",
    "graspd: graspd (lib)",
    "deploy",
    "graspd: chaos (test)",
    "conformance",
]
# Other test programs by how long they take; all others come after these.
LONGEST = ["graspd_core", "planning", "agreement"]

RUST_RESULT = re.compile(r"^test result: \w+\. (\d+) passed; (\d+) failed", re.MULTILINE)
RUST_TEST = re.compile(r"^test (.+?) \.\.\. .*?<([\d.]+)s>", re.MULTILINE)
NODE_RESULT = re.compile(r"^ℹ (pass|fail|cancelled) (\d+)$", re.MULTILINE)
NODE_TEST = re.compile(r"^[✔✖] (.+) \(([\d.]+)ms\)", re.MULTILINE)
VITEST_RESULT = re.compile(r"^\s*Tests\s+(?:(\d+) failed \| )?(\d+) passed", re.MULTILINE)
COLOUR = re.compile(r"\x1b\[[\d;]*m")


class Group:
    def __init__(self, name, commands, after, folder=ROOT, environment=None):
        self.name, self.commands, self.after = name, commands, after
        self.folder, self.environment = folder, environment or {}
        self.log = LOGS / (re.sub(r"\W+", "-", name) + ".log")
        self.uses_cargo = any(command == "build" or "cargo" in command for command in commands)
        self.is_timed = name in TIMED
        self.seconds, self.passed = None, None


class Run:
    def __init__(self):
        self.groups = [Group(*entry) for entry in GROUPS]
        self.changed = threading.Condition()
        self.running = {}  # process of each group that runs
        self.stopped = False

    def start(self):
        """Runs all groups; returns whether all passed."""
        shutil.rmtree(LOGS, ignore_errors=True)
        LOGS.mkdir(parents=True)
        threads = {}
        while True:
            with self.changed:
                for group in self.groups:
                    if group not in threads and self.may_start(group, threads):
                        threads[group] = threading.Thread(target=self.run, args=[group])
                        threads[group].start()
                if not any(thread.is_alive() for thread in threads.values()) and not self.ready(threads):
                    break
                self.changed.wait(1)
        return all(group.passed for group in self.groups)

    def ready(self, threads):
        return [group for group in self.groups if group not in threads and self.may_start(group, threads)]

    def may_start(self, group, threads):
        by_name = {other.name: other for other in self.groups}
        if self.stopped or not all(by_name[name].passed for name in group.after):
            return False
        running = [other for other in threads if other.passed is None]
        if group.uses_cargo and any(other.uses_cargo for other in running):
            return False
        if group.is_timed and any(other.is_timed for other in running):
            return False
        return len(running) < AT_ONCE

    def run(self, group):
        begun = time.monotonic()
        with group.log.open("w") as log:
            passed = all(self.build(group, log) if command == "build" else self.execute(group, command, log)
                         for command in group.commands)
        with self.changed:
            group.seconds, group.passed = time.monotonic() - begun, passed
            if not self.stopped:
                print(f"{'ok  ' if passed else 'FAIL'} {group.seconds:7.1f} s  {group.name}", flush=True)
                if not passed:
                    print(COLOUR.sub("", group.log.read_text(errors="replace")), flush=True)
            self.changed.notify_all()

    def execute(self, group, command, log, output=None):
        with self.changed:
            if self.stopped:
                return False
            # A session of its own, so that all its processes can be ended together.
            process = subprocess.Popen(
                command if group.is_timed else ["nice", "-n", "19", *command], cwd=group.folder, env=os.environ | group.environment, stdin=subprocess.DEVNULL,
                stdout=output or log, stderr=log, start_new_session=True,
            )
            self.running[group] = process
        if output:
            self.read_programs(process.stdout)
        status = process.wait()
        end(process, signal.SIGKILL)  # what it has left running
        with self.changed:
            del self.running[group]
        return status == 0

    def build(self, group, log):
        """Builds all test programs, the program itself and the examples, and makes a group of each test program."""
        return (
            self.execute(group, ["cargo", "test", *WORKSPACE, "--all-targets", "--no-run", "--message-format",
                                 "json-render-diagnostics"], log, subprocess.PIPE)
            and self.execute(group, ["cargo", "build", *WORKSPACE, "--bins", "--examples"], log)
        )

    def read_programs(self, lines):
        programs = []
        for line in lines:
            message = json.loads(line)
            if message["reason"] != "compiler-artifact" or not message["executable"]:
                continue
            target = message["target"]
            if message["profile"]["test"] or "bench" in target["kind"]:
                programs.append((target, message["executable"], Path(message["manifest_path"]).parent))
            elif target["name"] == "graspd" and "bin" in target["kind"]:
                os.environ |= {"GRASPD_BINARY": message["executable"], "CARGO_BIN_EXE_graspd": message["executable"]}
        places = {name: place for place, name in enumerate(LONGEST)}
        programs.sort(key=lambda program: places.get(program[0]["name"], len(LONGEST)))
        # The standard harness takes times for those alone who may use what is not stable.
        timed = {"RUSTC_BOOTSTRAP": "1"}
        with self.changed:
            found = []
            for target, executable, folder in programs:
                is_timed = "bench" not in target["kind"]
                options = ["-Zunstable-options", "--report-time"] if is_timed else []
                name = f"{folder.name if folder != ROOT else 'graspd'}: {target['name']} ({target['kind'][0]})"
                found.append(Group(name, [[executable, *options]], ["build", "install: rest"], folder, timed))
            position = next(at for at, group in enumerate(self.groups) if group.name == "clippy")
            self.groups[position:position] = found
            # What is timed never waits for what is not.
            self.groups.sort(key=lambda group: TIMED.index(group.name) if group.is_timed else len(TIMED))

    def stop(self):
        with self.changed:
            self.stopped = True
            processes = list(self.running.values())
        for process in processes:
            end(process, signal.SIGTERM)
        limit = time.monotonic() + GRACE_S
        while time.monotonic() < limit and any(process.poll() is None for process in processes):
            time.sleep(0.1)
        for process in processes:
            end(process, signal.SIGKILL)


def end(process, how):
    try:
        os.killpg(process.pid, how)
    except ProcessLookupError:
        pass


def counts(text):
    """The tests of a log that passed and that failed."""
    passed = failed = 0
    for one, other in RUST_RESULT.findall(text):
        passed, failed = passed + int(one), failed + int(other)
    for kind, count in NODE_RESULT.findall(text):
        passed, failed = passed + (kind == "pass") * int(count), failed + (kind != "pass") * int(count)
    for other, one in VITEST_RESULT.findall(text):
        passed, failed = passed + int(one), failed + int(other or 0)
    return passed, failed


def report(groups, seconds):
    passed = failed = 0
    tests = []
    for group in groups:
        text = COLOUR.sub("", group.log.read_text(errors="replace")) if group.log.exists() else ""
        one, other = counts(text)
        # A group that counts nothing is one test, as is the fault of one whose tests all passed.
        passed += one or (group.passed is True and not other)
        failed += other or (group.passed is not True)
        tests += [(float(time), name, group.name) for name, time in RUST_TEST.findall(text)]
        tests += [(float(time) / 1000, name, group.name) for name, time in NODE_TEST.findall(text)]
    print("\nTime of each group, side by side:")
    for group in sorted(groups, key=lambda group: -(group.seconds or 0)):
        state = {True: "", False: "  FAILED", None: "  not run"}[group.passed]
        print(f"{group.seconds or 0:8.1f} s  {group.name}{state}")
    print("\nSlowest tests:")
    for time_s, name, group in sorted(tests, reverse=True)[:SLOWEST]:
        print(f"{time_s:8.1f} s  {name}  ({group})")
    print(f"\nAll of it took {seconds:.0f} s.")
    print(f"{passed} passed, {failed} failed", flush=True)


def main():
    os.chdir(ROOT)
    run = Run()

    def interrupted(number, _frame):
        # The signal arrives in the main thread, which may hold the lock.
        threading.Thread(target=lambda: (run.stop(), os._exit(128 + number))).start()

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupted)
    begun = time.monotonic()
    passed = run.start()
    if run.stopped:
        signal.pause()  # until the rest has ended
    report(run.groups, time.monotonic() - begun)
    sys.exit(0 if passed else 1)


main()
