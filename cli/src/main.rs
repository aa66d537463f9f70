//! The `evencut` command: arguments → core → files, exit codes.

fn main() {}
