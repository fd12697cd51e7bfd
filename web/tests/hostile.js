/** Names and labels that would do harm as markup, or that reverse the direction of writing. */

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, drawn, open } from "./support/steps.js";
import { example } from "./support/meshes.js";

after(closeBrowser);

const MARKUP = `<img src=x onerror="document.title='caught'"><script>document.title='caught'</script>`;
const TURNED = "harmless\u202Elts.exe";

const nothingRan = async (page) => {
  assert.notEqual(await page.title(), "caught");
  assert.equal(await page.locator('img[src="x"]').count(), 0, "text became an element");
};

test("a file name with markup is shown as text", async (t) => {
  const server = await Server.start(t);
  const buffer = await readFile(path.join(EXAMPLES, "box.stl"));
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    const name = `${MARKUP.replaceAll("/", "")}.stl`;
    await choose(page, { name, mimeType: "model/stl", buffer });
    await drawn(page);
    await page.getByText("<img src=x", { exact: false }).first().waitFor();
    await nothingRan(page);
  });
});

test("a label with markup is shown as text in the list, and its job can be opened", async (t) => {
  const server = await Server.start(t);
  const mesh = await example("box.stl");
  await server.plan(mesh, { label: MARKUP, generations: 1, population: 10, method: "random" });
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await page.getByRole("link", { name: MARKUP }).click();
    await page.getByText(MARKUP).first().waitFor();
    await drawn(page);
    await nothingRan(page);
  });
});

test("a name that reverses the direction of writing is refused and never shown", async (t) => {
  const server = await Server.start(t);
  const buffer = await readFile(path.join(EXAMPLES, "box.stl"));
  await withPage(server.url, { expected: [/status of 422/] }, async (page) => {
    await open(page, server);
    await choose(page, { name: TURNED, mimeType: "model/stl", buffer });
    await page.getByRole("alert").getByText(/name/i).first().waitFor();
    await nothingRan(page);
  });
});
