/**
 * Writes src/api/openapi.ts, the types of what the service sends and takes, from openapi/openapi.json; with --check
 * says whether it is stale. The routes are left out: the page has a client of its own.
 */

import { readFile, writeFile } from "node:fs/promises";
import openapiTS, { astToString } from "openapi-typescript";
import { format, resolveConfig } from "prettier";

const file = new URL("src/api/openapi.ts", import.meta.url);
const source = new URL("../openapi/openapi.json", import.meta.url);
const { openapi, info, components } = JSON.parse(await readFile(source, "utf8"));
const types = await openapiTS({
  openapi,
  info,
  paths: {},
  components: { schemas: components.schemas },
});
const text = await format(
  `/** Written by \`npm run types\`: do not edit. */\n\n${astToString(types)}`,
  {
    ...(await resolveConfig(file)),
    parser: "typescript",
  },
);
if (!process.argv.includes("--check")) {
  await writeFile(file, text);
} else if ((await readFile(file, "utf8")) !== text) {
  console.error("src/api/openapi.ts is stale: run `npm run types` in web/");
  process.exitCode = 1;
}
