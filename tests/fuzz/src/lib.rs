//! Parts that fuzz targets share.

pub mod capture;
pub mod documents;
pub mod files;
pub mod mutate;

/// Most bytes that a record may unpack to here: hostile lengths must be refused by this limit.
const MEMORY_LIMIT: u64 = 64 << 20;

/// Which of `n` checks takes its turn with an input, where all of them would take too long: the same at every run.
pub fn turn(bytes: &[u8], n: u32) -> u32 {
    crc32fast::hash(bytes) % n
}

/// Prepares the process: one thread, so that a target is quick and its findings can be repeated.
///
/// # Panics
///
/// Where the pool of threads is there already.
pub fn start() {
    inhand_container::set_memory_limit(MEMORY_LIMIT);
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .use_current_thread()
        .build_global()
        .expect("the first pool");
}
