/** Servers for tests: each on a free port, with a folder of its own that is deleted afterwards. */

import { execFile, spawn } from "node:child_process";
import { once } from "node:events";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";
import { createInterface } from "node:readline";
import { promisify } from "node:util";

/** The root of the repository. */
export const ROOT = path.resolve(import.meta.dirname, "../../..");
export const EXAMPLES = path.join(ROOT, "examples/meshes");
const BINARY = process.env.GRASPD_BINARY ?? path.join(ROOT, "target/debug/graspd");

/** A folder that is deleted when the test has ended. */
export async function folder(test) {
  const made = await mkdtemp(path.join(tmpdir(), "graspd-page-"));
  test.after(() => rm(made, { recursive: true, force: true }));
  return made;
}

export class Server {
  #process = null;
  #environment;
  #folder;
  /** The URL, such as http://127.0.0.1:4711; it stays the same after a restart. */
  url = "";

  constructor(folder, environment) {
    this.#folder = folder;
    this.#environment = environment;
  }

  /** Resolves once it accepts connections; it is stopped when the test has ended. */
  static async start(test, environment = {}) {
    const server = new Server(await folder(test), environment);
    test.after(() => server.stop());
    await server.start();
    return server;
  }

  async start() {
    const listen = this.url === "" ? "127.0.0.1:0" : this.url.slice("http://".length);
    const flags = ["serve", "--listen", listen, "--data-dir", this.#folder];
    const env = { ...process.env, GRASPD_AUTH: "off", ...this.#environment };
    this.#process = spawn(BINARY, flags, { env, stdio: ["ignore", "pipe", "pipe"] });
    let said = "";
    this.#process.stderr.on("data", (text) => (said = (said + text).slice(-4000)));
    for await (const line of createInterface({ input: this.#process.stdout })) {
      const [, url] = /^graspd listening on (\S+)$/.exec(line) ?? [];
      if (url !== undefined) {
        this.url = url;
        return;
      }
    }
    throw new Error(`the server does not start: ${said}`);
  }

  async stop(signal = "SIGTERM") {
    const running = this.#process;
    this.#process = null;
    if (running !== null && running.exitCode === null && running.signalCode === null) {
      running.kill(signal);
      await once(running, "exit");
    }
  }

  /** A new API key of this server. */
  async key(name) {
    const flags = ["keys", "create", name, "--data-dir", this.#folder];
    const { stdout } = await promisify(execFile)(BINARY, flags);
    return stdout.trim().split(/\s+/).at(-1);
  }

  /** The JSON answer of the service to a request outside the page. */
  async json(where, init = {}) {
    const response = await fetch(this.url + where, init);
    if (!response.ok) {
      throw new Error(`${where}: ${response.status} ${await response.text()}`);
    }
    return response.json();
  }

  /** Submits a job outside the page and returns its record. */
  submit(mesh, settings) {
    const body = new FormData();
    for (const [name, value] of Object.entries(settings)) {
      body.append(name, String(value));
    }
    body.append("mesh", mesh.blob, mesh.name);
    return this.json("/jobs", { method: "POST", body });
  }

  /** Submits a job and returns its record once it has ended. */
  async plan(mesh, settings) {
    const { id } = await this.submit(mesh, settings);
    for (;;) {
      const job = await this.json(`/jobs/${id}?wait=10`);
      if (job.state !== "queued" && job.state !== "running") {
        return job;
      }
    }
  }
}
