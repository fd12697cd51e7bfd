/** One Chromium per test file, and pages whose errors and requests are recorded. */

import assert from "node:assert/strict";
import { chromium } from "playwright-core";

const FLAGS = [
  "--no-sandbox",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--disable-dev-shm-usage",
  // Without a graphics card.
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  // No other host can be reached; its name does not even resolve.
  "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
];
/** How long to wait for a condition on a busy machine, in milliseconds. */
export const PATIENCE = 120_000;

let browser = null;

/** The Chromium of this process; to be closed by `closeBrowser` in an `after` of the file. */
export async function launch() {
  const executablePath = process.env.CHROMIUM ?? "/usr/bin/chromium";
  browser ??= await chromium.launch({ executablePath, args: FLAGS, timeout: PATIENCE });
  return browser;
}

export async function closeBrowser() {
  await browser?.close();
  browser = null;
}

/**
 * Does `use(page, watch)` on a new page in a context of its own, then holds against it whatever went wrong
 * meanwhile: complaints in the console, violations of the policy, exceptions, requests to another host.
 *
 * `origin` is that of the server. `options.expected` is a list of patterns of complaints that belong to the
 * test, such as those of refused requests; each has to come. The rest of the options are those of a context.
 */
export async function withPage(origin, options, use) {
  const { expected = [], ...contextOptions } = options;
  const context = await (
    await launch()
  ).newContext({
    viewport: { width: 1280, height: 800 },
    acceptDownloads: true,
    ...contextOptions,
  });
  context.setDefaultTimeout(PATIENCE);
  await context.grantPermissions(["clipboard-read", "clipboard-write"], { origin });
  const watch = { complaints: [], requests: [] };
  context.on("request", (request) => watch.requests.push(request.url()));
  context.on("console", (message) => {
    if (["error", "warning"].includes(message.type()) && !isOfDriver(message.text())) {
      watch.complaints.push(message.text());
    }
  });
  context.on("weberror", (error) => watch.complaints.push(String(error.error())));
  context.on("dialog", (dialog) => {
    watch.complaints.push(`a dialog: ${dialog.message()}`);
    void dialog.dismiss();
  });
  const page = await context.newPage();
  try {
    await use(page, watch);
  } catch (error) {
    await printState(page, watch);
    throw error;
  } finally {
    await context.close();
  }
  for (const pattern of expected) {
    assert(
      watch.complaints.some((complaint) => pattern.test(complaint)),
      `no complaint matches ${pattern}`,
    );
  }
  const wrong = {
    complaints: watch.complaints.filter((text) => !expected.some((one) => one.test(text))),
    elsewhere: watch.requests.filter((url) => !isOf(origin, url)),
  };
  assert.deepEqual(wrong, { complaints: [], elsewhere: [] }, JSON.stringify(wrong, null, 2));
}

/** Prints what helps to understand a failed test. */
async function printState(page, watch) {
  const text = await page.locator("body").innerText({ timeout: 5000 }).catch(String);
  console.error(`${page.url()}\n${text.slice(0, 3000)}\n${watch.complaints.join("\n")}`);
  if (process.env.GRASPD_PICTURES !== undefined) {
    const path = `${process.env.GRASPD_PICTURES}/failed-${Date.now()}.png`;
    await page.screenshot({ path, timeout: 20_000 }).catch(console.error);
  }
}

/** The software renderer warns that reading pixels back is slow. */
const isOfDriver = (text) => /GL Driver Message .*GPU stall due to ReadPixels/.test(text);

function isOf(origin, url) {
  const { protocol, origin: asked } = new URL(url);
  return asked === origin || protocol === "data:" || (protocol === "blob:" && asked === origin);
}

/** Resolves once `condition(...)` holds in the page. */
export const until = (page, condition, argument) =>
  page.waitForFunction(condition, argument, { timeout: PATIENCE });

/** Resolves with the result of `look` once that is not null, undefined or false. */
export async function eventually(look, what) {
  const end = Date.now() + PATIENCE;
  for (;;) {
    const seen = await look();
    if (seen !== null && seen !== undefined && seen !== false) {
      return seen;
    }
    assert(Date.now() < end, `never came: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
