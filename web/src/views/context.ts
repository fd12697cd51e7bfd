/** What every view is given. */

import { Problem } from "../api/client";
import { h } from "../dom";
import type { Stage } from "../stage";

export interface Context {
  stage: Stage;
  panel: HTMLElement;
  /** Aborted when the user leaves the view. */
  signal: AbortSignal;
  /** Has screen readers read a text. */
  announce(text: string): void;
  /** Shows whether the server can be reached. */
  reachable: (is: boolean) => void;
  go(hash: string): void;
}

/** An alert with a text of the page. */
export const alertBox = (text: string): HTMLElement =>
  h("div", { class: "problem", role: "alert" }, text);

/** An alert with an error of the service, in its own words. */
export function problemBox(error: unknown): HTMLElement {
  const problem =
    error instanceof Problem
      ? error
      : new Problem({ status: 0, title: "Something went wrong", detail: String(error) });
  const places = problem.errors
    .filter((field) => field.detail !== problem.message)
    .map((field) =>
      h("li", {}, field.pointer === "" ? null : h("code", {}, field.pointer), " ", field.detail),
    );
  return h(
    "div",
    { class: "problem", role: "alert" },
    h("strong", {}, problem.title),
    h("p", {}, problem.message),
    places.length > 0 && h("ul", {}, ...places),
  );
}

/** A heading that can be given the focus when its view appears. */
export function heading(text: string): HTMLHeadingElement {
  return h("h2", { tabindex: "-1", class: "view-heading" }, text);
}
