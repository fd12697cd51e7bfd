"""Two servers behind the proxy of deploy/ and under its Prometheus, all real, with the files as they are.

    stack.py BINARY

Wants a network and mounts of its own, as `unshare --net --mount` gives them: addresses, ports and the name server
are those of the containers. A third server stands in for the worker that Prometheus looks for. The servers have
embedded stores here, so each knows only its own jobs: what follows a job is done while there is one server.
"""

import http.client
import json
import os
import re
import shutil
import signal
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
SERVERS = {1: "127.0.0.21", 2: "127.0.0.22"}
WORKER = "127.0.0.31"
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
        [str(part) for part in command], stdout=log, stderr=log, env=os.environ | environment
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
    told = json.loads(body)
    assert told["status"] == status, told
    return told["type"] if told["type"] != "about:blank" else told["title"]


def start_server(number, **settings):
    """With the settings that deploy/compose.yaml has for servers, but for the store."""
    start(
        f"server-{number}", binary, "serve", "--listen", f"{SERVERS[number]}:8080", "--data-dir", work / f"data-{number}",
        **(environment | settings),
    )
    names(*(SERVERS[int(name[-1])] for name in processes if name.startswith("server-")))


def names(*addresses):
    """What the name server answers for `server`."""
    (work / "hosts").write_text("".join(f"{address} server\n" for address in addresses) + f"{WORKER} worker\n")
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


