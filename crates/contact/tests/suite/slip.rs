//! Slip of pads over the object; `../reference/make_events.py` made the numbers.

use inhand_contact::slip_m;
use inhand_model::{Finger, Position, Shape};

use crate::events::{of_reference, pads, recorded};

#[test]
fn slip_agrees_with_the_reference() {
    for take in &recorded() {
        let edges: Vec<f64> = serde_json::from_value(take["edges_m"].clone()).unwrap();
        let shape = Shape::Cuboid {
            edges_m: edges.try_into().unwrap(),
        };
        let (series, pads) = (of_reference(take), pads(take));
        for finger in Finger::ALL {
            let pad: Vec<_> = pads.iter().map(|pads| pads[finger]).collect();
            let contacts = series.contacts(finger);
            let expected = take["slip"][finger.index()].as_array().unwrap();
            assert_eq!(contacts.len(), expected.len());
            for (contact, expected) in contacts.iter().zip(expected) {
                let found = slip_m(&shape, &pad[contact.samples.clone()]);
                match expected.as_f64() {
                    Some(expected) => assert!((found.unwrap() - expected).abs() < 1e-12),
                    None => assert_eq!(found, None),
                }
            }
        }
    }
}

/// Around the side of a cylinder by a quarter: the chord; how deep the pad is pressed in changes nothing.
#[test]
fn slip_around_a_cylinder_is_its_chord() {
    let cylinder: Shape = "cylinder:0.05x0.08".parse().unwrap();
    let pad: Vec<_> = (0..=90)
        .map(|k| {
            let (angle, depth_m) = (f64::from(k).to_radians(), 0.001 * f64::from(k % 5));
            let radius_m = 0.026 - depth_m;
            Some(Position::new(
                radius_m * angle.cos(),
                radius_m * angle.sin(),
                -0.01,
            ))
        })
        .collect();
    let found = slip_m(&cylinder, &pad).unwrap();
    assert!((found - 0.025 * 2.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn what_was_not_seen_has_no_slip() {
    let cube: Shape = "cube:0.05".parse().unwrap();
    let pad = [Some(Position::new(0.0, 0.0, 0.03)); 3];
    assert_eq!(slip_m(&cube, &pad), Some(0.0));
    assert_eq!(slip_m(&cube, &pad[..1]), None);
    assert_eq!(slip_m(&cube, &[]), None);
    let gaps = [
        pad[0],
        None,
        pad[0],
        Some(Position::new(f64::NAN, 0.0, 0.0)),
    ];
    assert_eq!(slip_m(&cube, &gaps), None);
}
