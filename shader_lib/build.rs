//! Embedding notices changed modules by itself, but not new ones: this does.

fn main() {
    println!("cargo::rerun-if-changed=.");
}
