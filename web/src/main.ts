/** The page: the body on one side, what is to be said and asked about it on the other. */

import { KEY_WANTED } from "./api/client";
import { h, replace } from "./dom";
import { parse, START } from "./routes";
import { Stage } from "./stage";
import { followTheme, toggleTheme } from "./theme";
import { type Context, heading, problemBox } from "./views/context";
import { jobView } from "./views/job";
import { keyView } from "./views/key";
import { settingsView } from "./views/settings";
import { startView } from "./views/start";

/** Where the controls are. */
const SKIP = "#panel";

const stage = new Stage();
const panel = h("div", { class: "panel-body" });
const status = h("p", { class: "visually-hidden", role: "status" });
const offline = h(
  "p",
  { class: "offline", role: "alert", hidden: true },
  "The server does not answer. This page goes on as soon as it does.",
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

// A file that is dropped where none is wanted would take the place of the page.
for (const kind of ["dragover", "drop"]) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
  });
}

let current = new AbortController();

/** That of a new view; the one before is told to stop. */
function renew(): Context {
  current.abort();
  current = new AbortController();
  const { signal } = current;
  document.title = "graspd";
  offline.hidden = true;
  // What a view wanted before the reader went elsewhere is no longer wanted.
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

/** To the heading of what is shown now. */
function focusHeading(): void {
  panel.querySelector<HTMLElement>(".view-heading")?.focus({ preventScroll: true });
}

/** Shows the place that the address tells; with `focus` its heading is what is read out. */
async function route(focus: boolean): Promise<void> {
  // The link to skip to the controls is no place of the page, but may be opened in another tab.
  if (window.location.hash === SKIP && panel.hasChildNodes()) {
    return;
  }
  const context = renew();
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
      h("a", { href: START }, "To the start"),
    );
  }
  // What had it may be gone with a view that failed; anything else keeps it.
  if (focus && !context.signal.aborted && document.activeElement === document.body) {
    focusHeading();
  }
}

/** Puts a view in place at once; settled when it is whole. */
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
      replace(panel, heading("Nothing is here"), h("a", { href: START }, "To the start"));
  }
}

window.addEventListener(KEY_WANTED, () => {
  // Several calls may be refused at once.
  if (panel.querySelector("#api-key") === null) {
    stage.clear();
    keyView(renew(), () => void route(true));
  }
});
window.addEventListener("hashchange", () => void route(true));
document.querySelector(".skip")?.addEventListener("click", (event) => {
  event.preventDefault();
  focusHeading();
});
void route(false);
