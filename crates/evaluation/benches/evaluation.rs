//! All methods of a session against its test segments.

fn main() {
    divan::main();
}
