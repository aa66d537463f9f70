//! A panic ends in an exit code and a message. In a process of its own, since the hook is global.

use evencut_cli::{Exit, guarded};

#[test]
fn a_panic_is_an_internal_error() {
    assert_eq!(guarded(|| panic!("a broken invariant")), Exit::Internal);
    assert_eq!(guarded(|| Exit::BadSurface), Exit::BadSurface);
}
