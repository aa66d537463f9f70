//! Elementary functions that give the same bits on every target.
//!
//! `f64::sin` and its kin differ in the last place between native code and WebAssembly; these do
//! not, and `clippy.toml` bans the others. `f64::sqrt`, `abs`, `floor`, `ceil`, `round` are exact
//! everywhere and used directly.

pub use libm::{acos, asin, atan, atan2, cbrt, cos, exp, hypot, log as ln, pow as powf, sin, tan};

/// `acos` of a cosine that rounding may have pushed past ±1.
pub fn acos_clamped(cosine: f64) -> f64 {
    acos(cosine.clamp(-1.0, 1.0))
}
