/** Copied requests (shell, Python, JSON) and downloaded files all work in other programs. */

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { after, test } from "node:test";
import { promisify } from "node:util";
import validator from "gltf-validator";

import { closeBrowser, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { size } from "./support/pixels.js";
import { EXAMPLES, Server, folder } from "./support/server.js";
import { choose, drawn, open, set } from "./support/steps.js";

after(closeBrowser);

const run = promisify(execFile);

/** Presses a copy button and returns the content of the clipboard. */
async function copy(page, name) {
  await page.evaluate(() => navigator.clipboard.writeText("nothing"));
  await page.getByRole("button", { name }).click();
  await page.getByText(/copied/i).waitFor();
  return page.evaluate(() => navigator.clipboard.readText());
}

/** The request of the newest job as the service has understood it. */
const newest = async (server) => (await server.json("/jobs")).jobs[0];

const SETTINGS = {
  Fingers: 5,
  "Friction μ": 0.35,
  // A quote has a meaning in a shell.
  Label: "it's $HOME `id`",
  Seed: 7,
  Generations: 1,
  Population: 5,
};
const UNDERSTOOD = {
  contacts: 5,
  friction: 0.35,
  label: SETTINGS.Label,
  seed: 7,
  generations: 1,
  population: 5,
};

function isAsked(request) {
  const asked = Object.fromEntries(Object.keys(UNDERSTOOD).map((name) => [name, request[name]]));
  assert.deepEqual(asked, UNDERSTOOD);
}

test("copied requests run and submit the same settings", async (t) => {
  const server = await Server.start(t);
  const where = await folder(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await choose(page, path.join(EXAMPLES, "box.stl"));
    await drawn(page);
    await set(page, SETTINGS);

    const json = JSON.parse(await copy(page, /copy.*json/i));
    const init = { method: "POST", headers: { "Content-Type": "application/json" } };
    const job = await server.json("/jobs", { ...init, body: JSON.stringify(json) });
    isAsked(job.request);

    const curl = await copy(page, /copy.*curl/i);
    const { stdout } = await run("sh", ["-c", curl], { cwd: where });
    assert.match(stdout, /^HTTP\/1\.1 202 /);
    isAsked((await newest(server)).request);
    assert.notEqual((await newest(server)).id, job.id);

    const script = path.join(where, "plan.py");
    await writeFile(script, await copy(page, /copy.*python/i));
    const before = await newest(server);
    const said = await run("python3", [script], { cwd: where });
    const planned = await newest(server);
    assert.notEqual(planned.id, before.id);
    isAsked(planned.request);
    const { result } = await server.json(`/jobs/${planned.id}`);
    assert(said.stdout.includes(String(result.quality)), said.stdout);

    // The view of an ended job copies the same request.
    await open(page, server, `/#/jobs/${planned.id}`);
    await page.getByTestId("quality").waitFor();
    const again = await run("sh", ["-c", await copy(page, /copy.*curl/i)], { cwd: where });
    assert.match(again.stdout, /^HTTP\/1\.1 202 /);
    isAsked((await newest(server)).request);
  });
});

test("a seed beyond the exact integers of JavaScript is not rounded", async (t) => {
  const server = await Server.start(t);
  const seed = "18446744073709551615";
  const settings = { seed, contacts: 4, generations: 2, population: 4 };
  const job = await server.plan(await example("box.stl"), settings);
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    await page.getByText("About the search").click();
    await page.getByText(seed, { exact: true }).waitFor();
    assert.match(await copy(page, /copy.*json/i), new RegExp(`"seed": ${seed},`));
    const where = await folder(t);
    const again = await run("sh", ["-c", await copy(page, /copy.*curl/i)], { cwd: where });
    assert.match(again.stdout, new RegExp(`"seed":${seed}[,}]`));
  });
});

