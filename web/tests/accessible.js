/** Checks every state of the page with axe: light and dark, wide and narrow. */

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, drawn, open, set, unfold } from "./support/steps.js";

after(closeBrowser);

const AXE = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Serious and critical violations in the current state of the page. */
async function violations(page) {
  const session = await page.context().newCDPSession(page);
  const run = async (expression) => {
    // Scripts of the debugger are exempt from the policy of the page.
    const answer = await session.send("Runtime.evaluate", {
      expression,
      awaitPromise: true,
      returnByValue: true,
    });
    assert.equal(answer.exceptionDetails, undefined, JSON.stringify(answer.exceptionDetails));
    return answer.result.value;
  };
  await run(`${AXE}; null`);
  const found = await run(`axe.run().then(({ violations, passes }) => ({
    checked: passes.length,
    serious: violations
      .filter(({ impact }) => impact === "serious" || impact === "critical")
      .map(({ id, nodes }) => [id, ...nodes.map(({ html, failureSummary }) => html + failureSummary)]),
  }))`);
  await session.detach();
  assert(found.checked > 10, "axe has looked at the page");
  return found.serious;
}

test("axe finds a picture without a text and grey text on grey", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await page.evaluate(() => {
      const image = document.createElement("img");
      const words = document.createElement("p");
      words.textContent = "hardly to be read";
      words.style.background = "#777777";
      words.style.color = "#999999";
      document.querySelector("main").append(image, words);
    });
    const found = (await violations(page)).map(([id]) => id);
    assert.deepEqual(found.sort(), ["color-contrast", "image-alt"]);
  });
});

test("the explorer of the API", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await page.goto(`${server.url}/docs/`);
    for (const id of ["submit_job", "healthz"]) {
      const operation = page.locator(`[id$="-${id}"]`).first();
      await operation.locator("button.opblock-summary-control").click();
      await operation.getByRole("button", { name: "Try it out" }).click();
    }
    await page.getByRole("button", { name: "Execute" }).last().click();
    await page.locator(".live-responses-table").waitFor();
    assert.deepEqual(await violations(page), []);
  });
});

const WIDE = { width: 1280, height: 800 };
const NARROW = { width: 360, height: 740 };

for (const [colorScheme, viewport] of [
  ["light", WIDE],
  ["dark", WIDE],
  ["light", NARROW],
  ["dark", NARROW],
]) {
  test(`every state, ${colorScheme}, ${viewport.width} pixels wide`, async (t) => {
    const server = await Server.start(t, { GRASPD_THREADS_PER_JOB: "1" });
    const done = await server.plan(await example("duck.obj"), {
      contacts: 4,
      seed: 1,
      generations: 2,
      population: 4,
      top: 2,
    });
    const none = await server.plan(await example("box.stl"), {
      contacts: 3,
      contact_model: "frictionless",
      generations: 1,
      population: 4,
    });
    const running = await server.submit(await example("duck.obj"), { generations: 100_000 });
    const options = { colorScheme, viewport, expected: [/status of 4\d\d/] };
    await withPage(server.url, options, async (page) => {
      const holds = async (state) => {
        assert.deepEqual(await violations(page), [], state);
        const width = await page.evaluate(() => document.documentElement.scrollWidth);
        assert(width <= viewport.width, `${state} is ${width} pixels wide`);
      };
      await open(page, server);
      await page
        .getByRole("link", { name: /contacts/ })
        .first()
        .waitFor();
      await holds("empty");

      await choose(page, { name: "a.txt", mimeType: "text/plain", buffer: Buffer.from("none") });
      await page.getByRole("alert").filter({ hasText: /mesh/i }).waitFor();
      await holds("bad file");

      await choose(page, path.join(EXAMPLES, "box.stl"));
      await drawn(page);
      await unfold(page);
      for (const kind of ["box", "half_space", "sphere"]) {
        await page.getByLabel("Kind of region").selectOption(kind);
        await page.getByRole("button", { name: "Add region" }).click();
      }
      await holds("mesh");

      await set(page, { Fingers: 1000 });
      await page.getByRole("button", { name: /plan the grasp/i }).click();
      await page
        .getByRole("alert")
        .filter({ hasText: /settings/i })
        .waitFor();
      await holds("bad settings");

      await open(page, server, `/#/jobs/${running.id}`);
      await page.getByRole("button", { name: /cancel/i }).waitFor();
      await holds("running");

      await open(page, server, `/#/jobs/${done.id}`);
      await page.getByTestId("quality").waitFor();
      await drawn(page);
      await page.getByLabel(/where each finger may be/i).check();
      await page.getByText(/finger 1: [\d,]+ triangles/).waitFor();
      await unfold(page);
      await holds("result");

      await open(page, server, `/#/jobs/${none.id}`);
      await page.getByText(/no grasp that holds/i).waitFor();
      await holds("no grasp");

      await open(page, server, "/#/jobs/nothing");
      await page.getByRole("heading", { name: /did not work/i }).waitFor();
      await holds("no such job");
    });
  });
}
