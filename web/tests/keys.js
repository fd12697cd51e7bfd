/** A server that requires a key: the page asks for it and sends it with every request, also for pictures. */

import assert from "node:assert/strict";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, drawn, open, set } from "./support/steps.js";

after(closeBrowser);

test("the page asks for the key and then works as without keys", async (t) => {
  const server = await Server.start(t, { GRASPD_AUTH: "keys" });
  const key = await server.key("reader");
  await withPage(server.url, { expected: [/status of 401/] }, async (page, watch) => {
    await open(page, server);
    const field = page.getByLabel("API key");
    const refused = page.getByRole("alert").filter({ hasText: /not good/i });
    // No header can carry the first.
    for (const wrong of ["gk_ключ", "graspd_wrong"]) {
      await field.fill(wrong);
      await page.getByRole("button", { name: /key/i }).click();
      await refused.waitFor();
    }
    // As copied from a page that breaks lines.
    await field.fill(`\u200b${key} `);
    await page.getByRole("button", { name: /key/i }).click();

    await choose(page, path.join(EXAMPLES, "box.stl"));
    await drawn(page);
    await set(page, { Fingers: 4, Seed: 1, Generations: 2, Population: 4 });
    const complaints = watch.complaints.length;
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    await page.getByTestId("quality").waitFor();
    const coming = page.waitForEvent("download");
    await page.getByRole("button", { name: "GLB", exact: true }).click();
    await coming;

    // The key is in no URL, because histories and logs keep URLs.
    assert(!watch.requests.some((url) => url.includes(key)), "the key in an address");
    await page.getByRole("button", { name: /copy.*curl/i }).click();
    const curl = await page.evaluate(() => navigator.clipboard.readText());
    assert(!curl.includes(key), "the key in what is passed on");
    assert.match(curl, /Authorization: Bearer \$/);

    // The key is kept as long as the tab.
    await page.reload();
    await page.getByTestId("quality").waitFor();
    await page.getByRole("link", { name: "New" }).click();
    const picture = page
      .getByRole("link", { name: /contacts/ })
      .locator("img")
      .first();
    await picture.and(page.locator("[src^='blob:']")).waitFor();
    assert.equal(watch.complaints.length, complaints, "refused although the key is good");
  });
});
