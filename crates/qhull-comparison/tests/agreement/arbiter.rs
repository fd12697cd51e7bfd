//! Who is right when engine and Qhull differ: support values in twice the precision, and what a
//! hyperplane touches.

use graspd_core::wrench::Wrench;
use num_rational::BigRational;
use num_traits::ToPrimitive;

/// How a hyperplane stands to a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Touches the set in a facet: what it touches spans five dimensions.
    Facet,
    /// Touches it in less, as far as double precision can resolve.
    Ridge,
    /// Has wrenches beyond the offset claimed for it.
    Beyond,
}

/// h(u)/‖u‖, the products summed without rounding errors.
pub fn support(wrenches: &[Wrench], u: &Wrench) -> f64 {
    let heights = wrenches.iter().map(|w| dot(w, u));
    heights.fold(f64::NEG_INFINITY, f64::max) / dot(u, u).sqrt()
}

/// As [`support`], in rational arithmetic up to the one division by ‖u‖.
pub fn exact_support(wrenches: &[Wrench], u: &Wrench) -> f64 {
    let exact = |x: &f64| BigRational::from_float(*x).expect("a finite number");
    let product = |w: &Wrench| {
        let products = w.iter().zip(u.iter()).map(|(a, b)| exact(a) * exact(b));
        products.sum::<BigRational>()
    };
    let greatest = wrenches.iter().map(product).max();
    let rounded = greatest.and_then(|height| height.to_f64());
    rounded.expect("some wrenches") / dot(u, u).sqrt()
}

/// What the hyperplane with normal `u` at the distance `offset` touches, within `slack`.
pub fn side(wrenches: &[Wrench], u: &Wrench, offset: f64, slack: f64) -> Side {
    let top = support(wrenches, u);
    if top > offset + slack {
        return Side::Beyond;
    }
    let touched: Vec<&Wrench> = wrenches
        .iter()
        .filter(|w| dot(w, u) / u.norm() >= top - slack)
        .collect();
    let edges = nalgebra::Matrix6xX::from_iterator(
        touched.len(),
        touched
            .iter()
            .flat_map(|w| (*w - touched[0]).iter().copied().collect::<Vec<_>>()),
    );
    let longest = wrenches.iter().map(|w| w.norm()).fold(0.0, f64::max);
    let values = edges.svd(false, false).singular_values;
    // The direction of a plane through points that spread by s is uncertain by 2⁻⁵²/s.
    let spread = values.iter().filter(|v| **v > 1e-6 * longest).count();
    if spread >= 5 {
        Side::Facet
    } else {
        Side::Ridge
    }
}

/// a·b with an error of one rounding: each product and each sum is split into its rounded value and
/// the exact rest (Ogita, Rump & Oishi 2005).
fn dot(a: &Wrench, b: &Wrench) -> f64 {
    let (mut sum, mut rest) = (0.0_f64, 0.0_f64);
    for (x, y) in a.iter().zip(b.iter()) {
        let product = x * y;
        let lost = x.mul_add(*y, -product);
        let next = sum + product;
        let back = next - sum;
        rest += (sum - (next - back)) + (product - back) + lost;
        sum = next;
    }
    sum + rest
}