/** Presses a download button and returns the name and bytes of the file. */
async function save(page, name) {
  const coming = page.waitForEvent("download");
  await page.getByRole("button", { name, exact: true }).click();
  const download = await coming;
  const kept = await download.path();
  return { name: download.suggestedFilename(), kept, bytes: await readFile(kept) };
}

/** Prints the root element of an XML file. The page cannot parse the file, because its policy forbids the styles. */
const ROOT =
  "import sys, xml.etree.ElementTree as tree; print(tree.parse(sys.argv[1]).getroot().tag)";

/** Rows of a CSV file without quotes. */
const rows = (bytes) =>
  bytes
    .toString()
    .trimEnd()
    .split(/\r?\n/)
    .map((line) => line.split(","));

test("every file opens in an independent reader", async (t) => {
  const server = await Server.start(t);
  const settings = { contacts: 4, seed: 1, generations: 3, population: 4, units: "mm" };
  const { id, result } = await server.plan(await example("duck.obj"), settings);
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${id}`);
    await page.getByTestId("quality").waitFor();

    const glb = await save(page, "GLB");
    assert.match(glb.name, /\.glb$/);
    const { issues, info } = await validator.validateBytes(new Uint8Array(glb.bytes));
    assert.equal(issues.numErrors, 0, JSON.stringify(issues.messages));
    assert(info.totalTriangleCount >= 8228, "the body is in it");

    const png = await save(page, "PNG");
    assert.match(png.name, /\.png$/);
    assert((await size(png.bytes)).width >= 1024);

    for (const title of ["SVG", "Convergence SVG"]) {
      const svg = await save(page, title);
      assert.match(svg.name, /\.svg$/);
      const { stdout } = await run("python3", ["-c", ROOT, svg.kept]);
      assert.equal(stdout.trim(), "{http://www.w3.org/2000/svg}svg", title);
    }

    const [head, ...contacts] = rows((await save(page, "CSV")).bytes);
    assert.equal(contacts.length, 4);
    const numbers = contacts.map((row) => row.map(Number));
    for (const [at, { position }] of result.contacts.entries()) {
      for (const part of position) {
        assert(numbers[at].includes(part), `${part} in ${contacts[at]} of ${head}`);
      }
    }
    const [, ...generations] = rows((await save(page, "Convergence CSV")).bytes);
    assert.equal(generations.length, result.history.length);
  });
});

test("a grasp of two fingers is exported as the pose of a gripper, in the chosen unit", async (t) => {
  const server = await Server.start(t);
  const job = await server.plan(await example("box.stl"), {
    contacts: 2,
    contact_model: "soft",
    friction: 0.8,
    seed: 1,
    generations: 1,
    population: 2,
  });
  assert(job.result.force_closure, "two soft fingers hold a box");
  await withPage(server.url, { expected: [/status of 409/] }, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    await page.getByTestId("quality").waitFor();
    await page.getByRole("button", { name: "MoveIt", exact: true }).click();
    const refused = await fetch(`${server.url}/jobs/${job.id}/grasp.moveit.json`);
    const { detail } = await refused.json();
    await page.getByRole("alert").getByText(detail, { exact: true }).waitFor();

    await page.getByLabel(/unit of the mesh/i).selectOption("cm");
    const moveit = await save(page, "MoveIt");
    assert.match(moveit.name, /\.moveit\.json$/);
    const { position } = JSON.parse(moveit.bytes).grasp_pose.pose;
    const [one, two] = job.result.contacts.map((contact) => contact.position);
    for (const [axis, name] of ["x", "y", "z"].entries()) {
      const middle = (0.01 * (one[axis] + two[axis])) / 2;
      assert(Math.abs(position[name] - middle) < 1e-9, `${name}: ${position[name]}, not ${middle}`);
    }
    const isaac = await save(page, "Isaac Sim");
    assert.match(isaac.name, /\.isaac\.yaml$/);
    assert.match(isaac.bytes.toString(), /^format: isaac_grasp$/m);
  });
});
