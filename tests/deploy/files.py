"""What the files below deploy/ and examples/sweeps say of one another, of Kubernetes, and of the program.

    files.py BINARY

Compose's own schema is checked elsewhere; custom resources of operators have no schema here.
"""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import kubernetes_validate
import yaml

KUBERNETES = "1.34"
CUSTOM = {"ScaledObject", "PodMonitor", "Kustomization"}
# Secrets that are made by hand, as the comments say.
SECRETS = {"graspd-store", "graspd-prometheus", "graspd-tls"}
CLAIMS = {"graspd-sweep"}
# Seconds that a server or worker may take to end beside what it waits for.
END_S = 25

faults = []


def expect(holds, what):
    if not holds:
        faults.append(what)


def seconds(text):
    number, unit = re.fullmatch(r"(\d+)(s|m)", text).groups()
    return int(number) * {"s": 1, "m": 60}[unit]


def find(node, key):
    """Every value of `key`, at any depth."""
    if isinstance(node, dict):
        for name, value in node.items():
            if name == key:
                yield value
            yield from find(value, key)
    elif isinstance(node, list):
        for value in node:
            yield from find(value, key)


def check_flags(binary, where, command, variables):
    """`command`: a subcommand with its flags; `variables`: what its environment sets."""
    answer = subprocess.run([binary, command[0], "--help"], capture_output=True, text=True)
    expect(answer.returncode == 0, f"{where}: graspd has no command {command[0]}")
    # The image sets some for every command, which those that do not know them ignore.
    known = set(re.findall(r"\bGRASPD_[A-Z_]+", answer.stdout)) | {"GRASPD_AUTH"}
    for name in variables:
        expect(not name.startswith("GRASPD_") or name in known, f"{where}: graspd {command[0]} knows no {name}")
    for flag in command[1:]:
        expect(not flag.startswith("--") or flag in answer.stdout, f"{where}: graspd {command[0]} knows no {flag}")


def check_compose(binary):
    path = Path("deploy/compose.yaml")
    text = path.read_text()
    compose = yaml.safe_load(text)
    example = dict(
        line.split("=", 1) for line in Path("deploy/.env.example").read_text().splitlines() if re.match(r"\w+=", line)
    )
    used = set(re.findall(r"\$\{(\w+)", text)) | set(find(compose.get("secrets"), "environment"))
    expect(used == example.keys(), f".env.example and compose.yaml differ in {sorted(used ^ example.keys())}")

    # As the comments say to do in a container of a server.
    keys = subprocess.run([binary, "keys", "create", "--help"], capture_output=True, text=True)
    expect("GRASPD_STORE" in keys.stdout, "compose.yaml: graspd keys knows no GRASPD_STORE")

    services = compose["services"]
    for name, service in services.items():
        where = f"compose.yaml, {name}"
        for other in service.get("depends_on", []):
            expect(other in services, f"{where}: depends on {other}, which is no service")
        for volume in service.get("volumes", []):
            source, *target = volume.split(":")
            if not target:
                continue
            if source.startswith("."):
                expect((path.parent / source).is_file(), f"{where}: there is no file {source}")
            else:
                expect(source in compose["volumes"], f"{where}: there is no volume {source}")
        for secret in service.get("secrets", []):
            expect(secret in compose["secrets"], f"{where}: there is no secret {secret}")
        if service["image"].startswith("graspd:"):
            expect((path.parent / service["build"]["context"] / "Dockerfile").is_file(), f"{where}: no Dockerfile")
            command = service.get("command", ["serve"])
            check_flags(binary, where, command, service["environment"])
            drain = seconds(service["environment"].get("GRASPD_DRAIN", "0s"))
            grace = seconds(service["stop_grace_period"])
            expect(grace >= drain + END_S, f"{where}: is killed after {grace} s, which may take {drain + END_S}")


def pods(document):
    """Pod templates of a document."""
    spec = document.get("spec", {})
    return [spec["template"]] if "template" in spec else []


def check_pod(binary, where, pod, routes):
    spec = pod["spec"]
    expect(spec.get("securityContext", {}).get("runAsNonRoot") is True, f"{where}: may run as root")
    volumes = {volume["name"] for volume in spec.get("volumes", [])}
    for container in spec["containers"]:
        security = container.get("securityContext", {})
        expect(security.get("readOnlyRootFilesystem") is True, f"{where}: can write to its root file system")
        expect(security.get("allowPrivilegeEscalation") is False, f"{where}: can gain privileges")
        expect(security.get("capabilities") == {"drop": ["ALL"]}, f"{where}: has capabilities")
        expect(container["resources"].keys() == {"requests", "limits"}, f"{where}: wants requests and limits")
        names = {port["name"] for port in container.get("ports", [])}
        for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
            get = container.get(probe, {}).get("httpGet")
            if get:
                expect(get["port"] in names, f"{where}: {probe} asks a port that is not named")
                expect(get["path"] in routes, f"{where}: {probe} asks {get['path']}, which is no route")
        mounted = {mount["name"] for mount in container.get("volumeMounts", [])}
        expect(mounted >= volumes, f"{where}: {sorted(volumes - mounted)} are not mounted")
        if container["image"] != "graspd":
            continue
        variables = {variable["name"]: variable.get("value") for variable in container.get("env", [])}
        if "args" in container:
            check_flags(binary, where, container["args"], variables)
            paths = [container.get(probe, {}).get("httpGet", {}).get("path") for probe in ("livenessProbe", "readinessProbe")]
            expect(paths == ["/healthz", "/readyz"], f"{where}: probes ask {paths}")
            pause = container.get("lifecycle", {}).get("preStop", {}).get("sleep", {}).get("seconds", 0)
            needed = pause + seconds(variables.get("GRASPD_DRAIN") or "0s") + END_S
            grace = spec["terminationGracePeriodSeconds"]
            expect(grace >= needed, f"{where}: is killed after {grace} s, which may take {needed}")
    for secret in [found["name"] for found in find(spec, "secretKeyRef")]:
        expect(secret in SECRETS, f"{where}: nothing says how to make the secret {secret}")
    for claim in find(spec, "claimName"):
        expect(claim in CLAIMS, f"{where}: nothing says how to make the claim {claim}")


