//! Slip of pads over the object; `../reference/make_events.py` made the numbers.

use inhand_contact::events::Contact;
use inhand_contact::slip::slip;
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
            let contacts = series.finger(finger).contacts;
            let expected = take["slip"][finger.index()].as_array().unwrap();
            assert_eq!(contacts.len(), expected.len());
            for (contact, expected) in contacts.iter().zip(expected) {
                let found = slip(&shape, &pad, contact, series.rate_hz());
                let Some(expected) = expected.as_array() else {
                    assert_eq!(found, None);
                    continue;
                };
                let s = found.unwrap();
                let found = [
                    s.displacement_m,
                    s.excursion_m,
                    s.path_m,
                    s.peak_speed_m_s,
                    s.mean_speed_m_s,
                    s.steps as f64,
                    s.missing as f64,
                ];
                for (found, expected) in found.iter().zip(expected) {
                    assert!((found - expected.as_f64().unwrap()).abs() < 1e-12, "{s:?}");
                }
            }
        }
    }
}

/// Around the side of a cylinder by a quarter: the chord and, in small steps, the arc; how deep the pad is
/// pressed in changes nothing.
#[test]
fn slip_around_a_cylinder_is_its_arc() {
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
    let contact = Contact {
        samples: 0..91,
        made: true,
        broken: true,
    };
    let found = slip(&cylinder, &pad, &contact, 90.0).unwrap();
    assert!((found.displacement_m - 0.025 * 2.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(found.excursion_m, found.displacement_m);
    let arc_m = 90.0 * 2.0 * 0.025 * 0.5_f64.to_radians().sin();
    assert!((found.path_m - arc_m).abs() < 1e-12);
    assert!((found.mean_speed_m_s - arc_m).abs() < 1e-12);
    assert!((found.peak_speed_m_s - arc_m).abs() < 1e-9);
}

#[test]
fn what_was_not_seen_has_no_slip() {
    let cube: Shape = "cube:0.05".parse().unwrap();
    let pad = [Some(Position::new(0.0, 0.0, 0.03)); 3];
    let contact = |samples| Contact {
        samples,
        made: true,
        broken: true,
    };
    assert_eq!(slip(&cube, &pad, &contact(1..4), 100.0), None);
    assert_eq!(slip(&cube, &pad, &contact(1..2), 100.0), None);
    assert_eq!(slip(&cube, &pad, &contact(0..3), 0.0), None);
    let gaps = [
        pad[0],
        None,
        pad[0],
        Some(Position::new(f64::NAN, 0.0, 0.0)),
    ];
    assert_eq!(slip(&cube, &gaps, &contact(0..4), 100.0), None);
}
