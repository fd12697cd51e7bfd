/** Uploads: by the file field, by dropping a file, as an example; and files that cannot be used. */

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { difference } from "./support/pixels.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, drawn, drop, open, picture } from "./support/steps.js";

after(closeBrowser);

const BOX = path.join(EXAMPLES, "box.stl");
const REFUSED = /status of 4\d\d/;

/** The name of the only mesh that the server has. */
async function onlyMesh(server) {
  const { meshes } = await server.json("/meshes");
  assert.equal(meshes.length, 1);
  return server.json(`/meshes/${meshes[0].id}`);
}

test("a chosen file is shown", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    const empty = await picture(page);
    await choose(page, BOX);
    const triangles = await drawn(page);
    const loaded = await picture(page);
    assert((await difference(empty, loaded)) > 0.05, "the view is not as empty as before");
    assert.equal(triangles, (await onlyMesh(server)).report.triangles);
  });
});

test("a file is dropped on the page", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await drop(page, { name: "box.stl", bytes: await readFile(BOX) });
    assert.equal(await drawn(page), (await onlyMesh(server)).report.triangles);
  });
});

for (const name of [/duck/i, /rabbit/i, /knight/i, /box/i]) {
  test(`the example ${name} is one press away`, async (t) => {
    const server = await Server.start(t);
    await withPage(server.url, {}, async (page) => {
      await open(page, server);
      await page.getByRole("button", { name }).click();
      assert.equal(await drawn(page), (await onlyMesh(server)).report.triangles);
    });
  });
}

for (const [what, name, content] of [
  ["that is no mesh", "notes.txt", "Dear diary, today I held a duck.\n"],
  ["without triangles", "empty.stl", "solid nothing\nendsolid nothing\n"],
  [
    "that ends too early",
    "half.stl",
    Buffer.concat([Buffer.alloc(80), Buffer.from([9, 0, 0, 0, 1])]),
  ],
]) {
  test(`a file ${what} is refused in the words of the service`, async (t) => {
    const server = await Server.start(t);
    const form = new FormData();
    form.append("mesh", new Blob([content]), name);
    const answer = await fetch(`${server.url}/meshes`, { method: "POST", body: form });
    assert(answer.status >= 400);
    const problem = await answer.json();

    await withPage(server.url, { expected: [REFUSED] }, async (page) => {
      await open(page, server);
      await choose(page, {
        name,
        mimeType: "application/octet-stream",
        buffer: Buffer.from(content),
      });
      const alert = page.getByRole("alert");
      await alert.getByText(problem.title, { exact: true }).waitFor();
      await alert.getByText(problem.detail, { exact: true }).waitFor();
      // The form can be used again at once.
      await choose(page, BOX);
      await drawn(page);
    });
  });
}
