//! Colours with the same meaning in pictures, exports and on the page.

/// Colours of the contacts, in a cycle: Okabe and Ito's palette, which most eyes can distinguish.
pub const CONTACT_COLORS: [[u8; 3]; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [150, 140, 20],
];
/// Colour of the weakest force.
pub const FORCE: [u8; 3] = [200, 30, 45];
/// Colour of the weakest torque.
pub const TORQUE: [u8; 3] = [120, 60, 200];
/// Colour of the centre of mass.
pub const CENTER: [u8; 3] = [25, 27, 31];

/// Formats a colour for SVG.
pub(super) fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
