/**
 * Takes pictures of the page into the folder that is given: each state, light and dark, wide and narrow.
 *
 *     node web/tests/support/screenshots.js FOLDER
 */

import { mkdir } from "node:fs/promises";
import path from "node:path";

import { closeBrowser, withPage } from "./browser.js";
import { example } from "./meshes.js";
import { EXAMPLES, Server } from "./server.js";
import { choose, drawn, open, picture, unfold } from "./steps.js";

const SIZES = { wide: { width: 1280, height: 800 }, narrow: { width: 360, height: 740 } };

const [, , folder = "screenshots"] = process.argv;
await mkdir(folder, { recursive: true });
const ends = [];
const script = { after: (end) => ends.unshift(end) };
try {
  const server = await Server.start(script);
  const duck = await example("duck.obj");
  const settings = { contacts: 4, seed: 1, top: 3, units: "mm", label: "Duck, four fingers" };
  const done = await server.plan(duck, settings);
  const box = await example("box.stl");
  const none = {
    contacts: 3,
    contact_model: "frictionless",
    generations: 1,
    label: "Box, too few",
  };
  const failed = await server.plan(box, none);
  const long = { contacts: 5, friction: 0.3, generations: 100_000, seed: 2, label: "Long search" };
  const running = await server.submit(duck, long);
  for (const colorScheme of ["light", "dark"]) {
    for (const [size, viewport] of Object.entries(SIZES)) {
      const options = { colorScheme, viewport, expected: [/status of 4\d\d/] };
      await withPage(server.url, options, async (page) => {
        const take = async (state, fullPage = false) => {
          await page.waitForLoadState("networkidle").catch(() => null);
          const file = path.join(folder, `${state}-${colorScheme}-${size}.png`);
          await page.screenshot({ path: file, fullPage });
        };
        await open(page, server);
        await page.getByRole("link", { name: /too few/ }).waitFor();
        await page.waitForLoadState("networkidle");
        await take("empty");
        await choose(page, { name: "a.txt", mimeType: "text/plain", buffer: Buffer.from("none") });
        await page.getByRole("alert").filter({ hasText: /mesh/i }).waitFor();
        await take("error");
        await choose(page, path.join(EXAMPLES, "knight.stl"));
        await drawn(page);
        await picture(page);
        await take("mesh");
        await unfold(page);
        await page.getByRole("button", { name: "Add region" }).click();
        await take("settings", true);
        await open(page, server, `/#/jobs/${running.id}`);
        await page.getByText(/generation [1-9]/).waitFor();
        await drawn(page);
        // The search keeps running, so the network is never idle.
        const file = path.join(folder, `running-${colorScheme}-${size}.png`);
        await page.screenshot({ path: file });
        await open(page, server, `/#/jobs/${done.id}`);
        await page.getByTestId("quality").waitFor();
        await drawn(page);
        await picture(page);
        await take("result");
        await unfold(page);
        await take("result-all", true);
        await open(page, server, `/#/jobs/${failed.id}`);
        await page.getByText(/no grasp that holds/i).waitFor();
        await drawn(page);
        await picture(page);
        await take("none");
      });
    }
  }
} finally {
  await closeBrowser();
  for (const end of ends) {
    await end();
  }
}
