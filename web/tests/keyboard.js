/** From the empty page to a result and a turned body with the keyboard alone. */

import assert from "node:assert/strict";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, until, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { difference } from "./support/pixels.js";
import { EXAMPLES, Server } from "./support/server.js";
import { drawn, open, picture, set } from "./support/steps.js";

after(closeBrowser);

/** The most Tab stops that a user may have to pass. */
const FAR = 80;

/** Presses Tab, or Shift+Tab, until `target` has the focus, which must then be visible. */
async function reach(page, target, key = "Tab") {
  await target.first().waitFor();
  for (let stop = 0; stop < FAR; stop += 1) {
    await page.keyboard.press(key);
    if (await target.evaluate((element) => element === document.activeElement)) {
      const shown = await target.evaluate((element) => {
        // A field that is hidden within its label shows its focus there.
        const around =
          element.closest("label") ?? document.querySelector(`label[for="${element.id}"]`);
        return [element, around].some((one) => {
          if (one === null) {
            return false;
          }
          const { outlineStyle, outlineWidth, boxShadow } = getComputedStyle(one);
          return (outlineStyle !== "none" && outlineWidth !== "0px") || boxShadow !== "none";
        });
      });
      assert(shown, `the focus is not to be seen on ${target}`);
      return;
    }
  }
  assert.fail(`${target} cannot be reached by ${key}`);
}

const focused = (page) => page.evaluate(() => document.activeElement?.textContent ?? "");

test("everything can be done with the keyboard", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    const chooser = page.waitForEvent("filechooser");
    await reach(page, page.getByLabel(/choose a mesh file/i));
    await page.keyboard.press("Enter");
    await (await chooser).setFiles(path.join(EXAMPLES, "box.stl"));
    await drawn(page);
    // The focus moves to the new view.
    assert.match(await focused(page), /box\.stl/);

    await reach(page, page.getByLabel("Fingers", { exact: true }));
    await page.keyboard.type("4");
    await reach(page, page.locator("summary").filter({ hasText: "More settings" }));
    await page.keyboard.press("Enter");
    for (const [label, value] of [
      ["Seed", "1"],
      ["Generations", "2"],
      ["Population", "4"],
    ]) {
      await reach(page, page.getByLabel(label, { exact: true }));
      await page.keyboard.type(value);
    }
    await page.keyboard.press("Enter");
    await page.getByTestId("quality").waitFor();
    assert.match(await focused(page), /job/i);

    const before = await picture(page);
    await reach(page, page.getByRole("application", { name: /three dimensions/i }), "Shift+Tab");
    for (const key of ["ArrowLeft", "ArrowLeft", "ArrowUp"]) {
      await page.keyboard.press(key);
    }
    assert((await difference(before, await picture(page))) > 0.01, "the body turned");
    await page.keyboard.press("Home");
    assert((await difference(before, await picture(page))) < 0.002, "and back");

    await reach(page, page.getByLabel("Arrows"));
    await page.keyboard.press("Space");
    assert((await difference(before, await picture(page))) > 0.001, "arrows are off");

    await reach(page, page.getByRole("link", { name: "New" }), "Shift+Tab");
    await page.keyboard.press("Enter");
    await page.getByRole("heading", { name: /where do the fingers go/i }).waitFor();
  });
});

test("the skip link leads to the controls", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await page.keyboard.press("Tab");
    assert.match(await focused(page), /skip/i);
    await page.keyboard.press("Enter");
    assert.match(await focused(page), /where do the fingers go/i);
  });
});

test("the focus is not lost when a search starts and ends", async (t) => {
  const server = await Server.start(t);
  const quick = { seed: 1, generations: 2, population: 4 };
  const { mesh_id: id } = await server.plan(await example("box.stl"), quick);
  await withPage(server.url, {}, async (page) => {
    const at = (target) => target.evaluate((element) => element === document.activeElement);
    const plan = async () => {
      await open(page, server, `/#/meshes/${id}`);
      await set(page, { Search: "modified_ga", Generations: 90_000 });
      await page.getByRole("button", { name: /plan the grasp/i }).press("Enter");
      await page.getByRole("region", { name: "Search" }).waitFor();
      assert(await at(page.getByRole("heading", { level: 2 }).first()), "the heading");
    };
    const cancelled = page.getByText("Cancelled", { exact: true });

    await plan();
    const view = page.getByLabel("View", { exact: true });
    await view.focus();
    const [job] = (await server.json("/jobs")).jobs;
    await server.json(`/jobs/${job.id}/cancel`, { method: "POST" });
    await cancelled.waitFor();
    assert(await at(view), "what the reader is at");

    await plan();
    await page.reload();
    await page.getByRole("button", { name: /cancel/i }).press("Enter");
    await cancelled.waitFor();
    await until(page, () => document.activeElement?.tagName === "H2");
  });
});