def check_kubernetes(binary):
    routes = json.loads(Path("openapi/openapi.json").read_text())["paths"].keys()
    files = sorted(Path().glob("deploy/kubernetes*/*.yaml")) + sorted(Path("examples/sweeps").glob("*.yaml"))
    documents = [(path, document) for path in files for document in yaml.safe_load_all(path.read_text())]
    expect(len(documents) >= 10, f"only {len(documents)} documents for Kubernetes")
    for path, document in documents:
        if document["kind"] not in CUSTOM:
            try:
                kubernetes_validate.validate(document, KUBERNETES, strict=True)
            except kubernetes_validate.ValidationError as fault:
                expect(False, f"{path}, {document['kind']}: {fault.message} at {list(fault.path)}")
        for pod in pods(document):
            check_pod(binary, f"{path}, {document['kind']}", pod, routes)

    labelled = [
        pod["metadata"]["labels"] for _, document in documents for pod in pods(document) if "labels" in pod.get("metadata", {})
    ]
    names = {(document["kind"], document.get("metadata", {}).get("name")) for _, document in documents}
    ports = {port["name"] for pod in find([document for _, document in documents], "ports") for port in pod}
    for path, document in documents:
        where = f"{path}, {document['kind']}"
        selector = document.get("spec", {}).get("selector", {})
        selector = selector.get("matchLabels", selector)
        matching = [labels for labels in labelled if selector.items() <= labels.items()]
        expect(not selector or len(matching) == 1, f"{where}: selects {len(matching)} kinds of pod")
        if document["kind"] == "ScaledObject":
            target = document["spec"]["scaleTargetRef"]["name"]
            expect(("Deployment", target) in names, f"{where}: there is no Deployment {target}")
        if document["kind"] == "PodMonitor":
            for endpoint in document["spec"]["podMetricsEndpoints"]:
                expect(endpoint["port"] in ports and endpoint["path"] in routes, f"{where}: nothing answers {endpoint}")
        if document["kind"] == "Service":
            for port in document["spec"]["ports"]:
                expect(port["targetPort"] in ports, f"{where}: no container has the port {port['targetPort']}")
        if document["kind"] == "Kustomization":
            for resource in document["resources"]:
                expect((path.parent / resource).exists(), f"{where}: there is no {resource}")
        for service in find(document, "service") if document["kind"] == "Ingress" else []:
            expect(("Service", service["name"]) in names, f"{where}: there is no Service {service['name']}")

    # A validator that finds fault with nothing proves nothing.
    document = next(document for _, document in documents if document["kind"] == "Deployment")
    document["spec"]["template"]["spec"]["containers"][0]["livenessProb"] = {}
    try:
        kubernetes_validate.validate(document, KUBERNETES, strict=True)
        expect(False, "the validator finds no fault with a field that does not exist")
    except kubernetes_validate.ValidationError:
        pass
    return len(documents)


def check_kustomizations():
    """With the real program, where it is there."""
    if not shutil.which("kubectl"):
        return "not built, there is no kubectl"
    for path in sorted(Path().glob("deploy/*/kustomization.yaml")):
        built = subprocess.run(["kubectl", "kustomize", path.parent], capture_output=True, text=True)
        expect(built.returncode == 0, f"{path}: {built.stderr}")
        expect(":0.1.0" in built.stdout, f"{path}: the image has no version")
    return "built"


def check_dashboard():
    dashboard = json.loads(Path("deploy/grafana/graspd.json").read_text())
    taken = {}
    for panel in dashboard["panels"]:
        at = panel["gridPos"]
        for cell in ((x, y) for x in range(at["x"], at["x"] + at["w"]) for y in range(at["y"], at["y"] + at["h"])):
            expect(cell[0] < 24, f"dashboard: {panel['title']} is wider than the page")
            other = taken.setdefault(cell, panel["title"])
            expect(other == panel["title"], f"dashboard: {panel['title']} lies on {other}")
    ids = [panel["id"] for panel in dashboard["panels"]]
    expect(len(ids) == len(set(ids)), "dashboard: panels have the same id")
    sources = {source["uid"] for source in yaml.safe_load(Path("deploy/grafana/datasource.yaml").read_text())["datasources"]}
    expect({found["uid"] for found in find(dashboard, "datasource")} == sources, "dashboard: asks another data source")
    return len(ids)


binary = sys.argv[1]
check_compose(binary)
documents = check_kubernetes(binary)
kustomizations = check_kustomizations()
panels = check_dashboard()
for fault in faults:
    print(fault, file=sys.stderr)
print(f"deploy: {documents} documents for Kubernetes, kustomizations {kustomizations}, {panels} panels; {len(faults)} faults")
sys.exit(1 if faults else 0)
