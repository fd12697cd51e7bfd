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
  const button = (title: string, make: (source: Source) => string): HTMLElement => {
    const element = h("button", { type: "button" }, title);
    element.addEventListener("click", () => {
      const text = make(source());
      navigator.clipboard.writeText(text).then(
        () => {
          said.textContent = "Copied.";
        },
        () => {
          said.textContent = "The browser does not let the page copy.";
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
  );
}
