/** Light or dark: as the system says until the reader says otherwise. */

export type Theme = "light" | "dark";

const KEY = "graspd-theme";
const system = window.matchMedia("(prefers-color-scheme: dark)");

function chosen(): Theme | null {
  const kept = localStorage.getItem(KEY);
  return kept === "light" || kept === "dark" ? kept : null;
}

export const theme = (): Theme => chosen() ?? (system.matches ? "dark" : "light");

/** Applies the theme now and whenever it changes. */
export function followTheme(apply: (theme: Theme) => void): void {
  const update = (): void => {
    document.documentElement.dataset["theme"] = theme();
    apply(theme());
  };
  system.addEventListener("change", update);
  window.addEventListener("graspd-theme", update);
  update();
}

export function toggleTheme(): void {
  localStorage.setItem(KEY, theme() === "dark" ? "light" : "dark");
  window.dispatchEvent(new Event("graspd-theme"));
}
