/** A planning request as text for other programs. */

import { stringify } from "./api/json";

/** Quotes a text as one argument of a shell command. */
export const shell = (text: string): string => `'${text.replaceAll("'", "'\\''")}'`;

function body(meshId: string, request: Record<string, unknown>): Record<string, unknown> {
  const given = Object.entries(request).filter(([, value]) => value !== null);
  return { mesh_id: meshId, ...Object.fromEntries(given) };
}

export function asJson(meshId: string, request: Record<string, unknown>): string {
  return stringify(body(meshId, request), 2);
}

export function asCurl(
  origin: string,
  meshId: string,
  request: Record<string, unknown>,
  keyed: boolean,
): string {
  const key = keyed ? ' -H "Authorization: Bearer $GRASPD_API_KEY"' : "";
  const json = shell(stringify(body(meshId, request)));
  return `curl -i${key} -H 'Content-Type: application/json' -d ${json} ${shell(`${origin}/jobs`)}`;
}

export function asPython(
  origin: string,
  meshId: string,
  request: Record<string, unknown>,
  keyed: boolean,
): string {
  // Encoded twice: a JSON string is also a valid string of Python.
  const json = JSON.stringify(stringify(body(meshId, request)));
  const key = keyed ? `, "Authorization": "Bearer " + os.environ["GRASPD_API_KEY"]` : "";
  return `import json, os, urllib.request

server = ${JSON.stringify(origin)}
headers = {"Content-Type": "application/json"${key}}
request = json.loads(${json})

def call(path, body=None):
    sent = urllib.request.Request(server + path, body, headers)
    with urllib.request.urlopen(sent) as answer:
        return json.load(answer)

job = call("/jobs", json.dumps(request).encode())
while job["state"] in ("queued", "running"):
    job = call(f"/jobs/{job['id']}?wait=30")
result = job.get("result") or {"quality": None, "contacts": []}
print(job["state"], result["quality"], job.get("problem", {}).get("detail", ""))
for contact in result["contacts"]:
    print(contact["position"], contact["normal"])
`;
}
