//! Hull and distances at the size of a session.

fn main() {
    divan::main();
}
