//! Reports as their readers get them.

mod sample;
