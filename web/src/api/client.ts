/** Calls of the service. Every refusal is a `Problem` in the service's own words. */

import { StoredValue } from "../storage";
import { parse, stringify } from "./json";
import type { Evaluation, FieldError, JobPage, JobRecord, MeshRecord, ProblemBody } from "./types";

/** The window event that is sent when the server requires an API key, or a different one. */
export const KEY_REQUIRED = "graspd-key-required";

/** A refusal of the service. `status` is 0 when the server cannot be reached. */
export class Problem extends Error {
  readonly status: number;
  readonly title: string;
  readonly errors: FieldError[];

  constructor(body: ProblemBody) {
    super(body.detail);
    this.status = body.status;
    this.title = body.title;
    this.errors = body.errors ?? [];
  }

  static unreachable(): Problem {
    return new Problem({
      status: 0,
      title: "No answer",
      detail: "The server cannot be reached. Check that it is running, then try again.",
    });
  }

  static of(status: number, text: string): Problem {
    try {
      const body = JSON.parse(text) as Partial<ProblemBody>;
      if (typeof body.title === "string" && typeof body.detail === "string") {
        return new Problem({ ...body, title: body.title, detail: body.detail, status });
      }
    } catch {
      // A proxy may answer in its own words.
    }
    return new Problem({ status, title: `Status ${status}`, detail: text.slice(0, 300) });
  }
}

/** The API key, which is kept until the tab is closed. */
export const apiKey = new StoredValue(() => sessionStorage, "graspd-api-key");

function headers(): Record<string, string> {
  const key = apiKey.get();
  return key === null ? {} : { Authorization: `Bearer ${key}` };
}

function refusal(status: number, text: string): Problem {
  if (status === 401) {
    window.dispatchEvent(new Event(KEY_REQUIRED));
  }
  return Problem.of(status, text);
}

const isAbort = (error: unknown): boolean =>
  error instanceof DOMException && error.name === "AbortError";

/** Returns a response with a status below 400; anything else is thrown as a `Problem`. */
export async function call(path: string, init: RequestInit = {}): Promise<Response> {
  let response;
  try {
    const given = init.headers as Record<string, string> | undefined;
    response = await fetch(path, { ...init, headers: { ...headers(), ...given } });
  } catch (error) {
    throw isAbort(error) ? error : Problem.unreachable();
  }
  if (!response.ok) {
    throw refusal(response.status, await readBody(response.text()));
  }
  return response;
}

/** The body of a response; throws a `Problem` if the connection breaks before its end. */
async function readBody<T>(body: Promise<T>): Promise<T> {
  try {
    return await body;
  } catch (error) {
    throw isAbort(error) ? error : Problem.unreachable();
  }
}

async function json<T>(path: string, init: RequestInit = {}): Promise<T> {
  const accept = { Accept: "application/json", ...(init.headers as Record<string, string>) };
  const response = await call(path, { ...init, headers: accept });
  const text = await readBody(response.text());
  try {
    return parse(text) as T;
  } catch {
    // The answer does not come from the service.
    throw Problem.of(response.status, text);
  }
}

function post<T>(path: string, body: unknown, init: RequestInit = {}): Promise<T> {
  const given = init.headers as Record<string, string> | undefined;
  const type = { "Content-Type": "application/json", ...given };
  return json<T>(path, { ...init, method: "POST", headers: type, body: stringify(body) });
}

export const mesh = (id: string, signal: AbortSignal): Promise<MeshRecord> =>
  json(`/meshes/${encodeURIComponent(id)}`, { signal });

/** The surface for display, with at most `budget` triangles. */
export async function meshFile(
  id: string,
  budget: number,
  signal: AbortSignal,
): Promise<ArrayBuffer> {
  const path = `/meshes/${encodeURIComponent(id)}/file?format=glb&max_triangles=${budget}`;
  return readBody((await call(path, { signal })).arrayBuffer());
}

export const job = (id: string, signal: AbortSignal): Promise<JobRecord> =>
  json(`/jobs/${encodeURIComponent(id)}`, { signal });

export const jobs = (limit: number, signal: AbortSignal): Promise<JobPage> =>
  json(`/jobs?limit=${limit}`, { signal });

/** Submits a job; calls with the same key create only one. */
export const submit = (request: Record<string, unknown>, key: string): Promise<JobRecord> =>
  post("/jobs", request, { headers: { "Idempotency-Key": key } });

export const cancel = (id: string): Promise<JobRecord> =>
  json(`/jobs/${encodeURIComponent(id)}/cancel`, { method: "POST" });

export async function remove(id: string): Promise<void> {
  await call(`/jobs/${encodeURIComponent(id)}`, { method: "DELETE" });
}

/** Evaluates one given grasp. */
export async function evaluate(
  request: Record<string, unknown>,
  signal: AbortSignal,
): Promise<Evaluation> {
  interface Answer {
    evaluations: [Evaluation];
  }
  return (await post<Answer>("/evaluations", request, { signal })).evaluations[0];
}

/** A file that the service makes, such as a picture. */
export async function blob(path: string, signal?: AbortSignal): Promise<Blob> {
  return readBody((await call(path, signal === undefined ? {} : { signal })).blob());
}

/** Uploads a mesh and calls `progress` with the fraction that has been sent. */
export async function upload(
  file: File,
  units: string,
  progress: (share: number) => void,
  signal: AbortSignal,
): Promise<MeshRecord> {
  signal.throwIfAborted();
  const form = new FormData();
  if (units !== "") {
    form.append("units", units);
  }
  form.append("mesh", file, file.name);
  return new Promise((resolve, reject) => {
    // Only XMLHttpRequest reports the progress of an upload; fetch does not.
    const request = new XMLHttpRequest();
    request.open("POST", "/meshes");
    for (const [name, value] of Object.entries(headers())) {
      request.setRequestHeader(name, value);
    }
    request.setRequestHeader("Accept", "application/json");
    request.upload.onprogress = (event) => {
      progress(event.lengthComputable ? event.loaded / event.total : 0);
    };
    request.onerror = () => {
      reject(Problem.unreachable());
    };
    request.onload = () => {
      const { status, responseText: text } = request;
      try {
        if (status < 400) {
          resolve(parse(text) as MeshRecord);
          return;
        }
      } catch {
        // The answer does not come from the service.
      }
      reject(refusal(status, text));
    };
    request.onabort = () => {
      reject(new DOMException("The upload was cancelled", "AbortError"));
    };
    signal.addEventListener("abort", () => {
      request.abort();
    });
    request.send(form);
  });
}
