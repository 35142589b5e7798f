//! Messages of ROS 2 in CDR, and of ROS 1, a module for each package.

mod cdr;
mod geometry;
mod mocap4r2;
mod tf;

use self::cdr::Cdr;
use crate::reading::{
    self, Fault, Item, Kind, Label, MessageKind, Reading, Readings, Stored, nanos,
};

/// Message kinds by package.
pub(super) const PACKAGES: &[&[MessageKind]] = &[geometry::KINDS, mocap4r2::KINDS, tf::KINDS];

/// Encodings of ROS 2 and of ROS 1.
const ROS: &[&str] = &["cdr", cdr::ROS1];

/// Decodes a message, all of it.
fn decode<'a>(
    message: Stored<'a>,
    read: impl FnOnce(&mut Cdr<'a>) -> Readings<'a>,
) -> Readings<'a> {
    let mut cdr = Cdr::new(message)?;
    let readings = read(&mut cdr)?;
    cdr.end()?;
    Ok(readings)
}

/// Decodes a message that is a header and one item.
fn one<'a>(
    message: Stored<'a>,
    item: impl FnOnce(&mut Cdr<'a>) -> Result<Item<'a>, Fault>,
) -> Readings<'a> {
    decode(message, |cdr| {
        let mut reading = header(cdr)?;
        reading.items.push(item(cdr)?);
        Ok(vec![reading])
    })
}

fn limited(count: usize) -> Result<usize, Fault> {
    reading::limited(count, "markers or bodies")
}

/// A header and no items yet.
fn header<'a>(cdr: &mut Cdr<'a>) -> Result<Reading<'a>, Fault> {
    if cdr.is_ros1() {
        cdr.u32()?; // Counts messages.
    }
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    Ok(Reading {
        stamp_nanos: nanos(seconds.into(), nanoseconds.into()),
        frame: cdr.text()?,
        items: Vec::new(),
    })
}

fn pose<'a>(cdr: &mut Cdr<'a>, label: Label<'a>, kind: Kind) -> Result<Item<'a>, Fault> {
    Ok(Item {
        label,
        kind,
        position: cdr.f64s()?,
        rotation: cdr.f64s()?,
    })
}

fn point<'a>(cdr: &mut Cdr<'a>, label: Label<'a>, kind: Kind) -> Result<Item<'a>, Fault> {
    Ok(Item {
        label,
        kind,
        position: cdr.f64s()?,
        rotation: [0.0; 4],
    })
}
