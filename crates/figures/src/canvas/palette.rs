//! The colours. Adjacent colours of the bodies and of a family differ in lightness, so that they
//! can be distinguished with any colour vision and in a grey print.

use super::Colour;
/// The box, x1, in all pictures.
pub const BOX: Colour = Colour(0, 70, 150);
/// The block, x2, in all pictures.
pub const BLOCK: Colour = Colour(200, 75, 0);
/// The secondary oscillator, x3, in all pictures.
pub const SECONDARY: Colour = Colour(20, 160, 115);
/// The block's displacement relative to the box, w, in all pictures.
pub const RELATIVE: Colour = Colour(165, 40, 130);
/// The centre of mass of box and block, U, in all pictures.
pub const CENTRE: Colour = Colour(70, 45, 0);
/// The colours of the bodies and of quantities computed from their motions. No other line or mark
/// has one of these colours.
pub const BODIES: [Colour; 5] = [CENTRE, BOX, RELATIVE, BLOCK, SECONDARY];

/// Colours of the curves of any machine, in the order of their use. Each pair differs in
/// lightness.
pub const CURVES: [Colour; 5] = [BOX, BLOCK, SECONDARY, RELATIVE, CENTRE];
/// Colours of a family of curves, in order from dark to light.
pub const FAMILY: [Colour; 5] = [
    Colour(25, 25, 60),
    Colour(90, 20, 110),
    Colour(150, 45, 40),
    Colour(135, 105, 20),
    Colour(110, 145, 60),
];
/// The position of the parameter set itself, in a picture over parameters.
pub const HERE: Colour = Colour(200, 0, 90);
/// Frames, stops, impacts, exact values.
pub const BLACK: Colour = Colour(0, 0, 0);
/// Grids, captions, unstable areas.
pub const GREY: Colour = Colour(140, 140, 140);
/// The background.
pub const WHITE: Colour = Colour(255, 255, 255);

/// Areas (Okabe and Ito's colours), first choice.
pub const BLUE: Colour = Colour(0, 114, 178);
/// Areas, second choice.
pub const VERMILLION: Colour = Colour(213, 94, 0);
/// Areas, third choice.
pub const PURPLE: Colour = Colour(204, 121, 167);
/// Areas, fourth choice.
pub const ORANGE: Colour = Colour(230, 159, 0);
/// Areas, light.
pub const SKY: Colour = Colour(86, 180, 233);
