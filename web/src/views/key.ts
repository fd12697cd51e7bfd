/** Asks for the API key that the server wants. */

import { apiKey } from "../api/client";
import { h, replace } from "../dom";
import { alertBox, type Context, heading } from "./context";

export function keyView(context: Context, again: () => void): void {
  const input = h("input", {
    id: "api-key",
    type: "password",
    autocomplete: "off",
    required: true,
  });
  const said = h("div");
  const refuse = (): void => {
    replace(said, alertBox("The key that was given is not good."));
  };
  if (apiKey.get() !== null) {
    refuse();
  }
  const form = h(
    "form",
    {},
    h(
      "div",
      { class: "field" },
      h("label", { for: "api-key" }, "API key"),
      input,
      h(
        "small",
        {},
        "Made by whoever runs the server, with graspd keys create. It is kept until this tab is closed.",
      ),
    ),
    h("button", { type: "submit", class: "primary" }, "Use this key"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    // What is copied may bring spaces along that nobody sees.
    const key = input.value.replace(/[\s\p{Cf}]/gu, "");
    if (/^[!-~]+$/.test(key)) {
      apiKey.set(key);
      again();
    } else {
      // No header can carry it, and no server has made it.
      refuse();
      input.focus();
    }
  });
  replace(context.panel, heading("This server wants a key"), said, form);
  input.focus();
}
