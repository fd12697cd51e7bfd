/** The checks of `withPage` notice a page that violates its policy, contacts another host or fails. */

import assert from "node:assert/strict";
import { createServer } from "node:http";
import { once } from "node:events";
import { after, test } from "node:test";

import { closeBrowser, withPage } from "./support/browser.js";

after(closeBrowser);

const WRONG = [
  ["an inline style", "<style>p{color:red}</style>", "", /"complaints":.*Content Security Policy/s],
  ["an inline script", "<script>1</script>", "", /"complaints":.*Content Security Policy/s],
  ["a missing file", "<img src='/gone.png'>", "img-src 'self'", /"complaints":.*404/s],
  ["an exception", "<script src='/throws.js'></script>", "script-src 'self'", /on purpose/],
  ["another host", "<img src='http://else.invalid/'>", "img-src *", /"elsewhere":.*else\.invalid/s],
];

async function pages(test, html, policy) {
  const server = createServer((request, response) => {
    response.setHeader("Content-Security-Policy", `default-src 'none'; ${policy}`);
    if (request.url === "/favicon.ico") {
      response.writeHead(204).end();
    } else if (request.url === "/") {
      response.setHeader("Content-Type", "text/html");
      response.end(`<!doctype html><title>broken</title>${html}`);
    } else if (request.url === "/throws.js") {
      response.setHeader("Content-Type", "text/javascript");
      response.end("throw new Error('thrown on purpose')");
    } else {
      response.writeHead(404).end();
    }
  });
  server.listen(0, "127.0.0.1");
  await once(server, "listening");
  test.after(() => server.closeAllConnections());
  test.after(() => server.close());
  return `http://127.0.0.1:${server.address().port}`;
}

const visit = (url) => withPage(url, {}, (page) => page.goto(url, { waitUntil: "networkidle" }));

test("a page without faults passes", async (t) => {
  await visit(await pages(t, "<p>All is well</p>", ""));
});

for (const [what, html, policy, said] of WRONG) {
  test(`${what} is noticed`, async (t) => {
    await assert.rejects(visit(await pages(t, html, policy)), { message: said });
  });
}
