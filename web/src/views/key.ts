/** Asks for the API key that the server requires. */

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
  const message = h("div");
  const refuse = (): void => {
    replace(message, alertBox("The key is not good: the server does not accept it."));
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
        "The operator of the server creates keys with graspd keys create. The key is kept until this tab is closed.",
      ),
    ),
    h("button", { type: "submit", class: "primary" }, "Use this key"),
  );
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    // A copied key may contain white space and invisible characters.
    const key = input.value.replace(/[\s\p{Cf}]/gu, "");
    if (/^[!-~]+$/.test(key)) {
      apiKey.set(key);
      again();
    } else {
      // No header can carry it, so no server can have created it.
      refuse();
      input.focus();
    }
  });
  replace(context.panel, heading("This server requires a key"), message, form);
  input.focus();
}
