import { execFileSync } from "node:child_process";

import { expect, test } from "vitest";

import { asCurl, asJson, asPython, shell } from "./copy";

const HOSTILE = 'it\'s "$(touch /tmp/x)" `id` \\ \n <img src=x onerror=alert(1)> é \u202e';
const REQUEST = { contacts: 4, label: HOSTILE, time_limit_s: null };
const EXPECTED = { mesh_id: "abc", contacts: 4, label: HOSTILE };

test("a shell reads a quoted text back unchanged", () => {
  const out = execFileSync("sh", ["-c", `printf %s ${shell(HOSTILE)}`], { encoding: "utf8" });
  expect(out).toBe(HOSTILE);
});

test("all three send the same request", () => {
  expect(JSON.parse(asJson("abc", REQUEST))).toEqual(EXPECTED);
  const curl = asCurl("http://localhost:1", "abc", REQUEST, true).replace(
    /^curl/,
    "printf '%s\\n'",
  );
  const words = execFileSync("sh", ["-c", curl], {
    encoding: "utf8",
    env: { ...process.env, GRASPD_API_KEY: "k" },
  });
  expect(words).toContain("Authorization: Bearer k");
  const json = words.slice(words.indexOf("{"), words.lastIndexOf("}") + 1);
  expect(JSON.parse(json)).toEqual(EXPECTED);
  const python = asPython("http://localhost:1", "abc", REQUEST, false).split("\ndef call")[0] ?? "";
  const read = execFileSync("python3", ["-c", `${python}\nprint(json.dumps(request))`], {
    encoding: "utf8",
  });
  expect(JSON.parse(read)).toEqual(EXPECTED);
});