def check_upload():
    """A file just below the limit arrives while it is sent; one above is refused before it is."""
    mesh = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    line = b"#" * 1023 + b"\n"
    padding = 255 * 1024
    received = work / "data-1" / "uploads"
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
        lambda: sum(file.stat().st_size for file in received.iterdir()) > half * 1024 // 2,
    )
    connection.send(line * (padding - half // 1024 * 1024))
    connection.send(mesh)
    answer = connection.getresponse()
    told = json.loads(answer.read())
    assert answer.status == 201 and told["report"]["triangles"] == 4, (answer.status, told)

    connection = http.client.HTTPConnection(*PROXY, timeout=PATIENCE_S)
    connection.putrequest("POST", "/meshes?format=obj")
    connection.putheader("Authorization", f"Bearer {robot}")
    connection.putheader("Content-Type", "application/octet-stream")
    connection.putheader("Content-Length", str(300 * MIB))
    connection.endheaders()
    answer = connection.getresponse()
    assert problem((answer.status, answer.headers, answer.read())) == "/problems/too-large", answer.status


def check_following():
    """Events and a long poll of a job that ends only once they have been heard."""
    duck = {"Content-Type": "model/obj"}
    status, _, told = ask("POST", "/meshes", Path("examples/meshes/duck.obj").read_bytes(), duck)
    assert status == 201, (status, told)
    request = json.dumps({"mesh_id": json.loads(told)["id"], "generations": 100_000, "seed": 1})
    status, _, told = ask("POST", "/jobs", request, {"Content-Type": "application/json"})
    assert status == 202, (status, told)
    job = json.loads(told)["id"]
    polled = []
    poll = threading.Thread(target=lambda: polled.append(ask("GET", f"/jobs/{job}?wait=60")))
    poll.start()
    connection = http.client.HTTPConnection(*PROXY, timeout=PATIENCE_S)
    connection.request("GET", f"/jobs/{job}/events", headers={"Authorization": f"Bearer {robot}"})
    stream = connection.getresponse()
    heard = []
    for line in stream:
        if line.startswith(b"event: "):
            heard.append(line[7:].strip().decode())
            if heard.count("progress") == 3:
                assert poll.is_alive(), "a long poll was answered before the job ended"
                assert ask("POST", f"/jobs/{job}/cancel")[0] in (200, 202)
    assert heard[0] == "snapshot" and heard[-1] == "end", heard
    poll.join(PATIENCE_S)
    status, _, told = polled[0]
    assert status == 200 and json.loads(told)["state"] == "cancelled", (status, told[:300])


def check_spread():
    until("the second server gets requests", lambda: ask("GET", "/jobs")[0] == 200 and requests_of(2) > 3)
    before = requests_of(1)
    until("the first server gets requests too", lambda: ask("GET", "/jobs")[0] == 200 and requests_of(1) > before + 3)


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


def check_readiness():
    """No server can do new work: reading goes on, and the refusal of the server comes through."""
    stop("server-1")
    start_server(1, GRASPD_MIN_FREE_DISK="1000000GB")
    until("the server is up", lambda: ask("GET", "/readyz", address=(SERVERS[1], 8080))[0] == 503)
    stop("server-2")
    names(SERVERS[1])
    until("reading goes on", lambda: ask("GET", "/jobs")[0] == 200)
    # Until the proxy has looked for certain: twice before it gives a server up.
    time.sleep(4 * CHECK_INTERVAL_S)
    told = problem(ask("GET", "/readyz"))
    assert told == "/problems/disk-low", told
    refused = ask("POST", "/meshes?format=obj", b"v 0 0 0\n", {"Content-Type": "application/octet-stream"})
    assert problem(refused) == "/problems/disk-full" and refused[0] == 507, refused


def prometheus(path, **query):
    url = f"{PROMETHEUS}/api/v1/{path}?{urllib.parse.urlencode(query)}"
    try:
        with urllib.request.urlopen(url, timeout=PATIENCE_S) as answer:
            return json.load(answer)["data"]
    except urllib.error.HTTPError as fault:
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
        return {series["metric"]["instance"].split(":")[0] for series in found} == {*SERVERS.values(), WORKER}

    both_and_worker = [("graspd-server", "up")] * 2 + [("graspd-worker", "up")]
    until("Prometheus scrapes the servers, with its key, and the worker", lambda: targets() == both_and_worker)
    until("everyone is scraped twice", scraped_twice)

    there = set(prometheus("label/__name__/values"))
    files = [path for path in DEPLOY.rglob("*") if path.is_file()]
    named = {name for path in files for name in re.findall(r"\bgraspd_[a-z0-9_]+", path.read_text())}
    assert len(named) > 10 and named <= there, f"no server tells {sorted(named - there)}"

    panels = json.loads((DEPLOY / "grafana" / "graspd.json").read_text())["panels"]
    expressions = [target["expr"].replace("$__rate_interval", "1m") for panel in panels for target in panel["targets"]]
    for expression in expressions:
        assert prometheus("query", query=expression)["result"], f"nothing is found by {expression}"

    scaled = yaml.safe_load((DEPLOY / "kubernetes" / "autoscaling.yaml").read_text())
    query = scaled["spec"]["triggers"][0]["metadata"]["query"]
    found = prometheus("query", query=query)["result"]
    assert len(found) == 1 and found[0]["value"][1] == "0", f"{query}: {found}"

    def health():
        return {rule["health"] for group in prometheus("rules")["groups"] for rule in group["rules"]}

    until("the rules are evaluated", lambda: health() == {"ok"})
    return f"{len(named)} metrics, {len(expressions)} expressions of the dashboard"


def make_key(name):
    command = [binary, "keys", "create", name, "--data-dir", work / "data-1"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()


def lay_out():
    """What Docker lays into its containers, and what has to be there before they start."""
    (work / "resolv.conf").write_text(f"nameserver {NAME_SERVER}\n")
    subprocess.run(["mount", "--bind", work / "resolv.conf", Path("/etc/resolv.conf").resolve()], check=True)
    subprocess.run(["mount", "-t", "tmpfs", "tmpfs", "/run"], check=True)
    Path("/run/secrets").mkdir()
    Path("/run/secrets/prometheus_key").write_text(make_key("prometheus"))
    # Only one process can have the port on all addresses.
    text = (DEPLOY / "haproxy.cfg").read_text()
    assert text.count("bind :8080\n") == 1
    (work / "haproxy.cfg").write_text(text.replace("bind :8080\n", f"bind {PROXY[0]}:8080\n"))
    (work / "hosts").touch()


def run():
    start(
        "dns", "dnsmasq", "--keep-in-foreground", "--conf-file=/dev/null", "--user=root", "--group=", "--pid-file=",
        "--no-resolv", "--no-hosts", "--bind-interfaces", f"--listen-address={NAME_SERVER}",
        f"--addn-hosts={work / 'hosts'}",
    )
    start("proxy", "haproxy", "-db", "-f", work / "haproxy.cfg")
    until("the proxy answers", lambda: ask("GET", "/jobs")[0])
    check_absence()

    start_server(1)
    until("the proxy finds the server", lambda: ask("GET", "/jobs")[0] == 200)
    assert ask("GET", "/jobs", key=False)[0] == 401
    check_upload()
    check_following()
    print("deploy: uploads, events and long polls pass the proxy")

    start(
        "prometheus", "prometheus", f"--config.file={DEPLOY / 'prometheus.yml'}",
        f"--storage.tsdb.path={work / 'tsdb'}", f"--web.listen-address={urllib.parse.urlsplit(PROMETHEUS).netloc}",
    )
    start("worker", binary, "serve", "--listen", f"{WORKER}:8080", "--auth", "off", "--data-dir", work / "worker")
    start_server(2)
    check_spread()
    print("deploy: Prometheus has", check_metrics())
    check_ends()
    check_readiness()
    print("deploy: servers come and go behind the proxy unnoticed")


binary = sys.argv[1]
compose = yaml.safe_load((DEPLOY / "compose.yaml").read_text())
environment = {
    name: re.sub(r"\$\{\w+:-(.*?)\}", r"\1", value)
    for name, value in compose["services"]["server"]["environment"].items()
    # An embedded store is the server's own, and so it has to plan.
    if name not in ("GRASPD_STORE", "GRASPD_WORKERS")
}
try:
    robot = make_key("robot")
    lay_out()
    # Both know the same keys.
    shutil.copytree(work / "data-1", work / "data-2")
    run()
finally:
    for process in processes.values():
        process.kill()
    shutil.rmtree(work, ignore_errors=True)
