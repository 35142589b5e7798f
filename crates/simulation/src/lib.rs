//! A simulated hand that turns an object in its fingers, with ground truth.
