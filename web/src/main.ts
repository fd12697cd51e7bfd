/** The page: the 3-D view on one side, the panel with the current view's controls on the other. */

import { KEY_REQUIRED } from "./api/client";
import { h, replace } from "./dom";
import { parse, START } from "./routes";
import { Stage } from "./stage";
import { followTheme, toggleTheme } from "./theme";
import { type Context, heading, problemBox } from "./views/context";
import { jobView } from "./views/job";
import { keyView } from "./views/key";
import { settingsView } from "./views/settings";
import { startView } from "./views/start";

/** Link target of the panel. */
const SKIP = "#panel";

const stage = new Stage();
const panel = h("div", { class: "panel-body" });
const status = h("p", { class: "visually-hidden", role: "status" });
const offline = h(
  "p",
  { class: "offline", role: "alert", hidden: true },
  "The server does not answer. This page continues as soon as it does.",
);
const themeButton = h("button", { type: "button", class: "quiet", onclick: toggleTheme }, "Theme");

document.body.append(
  h("a", { class: "skip", href: SKIP }, "Skip to the controls"),
  h(
    "header",
    {},
    h("h1", {}, h("a", { href: START }, "graspd")),
    h(
      "nav",
      { "aria-label": "Page" },
      h("a", { href: START }, "New"),
      h("a", { href: "/docs/" }, "API"),
      themeButton,
    ),
  ),
  offline,
  h(
    "main",
    {},
    stage.element,
    h("section", { class: "panel", id: "panel", "aria-label": "Controls" }, panel),
  ),
  status,
);
followTheme((theme) => {
  themeButton.textContent = theme === "dark" ? "Light" : "Dark";
  themeButton.setAttribute(
    "aria-label",
    `Switch to the ${theme === "dark" ? "light" : "dark"} theme`,
  );
});

// Otherwise the browser would leave the page to open a file that is dropped outside a drop target.
for (const kind of ["dragover", "drop"]) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
  });
}

let current = new AbortController();

/** Creates the context of a new view and aborts that of the previous one. */
function newContext(): Context {
  current.abort();
  current = new AbortController();
  const { signal } = current;
  document.title = "graspd";
  offline.hidden = true;
  // Calls by a view that has been left have no effect.
  const whileShown =
    <T>(act: (value: T) => void) =>
    (value: T): void => {
      if (!signal.aborted) {
        act(value);
      }
    };
  return {
    stage,
    panel,
    signal,
    announce: whileShown((text: string) => {
      status.textContent = text;
    }),
    reachable: whileShown((is: boolean) => {
      offline.hidden = is;
    }),
    go: whileShown((hash: string) => {
      window.location.hash = hash;
    }),
  };
}

/** Moves the focus to the heading of the current view. */
function focusHeading(): void {
  panel.querySelector<HTMLElement>(".view-heading")?.focus({ preventScroll: true });
}

/** Shows the view that the URL names; with `focus`, moves the focus to its heading, which screen readers then read. */
async function route(focus: boolean): Promise<void> {
  // The skip link does not name a view, but may be opened in another tab.
  if (window.location.hash === SKIP && panel.hasChildNodes()) {
    return;
  }
  const context = newContext();
  stage.onPick(null);
  try {
    const ready = view(context);
    if (focus) {
      focusHeading();
    }
    await ready;
  } catch (error) {
    if (context.signal.aborted) {
      return;
    }
    stage.clear();
    replace(
      panel,
      heading("That did not work"),
      problemBox(error),
      h("a", { href: START }, "Back to the start"),
    );
  }
  // A view that failed may have removed the element that had the focus.
  if (focus && !context.signal.aborted && document.activeElement === document.body) {
    focusHeading();
  }
}

/** Shows a view at once; the promise settles when the view is complete. */
async function view(context: Context): Promise<void> {
  const { hash } = window.location;
  const place = parse(hash === SKIP ? START : hash);
  switch (place.at) {
    case "start":
      startView(context);
      break;
    case "mesh":
      await settingsView(context, place.id);
      break;
    case "job":
      await jobView(context, place.id);
      break;
    case "unknown":
      stage.clear();
      replace(panel, heading("Page not found"), h("a", { href: START }, "Back to the start"));
  }
}

window.addEventListener(KEY_REQUIRED, () => {
  // Several calls may be refused at once.
  if (panel.querySelector("#api-key") === null) {
    stage.clear();
    keyView(newContext(), () => void route(true));
  }
});
window.addEventListener("hashchange", () => void route(true));
document.querySelector(".skip")?.addEventListener("click", (event) => {
  event.preventDefault();
  focusHeading();
});
void route(false);
