//! The background of a picture, and the colours of the text on it.

const LIGHT: &str = ".paper{fill:#ffffff}.text{fill:#1b1e24}.muted{fill:#5c6470}.warning{fill:#9a3a00}\
    .rule{stroke:#dfe3e8}.curve{stroke:#0b63a8}.mean{stroke:#6d7683}.point{fill:#0b63a8}\
    .ring{stroke:#14161a}";
const DARK: &str = ".paper{fill:#16181c}.text{fill:#e8eaee}.muted{fill:#a0a9b6}.warning{fill:#f0a35a}\
    .rule{stroke:#333842}.curve{stroke:#6cb6ff}.mean{stroke:#98a1ae}.point{fill:#6cb6ff}\
    .ring{stroke:#e8eaee}";

/// The background of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// White.
    Light,
    /// Nearly black.
    Dark,
    /// Transparent.
    Transparent,
}

impl Background {
    /// Returns the SVG style rules of background, text, lines and curves. On a transparent background they follow the
    /// preference of the viewer for light or dark.
    pub(super) fn style(self) -> String {
        match self {
            Self::Light => LIGHT.to_owned(),
            Self::Dark => DARK.to_owned(),
            Self::Transparent => format!("{LIGHT}@media (prefers-color-scheme:dark){{{DARK}}}"),
        }
    }

    /// Returns the background of a PNG, which cannot follow the preference of the viewer: light unless it is dark.
    pub(super) fn opaque(self) -> Self {
        match self {
            Self::Dark => Self::Dark,
            Self::Light | Self::Transparent => Self::Light,
        }
    }

    /// Returns the colour of the background.
    pub(super) fn paper(self) -> [u8; 3] {
        match self.opaque() {
            Self::Dark => [0x16, 0x18, 0x1c],
            _ => [255; 3],
        }
    }
}
