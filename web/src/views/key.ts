/** Asks for the API key that the server wants. */

import { apiKey } from "../api/client";
import { h, replace } from "../dom";
import { type Context, heading } from "./context";

export function keyView(context: Context, again: () => void): void {
  const input = h("input", {
    id: "api-key",
    type: "password",
    autocomplete: "off",
    required: true,
  });
  const wrong = apiKey.get() !== null;
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
    apiKey.set(input.value.trim());
    again();
  });
  replace(
    context.panel,
    heading("This server wants a key"),
    wrong && h("div", { class: "problem", role: "alert" }, "The key that was given is not good."),
    form,
  );
  input.focus();
}
