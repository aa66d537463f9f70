//! Sparse symmetric linear systems, solved with the same bits on every target.
//!
//! A [`SymmetricMatrix`] is factored once by [`Cholesky`] under a fill-reducing order from
//! [`nested_dissection`] and then solved for any number of right-hand sides. All sums run in a
//! fixed order with plain multiplications and additions.

mod cholesky;
mod conjugate_gradients;
mod dense;
mod matrix;
mod ordering;
mod symbolic;

pub use cholesky::{Cholesky, NotPositiveDefinite};
pub use conjugate_gradients::conjugate_gradients;
pub use matrix::{Adjacency, SymmetricMatrix};
pub use ordering::nested_dissection;
