/** Planning: progress, result, cancellation and refusal. */

import assert from "node:assert/strict";
import path from "node:path";
import { after, test } from "node:test";

import { closeBrowser, eventually, until, withPage } from "./support/browser.js";
import { example } from "./support/meshes.js";
import { difference, ofHues } from "./support/pixels.js";
import { EXAMPLES, Server } from "./support/server.js";
import { choose, drawn, fact, fingerColors, open, picture, set, stage } from "./support/steps.js";

after(closeBrowser);

const DUCK = path.join(EXAMPLES, "duck.obj");
const QUICK = { seed: 1, generations: 2, population: 4 };
/** Number of pixels from which on a colour counts as visible; a grey body has next to none. */
const SEEN = 60;

/** A search that improves for minutes and would run for hours. */
const LONG = { Search: "modified_ga", Seed: 1, Generations: 100_000, Population: 200 };

/** A number as the page shows it, to four digits. */
const rounded = (value) => Number(value.toPrecision(4));

/** How many of the colours are visible. */
async function seen(png, colors) {
  const counts = await ofHues(png, colors);
  return counts.filter((pixels) => pixels > SEEN).length;
}

test("the final grasp of a search is shown", async (t) => {
  const server = await Server.start(t, { GRASPD_THREADS_PER_JOB: "1" });
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await choose(page, DUCK);
    await drawn(page);
    const before = await picture(page);
    await set(page, { Fingers: 4, Seed: 1, Generations: 60 });
    await page.getByRole("button", { name: /plan the grasp/i }).click();

    const quality = page.getByTestId("quality");
    await quality.waitFor();
    const [{ id }] = (await server.json("/jobs")).jobs;
    const { result } = await server.json(`/jobs/${id}`);
    assert.equal(Number(await quality.textContent()), rounded(result.quality));
    assert.equal(await page.getByRole("region", { name: "Contacts" }).getByRole("row").count(), 5);
    assert.equal(new URL(page.url()).hash, `#/jobs/${id}`);
    await page
      .getByRole("status")
      .filter({ hasText: /quality/ })
      .first()
      .waitFor({ state: "attached" });

    const colors = await fingerColors(page);
    assert.equal(new Set(colors).size, 4);
    assert.equal(await seen(before, colors), 0, "arrows before there was a grasp");
    // One arrow may be behind the body.
    assert((await seen(await picture(page), colors)) >= 3, "arrows in the colours of the table");
    await page.getByLabel("Arrows").uncheck();
    await page.getByLabel("Friction cones").uncheck();
    assert.equal(await seen(await picture(page), colors), 0, "arrows that are hidden");
    await page.getByLabel("Arrows").check();
    assert((await seen(await picture(page), colors)) >= 3, "arrows that are shown again");
  });
});

test("a search is followed and cancelled, and its best grasp is kept", async (t) => {
  const server = await Server.start(t, { GRASPD_THREADS_PER_JOB: "1" });
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await choose(page, DUCK);
    await drawn(page);
    await set(page, { Fingers: 7, ...LONG });
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    const search = page.getByRole("region", { name: "Search" });
    const shown = (name) => fact(search, name).textContent();
    await eventually(async () => /^0\.\d/.test(await shown(/best quality/i)), "a first grasp");
    const [quality, evaluated] = [await shown(/best quality/i), await shown(/evaluated/i)];
    const before = await picture(page);
    await eventually(
      async () => (await difference(before, await stage(page).screenshot())) > 0.001,
      "arrows that have moved",
    );
    assert.notEqual(await shown(/best quality/i), quality);
    assert.notEqual(await shown(/evaluated/i), evaluated);
    await search.getByRole("button", { name: /cancel/i }).click();
    await page.getByText("Cancelled", { exact: true }).waitFor();
    const [{ id, state }] = (await server.json("/jobs")).jobs;
    assert.equal(state, "cancelled");
    // On a busy machine a cancelled run may not return its result in the time that it is given.
    const { result } = await server.json(`/jobs/${id}`);
    if (result === undefined) {
      await page
        .getByText(/it was cancelled/i)
        .first()
        .waitFor();
      assert.equal(await page.getByTestId("quality").count(), 0);
    } else {
      assert.equal(
        Number(await page.getByTestId("quality").textContent()),
        rounded(result.quality),
      );
      await page
        .getByText(/it was cancelled/i)
        .first()
        .waitFor({ state: "attached" });
    }
  });
});

