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
  h("a", { class: "skip", href: "#panel" }, "Skip to the controls"),
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

async function route(focus: boolean): Promise<void> {
  // The link to skip to the controls is no place of the page.
  if (window.location.hash === "#panel") {
    return;
  }
  const context = renew();
  context.reachable(true);
  stage.onPick(null);
  const place = parse(window.location.hash);
  try {
    switch (place.at) {
      case "start":
        startView(context);
        break;
      case "mesh":
        replace(panel, heading("Mesh"), h("p", {}, "Loading…"));
        await settingsView(context, place.id);
        break;
      case "job":
        await jobView(context, place.id);
        break;
      case "unknown":
        stage.clear();
        replace(panel, heading("Nothing is here"), h("a", { href: START }, "To the start"));
    }
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
  if (focus && !context.signal.aborted) {
    panel.querySelector<HTMLElement>(".view-heading")?.focus({ preventScroll: true });
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
  panel.querySelector<HTMLElement>(".view-heading")?.focus();
});
void route(false);
