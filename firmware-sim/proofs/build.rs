//! Link arguments of the programs.

fn main() {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
}
