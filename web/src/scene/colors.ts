/** Colours of the contacts, as in the service's own pictures: Okabe and Ito's palette, which most eyes can distinguish. */
export const CONTACT_COLORS = [
  "#0072b2",
  "#d55e00",
  "#009e73",
  "#cc79a7",
  "#e69f00",
  "#56b4e9",
  "#968c14",
] as const;

export const contactColor = (index: number): string =>
  CONTACT_COLORS[index % CONTACT_COLORS.length] ?? CONTACT_COLORS[0];

export const FORCE_COLOR = "#c81e2d";
export const TORQUE_COLOR = "#783cc8";
export const EXCLUDE_COLOR = "#d33a2c";
export const INCLUDE_COLOR = "#2a9d4a";

export interface Palette {
  background: string;
  body: string;
  ghost: string;
  wire: string;
  /** Colour of sharp edges. */
  crease: string;
}

export const PALETTES: Record<"light" | "dark", Palette> = {
  light: {
    background: "#f2f4f7",
    body: "#d3cdc2",
    ghost: "#5c6470",
    wire: "#8a857c",
    crease: "#4c4841",
  },
  dark: {
    background: "#14171c",
    body: "#b9b4aa",
    ghost: "#c3cad4",
    wire: "#5d5a55",
    crease: "#35322d",
  },
};