test("a queued job is cancelled too", async (t) => {
  const server = await Server.start(t);
  await server.submit(await example("duck.obj"), { generations: 100_000, population: 50 });
  const { id } = await server.submit(await example("box.stl"), QUICK);
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${id}`);
    await page.getByText(/waiting for its turn/i).waitFor();
    await page.getByRole("button", { name: /cancel/i }).click();
    await page.getByText("Cancelled", { exact: true }).waitFor();
    await page
      .getByText(/it was cancelled/i)
      .first()
      .waitFor();
  });
});

test("invalid settings are reported at their fields, in the words of the service", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, { expected: [/status of 422/] }, async (page) => {
    await open(page, server);
    await choose(page, path.join(EXAMPLES, "box.stl"));
    await drawn(page);
    await set(page, { Fingers: 4000, "Friction μ": -1, Generations: -1 });
    const refused = page.waitForResponse((response) => response.status() === 422);
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    const { errors } = await (await refused).json();
    const fields = {
      "/contacts": "Fingers",
      "/friction": "Friction μ",
      "/generations": "Generations",
    };
    assert.deepEqual(errors.map(({ pointer }) => pointer).sort(), Object.keys(fields).sort());
    for (const { pointer, detail } of errors) {
      const field = page.getByLabel(fields[pointer], { exact: true });
      assert.equal(await field.getAttribute("aria-invalid"), "true");
      const said = (await field.getAttribute("aria-describedby")).split(" ");
      const texts = await Promise.all(said.map((id) => page.locator(`[id="${id}"]`).textContent()));
      assert(texts.includes(detail), `${detail} at ${pointer}: ${texts}`);
      assert(await field.isVisible(), `${pointer} is to be seen`);
    }
    await set(page, { Fingers: "", "Friction μ": "", Generations: 1, Population: 4 });
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    await page.getByTestId("quality").waitFor();
  });
});

test("a result without a force-closure grasp gives the reason", async (t) => {
  const server = await Server.start(t);
  // Three points without friction hold nothing.
  const settings = { ...QUICK, contacts: 3, contact_model: "frictionless" };
  const job = await server.plan(await example("box.stl"), settings);
  assert.equal(job.result.force_closure, false);
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    await page.getByText(job.result.explanation.detail, { exact: true }).waitFor();
    await page.getByText(/no grasp that holds/i).waitFor();
    assert.equal(await page.getByTestId("quality").count(), 0);
    await drawn(page);
  });
});

test("a failed job says why", async (t) => {
  const server = await Server.start(t);
  // Only reading the mesh shows whether there is such a triangle.
  const constraints = JSON.stringify({ fixed_contacts: [{ triangle: 1_000_000 }] });
  const job = await server.plan(await example("box.stl"), { ...QUICK, constraints });
  assert.equal(job.state, "failed");
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    const alert = page.getByRole("alert");
    await alert.getByText(job.problem.title, { exact: true }).waitFor();
    await alert.getByText(job.problem.errors[0].detail).waitFor();
    await drawn(page);
  });
});

test("regions, the first grasp and other grasps are shown on the body", async (t) => {
  const server = await Server.start(t);
  const job = await server.plan(await example("duck.obj"), { ...QUICK, contacts: 4, top: 3 });
  assert(job.result.top.length > 1, "more than one grasp");
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    await drawn(page);
    const best = await picture(page);
    const colors = await fingerColors(page);
    const few = await ofHues(best, colors);

    await page.getByLabel(/where each finger may be/i).check();
    await page.getByText(/finger 1: [\d,]+ triangles/).waitFor();
    const colored = await picture(page);
    const many = await ofHues(colored, colors);
    assert(
      many.some((pixels, at) => pixels > few[at] + 100),
      `the body takes on the colours of the fingers: ${few} then ${many}`,
    );

    const choice = page.getByLabel("Shown", { exact: true });
    const measured = (quality) =>
      page
        .locator(".measures .value")
        .first()
        .filter({ hasText: String(rounded(quality)) })
        .waitFor();
    await measured(job.result.quality);
    await choice.selectOption({ index: 1 });
    await measured(job.result.top[1].quality);
    assert((await difference(best, await picture(page))) > 0.002, "another grasp");
    await choice.selectOption("initial");
    await measured(job.result.initial.quality);
    assert((await difference(best, await picture(page))) > 0.002, "the first grasp");
    await choice.selectOption("best");
    assert((await difference(best, await picture(page))) < 0.002, "the best again");
    await page.getByLabel(/with the first grasp/i).check();
    assert((await difference(best, await picture(page))) > 0.001, "both");
  });
});

test("constraints are drawn, sent and kept", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await choose(page, DUCK);
    await drawn(page);
    const without = await picture(page);
    await page.getByText("Where fingers may be").click();
    await page.getByLabel("Kind of region").selectOption("box");
    await page.getByRole("button", { name: "Add region" }).click();
    assert((await difference(without, await picture(page))) > 0.01, "the region is seen");
    const low = Number(await page.getByLabel("lowest z").inputValue());
    await set(page, { Fingers: 4, Seed: 1, Generations: 2, Population: 4 });
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    await page.getByTestId("quality").waitFor();
    const [{ id }] = (await server.json("/jobs")).jobs;
    const { result } = await server.json(`/jobs/${id}`);
    assert(
      result.contacts.every(({ position }) => position[2] <= low),
      "below the region",
    );
  });
});

test("fingers are fixed by a click or by numbers, and restored with the form", async (t) => {
  const server = await Server.start(t);
  await withPage(server.url, {}, async (page) => {
    await open(page, server);
    await choose(page, path.join(EXAMPLES, "box.stl"));
    await drawn(page);
    await page.getByText("Where fingers may be").click();
    const fix = page.getByRole("button", { name: "Fix a finger here" });
    const given = page.getByRole("listitem").filter({ hasText: /^At / });
    const place = async (...values) => {
      for (const [at, axis] of ["x", "y", "z"].entries()) {
        await page.getByLabel(`${axis} of the place`).fill(values[at]);
      }
    };

    const { width, height } = await stage(page).boundingBox();
    await stage(page).click({ position: { x: width / 2, y: height / 2 } });
    await page.getByText(/^Triangle \d+ at /).waitFor();
    assert.equal(await page.getByLabel("View", { exact: true }).inputValue(), "iso");
    await fix.click();
    await given.waitFor();
    // Another button pans the view.
    await stage(page).click({ position: { x: width / 2, y: height / 2 }, button: "right" });
    assert.equal(await page.getByLabel("x of the place").inputValue(), "");

    // A position that is typed but not fixed blocks the form.
    await place("1000", "0", "");
    await set(page, { Fingers: 4, Seed: 1, Generations: 2, Population: 4, Label: "two given" });
    const plan = page.getByRole("button", { name: /plan the grasp/i });
    await plan.click();
    await page
      .getByRole("alert")
      .getByText(/fix the finger/i)
      .waitFor();
    await page.getByLabel("z of the place").fill("0");
    await page.getByLabel("z of the place").press("Enter");
    await until(page, () => document.querySelectorAll(".plain li").length === 2);
    await place("1", "2", "3");
    await fix.click();
    await given.nth(2).getByRole("button", { name: "Remove" }).click();
    assert.equal(await given.count(), 2);

    await plan.click();
    await page.getByTestId("quality").waitFor();
    const [{ id }] = (await server.json("/jobs")).jobs;
    const { result, mesh_report: report } = await server.json(`/jobs/${id}`);
    const fixed = result.contacts.filter((contact) => contact.fixed);
    assert.equal(fixed.length, 2);
    // The surface point nearest to a point far out along x has the greatest x.
    assert.equal(fixed[1].position[0], report.bounds[1][0]);

    await page.reload();
    await page.getByTestId("quality").waitFor();
    await page.goBack();
    await drawn(page);
    assert.equal(await given.count(), 2);
    assert.equal(await page.getByLabel("Label", { exact: true }).inputValue(), "two given");
    assert.equal(await page.getByLabel("Generations", { exact: true }).inputValue(), "2");
  });
});

test("planning again starts from the same settings", async (t) => {
  const server = await Server.start(t);
  const box = { box: { min: [-1e3, -1e3, -1e3], max: [1e3, 1e3, 0.25] } };
  const constraints = {
    include: [box],
    exclude: [{ half_space: { point: [0, 0, -5], normal: [0, 0, -1] } }],
    min_contact_distance: 0.01,
    approach_directions: [[0, 0, 1]],
    max_normal_angle: 170,
  };
  const wanted = { contacts: 5, friction: 0.7, wrench_space: "linf", center_of_mass: "[0,0,0.5]" };
  const job = await server.plan(await example("box.stl"), {
    ...QUICK,
    ...wanted,
    constraints: JSON.stringify(constraints),
  });
  await withPage(server.url, {}, async (page) => {
    await open(page, server, `/#/jobs/${job.id}`);
    await page.getByTestId("quality").waitFor();
    await drawn(page);
    const shown = await picture(page);
    await page.getByLabel("Regions").uncheck();
    assert((await difference(shown, await picture(page))) > 0.002, "its regions are drawn");
    await page.getByRole("link", { name: /plan again/i }).click();
    const without = page.getByText(/approach_directions, max_normal_angle/);
    await without.waitFor();
    await page.reload();
    await without.waitFor();
    await set(page, { Generations: 2, Population: 4 });
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    await page.waitForURL((url) => url.hash.startsWith("#/jobs/") && !url.hash.includes(job.id));
    const [again] = (await server.json("/jobs")).jobs;
    const same = ({ request }) =>
      ["contacts", "friction", "wrench_space", "center_of_mass", "constraints"].map(
        (name) => request[name],
      );
    assert.deepEqual(same(again), same(job));

    // Settings of a method are dropped with the method.
    await page.getByRole("link", { name: /plan again/i }).click();
    await page.getByLabel("Fingers", { exact: true }).waitFor();
    await set(page, { Search: "modified_ga", Generations: 2, Population: 4 });
    await page.getByRole("button", { name: /plan the grasp/i }).click();
    await page.waitForURL((url) => url.hash.startsWith("#/jobs/") && !url.hash.includes(again.id));
    const [other] = (await server.json("/jobs")).jobs;
    const usual = await server.submit(await example("box.stl"), {
      ...QUICK,
      method: "modified_ga",
    });
    const ofMethod = ({ request: { method, initial, polish } }) => [method, initial, polish];
    assert.deepEqual(ofMethod(other), ofMethod(usual));
    assert.notDeepEqual(ofMethod(other), ofMethod(job));
  });
});
