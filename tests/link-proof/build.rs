//! Links without C start-up code, because the program starts at its own `_start`. `memcpy` comes
//! from libc.

fn main() {
    println!("cargo:rustc-link-arg-bins=-nostartfiles");
    println!("cargo:rustc-link-arg-bins=-lc");
}
