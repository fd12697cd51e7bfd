/** A body of a million triangles is shown coarsened, and the page stays usable. */

import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, eventually, withPage } from "./support/browser.js";
import { bumpySphere } from "./support/meshes.js";
import { difference } from "./support/pixels.js";
import { Server, folder } from "./support/server.js";
import { choose, drawn, open, picture, stage } from "./support/steps.js";

after(closeBrowser);

test("a body of a million triangles", async (t) => {
  const file = path.join(await folder(t), "million.stl");
  await writeFile(file, bumpySphere(1000, 501));
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    const empty = await picture(page);
    let uploaded = 0;
    page.on("response", (response) => {
      if (response.request().method() === "POST") {
        uploaded = performance.now();
      }
    });
    await choose(page, file);
    const triangles = await drawn(page);
    const first = await stage(page).screenshot();
    console.log(`first picture ${Math.round(performance.now() - uploaded)} ms after the upload`);
    assert(triangles <= 200_000, `${triangles} triangles are drawn`);
    assert(triangles >= 20_000, `only ${triangles} triangles are drawn`);
    assert((await difference(empty, first)) > 0.05, "the body is seen");
    await page.getByText(/of its 1,000,000 triangles/).waitFor();

    // While the body is turned, typed text arrives and the view follows.
    const before = await picture(page);
    const turning = (async () => {
      for (let turn = 0; turn < 10; turn += 1) {
        await stage(page).press("ArrowLeft");
      }
    })();
    await page.getByLabel("Fingers", { exact: true }).fill("5");
    await turning;
    await eventually(
      async () => (await difference(before, await stage(page).screenshot())) > 0.02,
      "the body turned",
    );
    assert.equal(await page.getByLabel("Fingers", { exact: true }).inputValue(), "5");
  });
});
