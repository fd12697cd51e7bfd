/** Browsers without WebGL, clipboard or storage. */

import assert from "node:assert/strict";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, until, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, open } from "./support/steps.js";

after(closeBrowser);

const QUICK = { contacts: 4, seed: 1, generations: 2, population: 4 };

test("without WebGL the page shows pictures drawn by the service", async (t) => {
  const server = await Server.start(t);
  const job = await server.plan(await example("box.stl"), QUICK);
  await withPage(server.url, {}, async (page) => {
    await page.addInitScript(() => {
      const { getContext } = HTMLCanvasElement.prototype;
      HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
        return kind === "2d" ? getContext.call(this, kind, ...more) : null;
      };
    });
    const shown = () =>
      until(page, () => {
        const picture = document.querySelector(".stage img");
        return picture !== null && !picture.hidden && picture.naturalWidth;
      });
    await open(page, server, `/#/meshes/${job.mesh_id}`);
    await page.getByText(/no WebGL/).waitFor();
    assert.equal(await (await shown()).jsonValue(), 1024);
    assert.equal(await page.getByLabel("View", { exact: true }).count(), 0);
    const drawn = page.waitForResponse(/grasp\.png\?grasp=best/);
    await open(page, server, `/#/jobs/${job.id}`);
    await page.getByTestId("quality").waitFor();
    assert.equal((await drawn).status(), 200);
    await shown();

    // Another theme needs another picture, and another job must not show this one.
    const dark = page.waitForResponse(/grasp\.png\?.*theme=dark/);
    await page.getByRole("button", { name: /dark theme/i }).click();
    assert.equal((await dark).status(), 200);
    const preview = page.waitForResponse(/preview\.png\?width=1024&theme=dark/);
    await page.getByRole("link", { name: /plan again/i }).click();
    assert.equal((await preview).status(), 200);
  });
});

test("without a clipboard the text can be selected", async (t) => {
  const server = await Server.start(t);
  const { mesh_id: mesh } = await server.plan(await example("box.stl"), QUICK);
  await withPage(server.url, {}, async (page) => {
    // As on a page loaded over plain HTTP from another host.
    await page.addInitScript(() => {
      Object.defineProperty(navigator, "clipboard", { value: undefined });
    });
    await open(page, server, `/#/meshes/${mesh}`);
    await page.getByRole("button", { name: "Copy as JSON" }).click();
    const text = page.getByLabel("Request", { exact: true });
    await text.waitFor();
    assert.equal(JSON.parse(await text.inputValue()).mesh_id, mesh);
    const selected = await text.evaluate(
      ({ selectionStart: from, selectionEnd: to, value }) => from === 0 && to === value.length,
    );
    assert(selected, "the whole text is selected");
  });
});

test("without storage everything works until the page is left", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await page.addInitScript(() => {
      for (const name of ["localStorage", "sessionStorage"]) {
        Object.defineProperty(window, name, {
          get: () => {
            throw new DOMException("denied", "SecurityError");
          },
        });
      }
    });
    await open(page, server);
    const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
    assert.equal(await theme(), "light");
    await page.getByRole("button", { name: /dark theme/i }).click();
    assert.equal(await theme(), "dark");
    await choose(page, path.join(EXAMPLES, "box.stl"));
    await page.getByRole("heading", { name: "box.stl" }).waitFor();
    assert.equal(await theme(), "dark");
  });
});
