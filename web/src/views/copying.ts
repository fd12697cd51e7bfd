/** Buttons that copy the request to the clipboard. */

import { apiKey } from "../api/client";
import { asCurl, asJson, asPython } from "../copy";
import { h } from "../dom";

interface Source {
  meshId: string;
  request: Record<string, unknown>;
}

export function copyButtons(source: () => Source): HTMLElement {
  const message = h("span", { role: "status", class: "muted" });
  const text = h("textarea", { readonly: true, rows: 6, hidden: true, "aria-label": "Request" });
  const button = (title: string, make: (source: Source) => string): HTMLElement => {
    const element = h("button", { type: "button" }, title);
    element.addEventListener("click", () => {
      text.value = make(source());
      write(text.value).then(
        () => {
          text.hidden = true;
          message.textContent = "Copied.";
        },
        () => {
          text.hidden = false;
          text.select();
          message.textContent = "The browser does not allow copying. Copy the text from here:";
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
    message,
    text,
  );
}

/** Fails if the browser forbids it, or if the page came over plain HTTP from another host. */
async function write(text: string): Promise<void> {
  // The type claims that it always exists.
  const clipboard = navigator.clipboard as Clipboard | undefined;
  if (clipboard === undefined) {
    throw new Error("no clipboard");
  }
  await clipboard.writeText(text);
}
