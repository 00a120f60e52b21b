//! No C start-up code: the program starts at its own `_start`. `memcpy` comes from libc.

fn main() {
    println!("cargo:rustc-link-arg-bins=-nostartfiles");
    println!("cargo:rustc-link-arg-bins=-lc");
}
