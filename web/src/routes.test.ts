import { expect, test } from "vitest";

import { jobLink, meshLink, parse } from "./routes";

test("links parse to their routes", () => {
  expect(parse("")).toEqual({ at: "start" });
  expect(parse("#/")).toEqual({ at: "start" });
  expect(parse(meshLink("0a1b"))).toEqual({ at: "mesh", id: "0a1b" });
  expect(parse(jobLink("01a2-b3"))).toEqual({ at: "job", id: "01a2-b3" });
});

test("anything else is an unknown route", () => {
  for (const hash of ["#/jobs", "#/jobs/", "#/jobs/a/b", "#/jobs/..%2f", "#/x/1", "#/meshes/<b>"]) {
    expect(parse(hash).at).toBe("unknown");
  }
});
