/** Light or dark: as the system says until the reader says otherwise. */

import { Kept } from "./storage";

export type Theme = "light" | "dark";

const kept = new Kept(() => localStorage, "graspd-theme");
/** The event of the window that tells that the reader has chosen. */
const CHOSEN = "graspd-theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

function chosen(): Theme | null {
  const choice = kept.get();
  return choice === "light" || choice === "dark" ? choice : null;
}

export const theme = (): Theme => chosen() ?? (system.matches ? "dark" : "light");

/** Applies the theme now and whenever it changes, until `signal` says that nobody looks any more. */
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
  kept.set(theme() === "dark" ? "light" : "dark");
  window.dispatchEvent(new Event(CHOSEN));
}
