"""The fleet of deploy/compose.yaml without containers: PostgreSQL, two servers behind the proxy, two workers, and
Prometheus over them, all real, with the files as they are.

    stack.py BINARY

Wants a network and mounts of its own, as `unshare --net --mount` gives them, and to be root: names, ports and the
name server are those of the containers, and addresses of the loopback take the place of theirs.
"""

import http.client
import json
import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from pathlib import Path

import yaml

DEPLOY = Path("deploy")
PROXY = ("127.0.0.1", 8080)
POSTGRES = "127.0.0.5"
SERVERS = {1: "127.0.0.21", 2: "127.0.0.22"}
WORKERS = {1: "127.0.0.31", 2: "127.0.0.32"}
# The user `nobody`: PostgreSQL refuses root.
NOBODY = 65534
NAME_SERVER = "127.0.0.11"  # as in Docker's networks
PROMETHEUS = "http://127.0.0.1:9090"
PATIENCE_S = 60
STEP_S = 0.1
CHECK_INTERVAL_S = 1  # of the proxy
MIB = 1 << 20

work = Path(tempfile.mkdtemp(prefix="graspd-deploy-"))
processes = {}


def start(name, *command, **environment):
    log = (work / f"{name}.log").open("ab")
    processes[name] = subprocess.Popen(
        [str(part) for part in command], cwd=work, stdout=log, stderr=log, env=os.environ | environment
    )


def stop(name, how=signal.SIGTERM):
    process = processes.pop(name)
    process.send_signal(how)
    return process.wait(PATIENCE_S)


def until(what, holds):
    """Waits until `holds()` is true, and gives what it gave."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        for name, process in processes.items():
            assert process.poll() is None, f"{name} has ended: {(work / f'{name}.log').read_text()[-2000:]}"
        if found := holds():
            return found
        time.sleep(STEP_S)
    raise AssertionError(f"waited in vain: {what}")


def ask(method, path, body=None, headers=None, address=PROXY, key=True):
    """Status, headers and body of an answer; (0, {}, b"") without one."""
    connection = http.client.HTTPConnection(*address, timeout=PATIENCE_S)
    if key:
        headers = {"Authorization": f"Bearer {robot}"} | (headers or {})
    try:
        connection.request(method, path, body, headers or {})
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()
    except (OSError, http.client.HTTPException):
        return 0, {}, b""
    finally:
        connection.close()


def problem(answer):
    """The type or title of a refusal, which has to be a problem."""
    status, headers, body = answer
    assert headers.get("Content-Type") == "application/problem+json", (status, headers.items(), body[:200])
    answered = json.loads(body)
    assert answered["status"] == status, answered
    return answered["type"] if answered["type"] != "about:blank" else answered["title"]


def environment_of(service):
    """What deploy/compose.yaml sets for a service, with the values of deploy/.env.example."""
    example = dict(line.split("=", 1) for line in (DEPLOY / ".env.example").read_text().splitlines() if re.match(r"\w+=", line))
    set_there = compose["services"][service]["environment"]
    return {name: re.sub(r"\$\{(\w+).*?\}", lambda found: example[found[1]], value) for name, value in set_there.items()}


def start_server(number):
    start(f"server-{number}", binary, "serve", "--listen", f"{SERVERS[number]}:8080", **environment_of("server"))
    name_all()


def start_worker(number):
    address = f"{WORKERS[number]}:8080"
    command = [address if part == "0.0.0.0:8080" else part for part in compose["services"]["worker"]["command"]]
    assert address in command
    start(f"worker-{number}", binary, *command, **environment_of("worker"))
    name_all()


def start_postgres():
    """With the password and the flags that deploy/compose.yaml has for it."""
    programs = max(Path("/usr/lib/postgresql").glob("*/bin"), key=lambda path: int(path.parent.name))
    service = compose["services"]["postgres"]
    data, settings = work / "postgres", environment_of("postgres")
    as_nobody = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"]
    if not data.exists():
        data.mkdir(mode=0o700)
        os.chown(data, NOBODY, NOBODY)
        (work / "password").write_text(settings["POSTGRES_PASSWORD"])
        subprocess.run(
            [*as_nobody, programs / "initdb", "--pgdata", data, "--auth=scram-sha-256", f"--pwfile={work / 'password'}",
             f"--username={settings['POSTGRES_USER']}", "--encoding=UTF8", "--no-locale"],
            check=True, stdout=subprocess.DEVNULL,
        )
        subprocess.run(
            [*as_nobody, programs / "postgres", "--single", "-D", data, "postgres"], check=True, text=True,
            input=f"CREATE DATABASE {settings['POSTGRES_DB']}\n", capture_output=True,
        )
    start(
        "postgres", *as_nobody, programs / "postgres", "-D", data, "-c", f"listen_addresses={POSTGRES}",
        "-c", "unix_socket_directories=", *service["command"][1:],
    )


def name_all():
    """Has the name server answer for who has been started, as Docker's does."""
    addresses = {"server": SERVERS, "worker": WORKERS}
    lines = [f"{POSTGRES} postgres"]
    for name in processes:
        kind, _, number = name.partition("-")
        if kind in addresses:
            lines.append(f"{addresses[kind][int(number)]} {kind}")
    # At once: the name server may be reading the file.
    (work / "hosts.new").write_text("".join(f"{line}\n" for line in lines))
    (work / "hosts.new").rename(work / "hosts")
    processes["dns"].send_signal(signal.SIGHUP)


