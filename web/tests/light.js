/** The network traffic of the first view is limited. */

import assert from "node:assert/strict";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";
import { Server } from "./support/server.js";
import { drawn, open } from "./support/steps.js";

after(closeBrowser);

const LIMIT = 1_500_000;

test("the first view, and a view with a body, load little", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    const session = await page.context().newCDPSession(page);
    await session.send("Network.enable");
    let bytes = 0;
    let scripts = 0;
    session.on("Network.loadingFinished", ({ encodedDataLength }) => (bytes += encodedDataLength));
    session.on("Network.responseReceived", ({ type, response }) => {
      const coding = new Headers(response.headers).get("content-encoding");
      scripts += type === "Script" && coding === "gzip" ? 1 : 0;
    });
    await open(page, server);
    await page.waitForLoadState("networkidle");
    console.log(`first view: ${bytes} bytes`);
    assert(scripts > 0, "the scripts come compressed");
    assert(bytes > 50_000, "all of it was counted");
    assert(bytes < LIMIT, `${bytes} bytes`);

    await page.getByRole("button", { name: /box/i }).click();
    await drawn(page);
    await page.waitForLoadState("networkidle");
    console.log(`with the box: ${bytes} bytes`);
    assert(bytes < LIMIT, `${bytes} bytes`);
  });
});
