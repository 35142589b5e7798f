//! Limit on the memory that hostile lengths may take.

use std::sync::atomic::{AtomicU64, Ordering};

/// Most bytes of memory that a record takes, or what one unpacks to; see [`set_memory_limit`].
static MEMORY_LIMIT: AtomicU64 = AtomicU64::new(512 << 20);

/// Most bytes of memory that a single record or unpacked chunk may take: a few hostile bytes may
/// unpack to gigabytes. 512 MiB unless set otherwise.
pub fn memory_limit() -> u64 {
    MEMORY_LIMIT.load(Ordering::Relaxed)
}

/// Sets the [`memory_limit`] of this process.
pub fn set_memory_limit(bytes: u64) {
    MEMORY_LIMIT.store(bytes, Ordering::Relaxed);
}
