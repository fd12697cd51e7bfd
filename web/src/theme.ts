/** The light or dark theme: that of the system unless the user has chosen one. */

import { StoredValue } from "./storage";

export type Theme = "light" | "dark";

const stored = new StoredValue(() => localStorage, "graspd-theme");
/** The window event that is sent when the user has chosen a theme. */
const CHOSEN = "graspd-theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

function chosen(): Theme | null {
  const choice = stored.get();
  return choice === "light" || choice === "dark" ? choice : null;
}

export const theme = (): Theme => chosen() ?? (system.matches ? "dark" : "light");

/** Applies the theme now and whenever it changes, until `signal` is aborted. */
export function followTheme(apply: (theme: Theme) => void, signal?: AbortSignal): void {
  const update = (): void => {
    document.documentElement.dataset["theme"] = theme();
    apply(theme());
  };
  const options = signal === undefined ? {} : { signal };
  system.addEventListener("change", update, options);
  window.addEventListener(CHOSEN, update, options);
  update();
}

export function toggleTheme(): void {
  stored.set(theme() === "dark" ? "light" : "dark");
  window.dispatchEvent(new Event(CHOSEN));
}
