/** The API documentation works without any other host and obeys its content security policy. */

import assert from "node:assert/strict";
import { after, test } from "node:test";

import { closeBrowser, until, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { Server } from "./support/server.js";

after(closeBrowser);

test("the explorer shows every operation and runs one", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await page.goto(`${server.url}/docs/`);
    const described = await server.json("/openapi.json");
    const operations = Object.values(described.paths)
      .flatMap((path) => Object.values(path))
      .map((operation) => operation.operationId)
      .filter((id) => id !== undefined);
    assert(operations.length > 20, "the description has operations");
    for (const id of operations) {
      await page.locator(`[id$="-${id}"]`).first().waitFor({ state: "attached" });
    }

    const health = page.locator('[id$="-healthz"]').first();
    await health.scrollIntoViewIfNeeded();
    await health
      .getByRole("button", { name: /healthz/ })
      .first()
      .click();
    await health.getByRole("button", { name: "Try it out" }).click();
    const answered = page.waitForResponse(`${server.url}/healthz`);
    await health.getByRole("button", { name: "Execute" }).click();
    assert.equal((await answered).status(), 200);
    const responses = health.locator(".live-responses-table");
    await responses.getByText("200", { exact: true }).first().waitFor();
    await responses.getByText('"ok"').first().waitFor();
  });
});

test("a requested picture is shown", async (t) => {
  const server = await Server.start(t);
  const box = await example("box.stl");
  const job = await server.plan(box, { contacts: 4, seed: 1, generations: 2, population: 4 });
  await withPage(server.url, {}, async (page) => {
    await page.goto(`${server.url}/docs/`);
    const preview = page.locator('[id$="-preview_mesh"]').first();
    await preview.locator("button.opblock-summary-control").click();
    await preview.getByRole("button", { name: "Try it out" }).click();
    await preview.locator('tr[data-param-name="id"] input').fill(job.mesh_id);
    await preview.getByRole("button", { name: "Execute" }).click();
    await until(
      page,
      () => document.querySelector(".response-col_description img")?.naturalWidth > 0,
    );
  });
});