def requests_of(number):
    """Requests for the list of jobs that one server has answered."""
    _, _, text = ask("GET", "/metrics", address=(SERVERS[number], 8080))
    return sum(
        int(count) for count in re.findall(r'graspd_http_requests_total\{method="GET",route="/jobs",.*?\} (\d+)', text.decode())
    )


def check_absence():
    refused = ask("GET", "/jobs")
    assert problem(refused) == "Service Unavailable" and int(refused[1]["Retry-After"]) > 0, refused


def received(server):
    """Bytes of the largest file that a server has open: what it has received of an upload."""
    sizes = [0]
    for file in Path(f"/proc/{processes[f'server-{server}'].pid}/fd").iterdir():
        try:
            status = file.stat()
        except FileNotFoundError:
            continue
        if stat.S_ISREG(status.st_mode):
            sizes.append(status.st_size)
    return max(sizes)


def check_upload():
    """A file just below the limit arrives while it is sent; one above is refused before it is."""
    mesh = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    line = b"#" * 1023 + b"\n"
    padding = 255 * 1024
    connection = http.client.HTTPConnection(*PROXY, timeout=PATIENCE_S)
    connection.putrequest("POST", "/meshes?format=obj")
    for name, value in {
        "Authorization": f"Bearer {robot}",
        "Content-Type": "application/octet-stream",
        "Content-Length": str(padding * len(line) + len(mesh)),
    }.items():
        connection.putheader(name, value)
    connection.endheaders()
    half = padding // 2
    for _ in range(half // 1024):
        connection.send(line * 1024)
    until(
        "half of an upload passes the proxy before the rest is sent",
        lambda: any(received(number) > half * len(line) // 2 for number in SERVERS),
    )
    connection.send(line * (padding - half // 1024 * 1024))
    connection.send(mesh)
    answer = connection.getresponse()
    answered = json.loads(answer.read())
    assert answer.status == 201 and answered["report"]["triangles"] == 4, (answer.status, answered)

    connection = http.client.HTTPConnection(*PROXY, timeout=PATIENCE_S)
    connection.putrequest("POST", "/meshes?format=obj")
    connection.putheader("Authorization", f"Bearer {robot}")
    connection.putheader("Content-Type", "application/octet-stream")
    connection.putheader("Content-Length", str(300 * MIB))
    connection.endheaders()
    answer = connection.getresponse()
    assert problem((answer.status, answer.headers, answer.read())) == "/problems/too-large", answer.status


def submit(**settings):
    """Plans on the duck, through the proxy."""
    duck = Path("examples/meshes/duck.obj").read_bytes()
    status, _, answered = ask("POST", "/meshes", duck, {"Content-Type": "model/obj"})
    assert status in (200, 201), (status, answered)
    request = json.dumps({"mesh_id": json.loads(answered)["id"], "seed": 1} | settings)
    status, _, answered = ask("POST", "/jobs", request, {"Content-Type": "application/json"})
    assert status == 202, (status, answered)
    return json.loads(answered)["id"]


def check_following():
    """Events and a long poll of a job that ends only once they have been heard, whichever servers they are at."""
    job = submit(generations=100_000)
    polled = []
    poll = threading.Thread(target=lambda: polled.append(ask("GET", f"/jobs/{job}?wait=60")))
    poll.start()
    connection = http.client.HTTPConnection(*PROXY, timeout=PATIENCE_S)
    connection.request("GET", f"/jobs/{job}/events", headers={"Authorization": f"Bearer {robot}"})
    heard = []
    for line in connection.getresponse():
        if line.startswith(b"event: "):
            heard.append(line[7:].strip().decode())
            if heard[-1] == "progress" and heard.count("progress") == 3:
                assert poll.is_alive(), f"a long poll was answered before the job ended: {polled}"
                assert ask("POST", f"/jobs/{job}/cancel")[0] in (200, 202)
    assert heard[0] == "snapshot" and heard[-1] == "end", heard
    poll.join(PATIENCE_S)
    status, _, answered = polled[0]
    assert status == 200 and json.loads(answered)["state"] == "cancelled", (status, answered[:300])


def check_spread():
    """Both servers get requests, and both workers plan."""
    before = {number: requests_of(number) for number in SERVERS}
    until(
        "both servers get requests",
        lambda: ask("GET", "/jobs")[0] == 200 and all(requests_of(number) > before[number] + 3 for number in SERVERS),
    )
    jobs = [submit(generations=5) for _ in range(8)]
    for job in jobs:
        status, _, answered = ask("GET", f"/jobs/{job}?wait=60")
        assert status == 200 and json.loads(answered)["state"] == "succeeded", answered[:300]
    ended = {number: runs_of(WORKERS[number]) for number in WORKERS}
    assert all(ended.values()) and sum(ended.values()) >= len(jobs), ended
    assert [runs_of(address) for address in SERVERS.values()] == [0, 0], "a server has planned"


def runs_of(address):
    """Runs that one process has ended."""
    _, _, text = ask("GET", "/metrics", address=(address, 8080))
    return sum(int(count) for count in re.findall(r"graspd_job_run_seconds_count\{.*?\} (\d+)", text.decode()))


def check_ends():
    """Nobody who reads notices that a server goes, in good order or not, or that one comes."""
    seen = {}
    over = threading.Event()

    def read():
        while not over.is_set():
            answer = ask("GET", "/jobs")
            seen[answer[0]] = seen.get(answer[0], 0) + 1

    readers = [threading.Thread(target=read) for _ in range(4)]
    for reader in readers:
        reader.start()
    for how in (signal.SIGTERM, signal.SIGKILL):
        until("readers are at work", lambda: requests_of(1) > 10)
        stop("server-1", how)
        until("they go on", lambda before=sum(seen.values()): sum(seen.values()) > before + 200)
        start_server(1)
        until("the server is back", lambda: ask("GET", "/readyz", address=(SERVERS[1], 8080))[0] == 200)
    over.set()
    for reader in readers:
        reader.join()
    assert seen.keys() == {200}, seen


def check_workers_end():
    """A worker that has to end gives its job time, as long as the drain is."""
    stop("worker-2")
    name_all()
    job = submit(generations=100)
    until("the job runs", lambda: json.loads(ask("GET", f"/jobs/{job}")[2])["state"] != "queued")
    assert stop("worker-1") == 0
    answered = json.loads(ask("GET", f"/jobs/{job}")[2])
    assert answered["state"] == "succeeded" and answered["attempt"] == 1, answered
    start_worker(1)


def check_readiness():
    """Without the database no server can do new work: its refusal comes through, not one of the proxy."""
    stop("postgres", signal.SIGQUIT)

    def refusal():
        return problem(answer) if (answer := ask("GET", "/readyz"))[0] == 503 else ""

    until("the refusal is that of a server", lambda: refusal().startswith("/problems/store"))
    # Until the proxy has looked for certain.
    time.sleep(4 * CHECK_INTERVAL_S)
    answered = refusal()
    assert answered.startswith("/problems/store"), answered
    start_postgres()
    until("the servers are ready again", lambda: ask("GET", "/readyz")[0] == 200)
    job = submit(generations=1)
    answered = json.loads(ask("GET", f"/jobs/{job}?wait=60")[2])
    assert answered["state"] == "succeeded", answered


def prometheus(path, **query):
    """What its interface answers; None before it is ready."""
    url = f"{PROMETHEUS}/api/v1/{path}?{urllib.parse.urlencode(query)}"
    try:
        with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:
            return json.load(answer)["data"]
    except urllib.error.HTTPError as fault:
        if fault.code == 503:
            return None
        raise AssertionError(f"{query}: {fault.read().decode()}") from fault
    except OSError:
        return None


def check_metrics():
    """Every metric that is named anywhere is there, and every expression finds something."""
    def targets():
        found = prometheus("targets") or {"activeTargets": []}
        return sorted((target["labels"]["job"], target["health"]) for target in found["activeTargets"])

    def scraped_twice():
        found = prometheus("query", query="rate(graspd_http_requests_total[1m])")["result"]
        return {series["metric"]["instance"].split(":")[0] for series in found} == {*SERVERS.values(), *WORKERS.values()}

    everyone = [("graspd-server", "up")] * 2 + [("graspd-worker", "up")] * 2
    until("Prometheus scrapes the servers, with its key, and the workers", lambda: targets() == everyone)
    until("everyone is scraped twice", scraped_twice)

    there = set(prometheus("label/__name__/values"))
    files = [path for path in DEPLOY.rglob("*") if path.is_file()]
    named = {name for path in files for name in re.findall(r"\bgraspd_[a-z0-9_]+", path.read_text())}
    assert len(named) > 10 and named <= there, f"no server reports {sorted(named - there)}"

    panels = json.loads((DEPLOY / "grafana" / "graspd.json").read_text())["panels"]
    expressions = [target["expr"].replace("$__rate_interval", "1m") for panel in panels for target in panel["targets"]]
    for expression in expressions:
        assert prometheus("query", query=expression)["result"], f"nothing is found by {expression}"

    scaled = yaml.safe_load((DEPLOY / "kubernetes" / "autoscaling.yaml").read_text())
    query = scaled["spec"]["triggers"][0]["metadata"]["query"]
    jobs = [submit(generations=100_000) for _ in range(5)]

    def wanted():
        found = prometheus("query", query=query)["result"]
        assert len(found) == 1, f"{query}: {found}"
        return int(found[0]["value"][1])

    until("the scaler sees the jobs that run and wait", lambda: wanted() == len(jobs))
    for job in jobs:
        ask("POST", f"/jobs/{job}/cancel")
    until("the scaler sees that there are none", lambda: wanted() == 0)

    def health():
        return {rule["health"] for group in prometheus("rules")["groups"] for rule in group["rules"]}

    until("the rules are evaluated", lambda: health() == {"ok"})
    return f"{len(named)} metrics, {len(expressions)} expressions of the dashboard"


def make_key(name):
    made = subprocess.run(
        [binary, "keys", "create", name], env=os.environ | environment_of("server"), check=True, capture_output=True, text=True
    )
    return made.stdout.strip()


def lay_out():
    """What Docker lays into its containers, and what has to be there before they start."""
    (work / "resolv.conf").write_text(f"nameserver {NAME_SERVER}\n")
    subprocess.run(["mount", "--bind", work / "resolv.conf", Path("/etc/resolv.conf").resolve()], check=True)
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run"], check=True)
    # Only one process can have the port on all addresses.
    text = (DEPLOY / "haproxy.cfg").read_text()
    assert text.count("bind :8080\n") == 1
    (work / "haproxy.cfg").write_text(text.replace("bind :8080\n", f"bind {PROXY[0]}:8080\n"))
    (work / "hosts").touch()
    work.chmod(0o711)


def keys_are_made():
    """As soon as the database answers."""
    global robot
    try:
        robot = make_key("robot")
    except subprocess.CalledProcessError:
        return False
    Path("/run/secrets").mkdir()
    Path("/run/secrets/prometheus_key").write_text(make_key("prometheus"))
    return True


def run():
    start(
        "dns", "dnsmasq", "--keep-in-foreground", "--conf-file=/dev/null", "--user=root", "--group=", "--pid-file=",
        "--no-resolv", "--no-hosts", "--bind-interfaces", f"--listen-address={NAME_SERVER}",
        f"--addn-hosts={work / 'hosts'}",
    )
    start("proxy", "haproxy", "-db", "-f", work / "haproxy.cfg")
    until("the proxy answers", lambda: ask("GET", "/jobs")[0])
    check_absence()

    start_postgres()
    name_all()
    until("keys can be made", keys_are_made)
    for number in (1, 2):
        start_server(number)
        start_worker(number)
    until("the proxy finds the servers", lambda: ask("GET", "/jobs")[0] == 200)
    assert ask("GET", "/jobs", key=False)[0] == 401
    check_upload()
    check_following()
    check_spread()
    print("deploy: uploads, events and long polls pass the proxy; both workers plan", flush=True)

    start(
        "prometheus", "prometheus", f"--config.file={DEPLOY.resolve() / 'prometheus.yml'}",
        f"--storage.tsdb.path={work / 'tsdb'}", f"--web.listen-address={urllib.parse.urlsplit(PROMETHEUS).netloc}",
    )
    print("deploy: Prometheus has", check_metrics(), flush=True)
    check_ends()
    print("deploy: servers come and go behind the proxy unnoticed", flush=True)
    check_workers_end()
    check_readiness()
    print("deploy: workers end in good order, and the database may be away")


binary = sys.argv[1]
compose = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
robot = ""
try:
    lay_out()
    run()
finally:
    for process in processes.values():
        process.kill()
    shutil.rmtree(work, ignore_errors=True)
