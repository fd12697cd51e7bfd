/** Returning to a URL, to a server that was down, and to a job or mesh that was deleted. */

import assert from "node:assert/strict";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { Server } from "./support/server.js";
import { drawn, fact, open } from "./support/steps.js";

after(closeBrowser);

const QUICK = { contacts: 4, seed: 1, generations: 2, population: 4 };

test("a URL shows its job again after a restart of the server", async (t) => {
  const server = await Server.start(t);
  const job = await server.plan(await example("box.stl"), { ...QUICK, label: "left hand" });
  await server.stop();
  await server.start();
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    const quality = page.getByTestId("quality");
    await quality.waitFor();
    await page.getByRole("heading", { name: "left hand" }).waitFor();
    const triangles = await drawn(page);

    await page.reload();
    await quality.waitFor();
    assert.equal(await drawn(page), triangles);

    // From the list too, and back.
    await page.getByRole("link", { name: "New" }).click();
    await page.getByRole("link", { name: /left hand/ }).click();
    await quality.waitFor();
    await page.goBack();
    await page.getByRole("link", { name: /left hand/ }).waitFor();
  });
});

test("a job is followed again when its server is back", async (t) => {
  const server = await Server.start(t, { GRASPD_THREADS_PER_JOB: "1" });
  const mesh = await example("duck.obj");
  const { id } = await server.submit(mesh, { ...QUICK, generations: 40, population: 8 });
  const expected = [/ERR_|network error|status of 50\d/i];
  await withPage(server.url, { expected }, async (page) => {
    await open(page, server, `/#/jobs/${id}`);
    await fact(page, /evaluated/i)
      .filter({ hasText: /^[1-9]/ })
      .waitFor();
    const away = page.getByRole("alert").filter({ hasText: /server does not answer/i });
    assert.equal(await away.isVisible(), false);
    await server.stop("SIGKILL");
    await away.waitFor();
    await server.start();
    await away.waitFor({ state: "hidden" });
    await page.getByTestId("quality").waitFor();
    const { state } = await server.json(`/jobs/${id}`);
    assert.equal(state, "succeeded");
  });
});

test("deleted and unknown jobs and meshes are reported as such", async (t) => {
  const server = await Server.start(t);
  const job = await server.plan(await example("box.stl"), QUICK);
  const expected = [/status of 4(04|10)/];
  await withPage(server.url, { expected }, async (page) => {
    await server.json(`/meshes/${job.mesh_id}`);
    const removed = await fetch(`${server.url}/meshes/${job.mesh_id}`, { method: "DELETE" });
    assert.equal(removed.status, 204);
    await open(page, server, `/#/jobs/${job.id}`);
    await page.getByText(/mesh of this job has been deleted/i).waitFor();
    await page.getByTestId("quality").waitFor();

    await page.getByRole("button", { name: /delete this job/i }).click();
    await page.getByRole("button", { name: /press again/i }).click();
    await page.getByText(/none yet/i).waitFor();

    for (const place of [`/#/jobs/${job.id}`, "/#/jobs/nothing", `/#/meshes/${job.mesh_id}`]) {
      const where = place.slice("/#".length);
      const { detail } = await (await fetch(server.url + where)).json();
      await open(page, server, place);
      await page.getByRole("alert").getByText(detail, { exact: true }).waitFor();
    }
    await open(page, server, "/#/elsewhere");
    await page.getByRole("link", { name: /start/i }).click();
    await page.getByText(/none yet/i).waitFor();
  });
});

test("the list of jobs is updated", async (t) => {
  const server = await Server.start(t, { GRASPD_WORKERS: "1" });
  const long = { ...QUICK, method: "modified_ga", generations: 90_000, label: "the long one" };
  const { id } = await server.submit(await example("box.stl"), long);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    const entry = page.getByRole("link", { name: /the long one/ });
    await entry.getByText(/^Searching/).waitFor();
    await entry.focus();
    await server.submit(await example("box.stl"), { ...QUICK, label: "one more" });
    await server.json(`/jobs/${id}/cancel`, { method: "POST" });
    await entry.getByText(/^Cancelled/).waitFor();
    await page
      .getByRole("link", { name: /one more/ })
      .getByText(/^Done/)
      .waitFor();
    assert(await entry.evaluate((element) => element === document.activeElement));
  });
});
