/** Buttons that put the request of the page into the clipboard. */

import { apiKey } from "../api/client";
import { asCurl, asJson, asPython } from "../copy";
import { h } from "../dom";

interface Source {
  meshId: string;
  request: Record<string, unknown>;
}

export function copyButtons(source: () => Source): HTMLElement {
  const said = h("span", { role: "status", class: "muted" });
  const text = h("textarea", { readonly: true, rows: 6, hidden: true, "aria-label": "Request" });
  const button = (title: string, make: (source: Source) => string): HTMLElement => {
    const element = h("button", { type: "button" }, title);
    element.addEventListener("click", () => {
      text.value = make(source());
      write(text.value).then(
        () => {
          text.hidden = true;
          said.textContent = "Copied.";
        },
        () => {
          text.hidden = false;
          text.select();
          said.textContent = "The browser does not let the page copy. Take it from here:";
        },
      );
    });
    return element;
  };
  const keyed = (): boolean => apiKey.get() !== null;
  const { origin } = window.location;
  return h(
    "div",
    { class: "row" },
    button("Copy as curl", ({ meshId, request }) => asCurl(origin, meshId, request, keyed())),
    button("Copy as Python", ({ meshId, request }) => asPython(origin, meshId, request, keyed())),
    button("Copy as JSON", ({ meshId, request }) => asJson(meshId, request)),
    said,
    text,
  );
}

/** Fails where the browser forbids it, and where the page came over plain HTTP from another host. */
async function write(text: string): Promise<void> {
  // The type says that it is always there.
  const clipboard = navigator.clipboard as Clipboard | undefined;
  if (clipboard === undefined) {
    throw new Error("no clipboard");
  }
  await clipboard.writeText(text);
}
