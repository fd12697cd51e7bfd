//! Colours that mean the same in pictures, exports and on the page.

/// Colours of the contacts, the first again after the last: Okabe and Ito's, which most eyes tell apart.
pub const CONTACT_COLORS: [[u8; 3]; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [150, 140, 20],
];
/// Of the weakest force.
pub const FORCE: [u8; 3] = [200, 30, 45];
/// Of the weakest torque.
pub const TORQUE: [u8; 3] = [120, 60, 200];
/// Of the centre of mass.
pub const CENTER: [u8; 3] = [25, 27, 31];

/// A colour as SVG has it.
pub(super) fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}
