/** Steps that a user takes on the page, by its visible labels. */

import { until } from "./browser.js";

export const stage = (page) => page.getByRole("application", { name: /three dimensions/i });

/** Opens the page and waits until it is ready. */
export async function open(page, server, place = "/#/") {
  await page.goto(server.url + place);
  await page.getByRole("heading", { level: 1 }).waitFor();
}

/** Chooses a file by the file field. `file` is a path, or {name, mimeType, buffer}. */
export const choose = (page, file) => page.getByLabel(/choose a mesh file/i).setInputFiles(file);

/** Drops a file on `target`, with the events that a browser sends for a file from a file manager. */
export async function drop(page, { name, bytes }, target = "body") {
  const dataTransfer = await page.evaluateHandle(
    ({ name, base64 }) => {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      const transfer = new DataTransfer();
      transfer.items.add(new File([bytes], name));
      return transfer;
    },
    { name, base64: bytes.toString("base64") },
  );
  for (const event of ["dragenter", "dragover", "drop"]) {
    await page.dispatchEvent(target, event, { dataTransfer });
  }
}

/** The number of drawn triangles, once there are any and they have been rendered. */
export async function drawn(page) {
  const handle = await until(page, () => {
    const count = Number(document.querySelector("[data-triangles]")?.dataset.triangles ?? 0);
    return count > 0 && count;
  });
  await frames(page);
  return handle.jsonValue();
}

/** Resolves after the next two frames, when all earlier changes are visible. */
export const frames = (page) =>
  page.evaluate(
    () => new Promise((seen) => requestAnimationFrame(() => requestAnimationFrame(seen))),
  );

/** A screenshot of the 3-D view, once nothing in it moves. */
export async function picture(page) {
  const view = stage(page);
  let before = null;
  for (;;) {
    await frames(page);
    const now = await view.screenshot();
    if (before !== null && now.equals(before)) {
      return now;
    }
    before = now;
  }
}

/** Fills in settings by their labels, opening collapsed sections if necessary. */
export async function set(page, settings) {
  for (const [label, value] of Object.entries(settings)) {
    const field = page.getByLabel(label, { exact: true });
    const folded = page.locator("details:not([open])").filter({ has: field });
    if ((await folded.count()) > 0) {
      await folded.locator("summary").first().click();
    }
    if ((await field.evaluate((element) => element.tagName)) === "SELECT") {
      await field.selectOption(value);
    } else {
      await field.fill(String(value));
    }
  }
}

/** The value of a name in a definition list. */
export const fact = (within, name) =>
  within.locator("dt").filter({ hasText: name }).locator("xpath=following-sibling::dd[1]");

/** The colours of the fingers in the table of contacts, as #rrggbb. */
export const fingerColors = (page) =>
  page
    .getByRole("region", { name: "Contacts" })
    .getByRole("rowheader")
    .evaluateAll((heads) =>
      heads.map((head) => {
        const color = getComputedStyle(head.querySelector("[aria-hidden]")).backgroundColor;
        const parts = color.match(/\d+/g).slice(0, 3);
        return `#${parts.map((part) => Number(part).toString(16).padStart(2, "0")).join("")}`;
      }),
    );

/** Opens all collapsed sections. */
export const unfold = (page) =>
  page.locator("details").evaluateAll((all) => all.forEach((one) => (one.open = true)));
