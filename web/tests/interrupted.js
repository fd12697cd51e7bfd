/** Broken connections and late or missing answers: nothing is done twice, and nothing needs a reload. */

import assert from "node:assert/strict";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, drawn, open, set } from "./support/steps.js";

after(closeBrowser);

const QUICK = { contacts: 4, seed: 1, generations: 2, population: 4 };
const BROKEN = [/ERR_/];

/** The banner that is shown while the server does not answer. */
const away = (page) => page.getByRole("alert").filter({ hasText: /server does not answer/i });

test("a surface whose response is lost is requested again", async (t) => {
  const server = await Server.start(t);
  const job = await server.plan(await example("box.stl"), QUICK);
  await withPage(server.url, { expected: BROKEN }, async (page) => {
    for (const place of [`/#/jobs/${job.id}`, `/#/meshes/${job.mesh_id}`]) {
      await page.route("**/file?*", (route) => route.abort(), { times: 2 });
      await open(page, server, place);
      await drawn(page);
      await page.goto("about:blank");
    }
  });
});

test("a mesh opens although the server starts late", async (t) => {
  const server = await Server.start(t);
  const { mesh_id: id } = await server.plan(await example("box.stl"), QUICK);
  await withPage(server.url, { expected: BROKEN }, async (page) => {
    await open(page, server);
    await page.context().setOffline(true);
    await page.evaluate((id) => {
      window.location.hash = `#/meshes/${id}`;
    }, id);
    await away(page).waitFor();
    await page.context().setOffline(false);
    await drawn(page);
    await away(page).waitFor({ state: "hidden" });
  });
});

test("a job whose response is lost is not planned twice", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, { expected: BROKEN }, async (page) => {
    await open(page, server);
    await choose(page, path.join(EXAMPLES, "box.stl"));
    await drawn(page);
    await set(page, { Fingers: 4, Seed: 1, Generations: 2, Population: 4 });
    const plan = page.getByRole("button", { name: /plan the grasp/i });
    await page.route(
      "**/jobs",
      async (route) => {
        await route.fetch();
        await route.abort();
      },
      { times: 1 },
    );
    await plan.click();
    await page
      .getByRole("alert")
      .filter({ hasText: /cannot be reached/i })
      .waitFor();
    await plan.click();
    await page.getByTestId("quality").waitFor();
    assert.equal((await server.json("/jobs")).jobs.length, 1);

    // Submitting once more after the answer creates another job.
    await page.goBack();
    await drawn(page);
    await plan.click();
    await page.getByTestId("quality").waitFor();
    assert.equal((await server.json("/jobs")).jobs.length, 2);
  });
});

test("the mesh that was chosen last is shown", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    let release = () => undefined;
    const held = new Promise((resolve) => {
      release = resolve;
    });
    await page.route("**/duck*.obj", async (route) => {
      await held;
      await route.continue().catch(() => undefined);
    });
    await page.getByRole("button", { name: "Duck" }).click();
    await page.getByText(/sending duck/i).waitFor();
    await choose(page, path.join(EXAMPLES, "box.stl"));
    await page.getByRole("heading", { name: "box.stl" }).waitFor();
    release();
    await drawn(page);
    const { meshes } = await server.json("/meshes");
    assert.equal(meshes.length, 1);
    await page.getByRole("heading", { name: "box.stl" }).waitFor();
  });
});

test("a refusal is not retried", async (t) => {
  const server = await Server.start(t);
  const { id } = await server.plan(await example("box.stl"), QUICK);
  const expected = [...BROKEN, /status of 404/];
  await withPage(server.url, { expected }, async (page) => {
    await page.route(`**/jobs/${id}`, (route) => route.abort());
    await open(page, server, `/#/jobs/${id}`);
    await away(page).waitFor();
    const removed = await fetch(`${server.url}/jobs/${id}`, { method: "DELETE" });
    assert.equal(removed.status, 204);
    await page.unroute(`**/jobs/${id}`);
    await page.getByRole("heading", { name: /did not work/i }).waitFor();
    await away(page).waitFor({ state: "hidden" });
  });
});
