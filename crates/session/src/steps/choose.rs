//! Choosing a method by how well each does on training takes left out of learning.

use inhand_dictionary::{Fold, folds, mean, mean_distance_m, standard_error};
use inhand_model::{Demonstrated, Dictionary, MethodCandidate, MethodChoice, Protocol, Segments};

use super::{Generator, learn};
use crate::error::{SessionError, invalid};
use crate::methods::Method;
use crate::settings::Settings;

/// Mean error of each left-out segment, by method.
struct Errors {
    methods: Vec<Method>,
    /// One list a method, metres; infinite where a method found no motion.
    by_segment_m: Vec<Vec<f64>>,
}

/// Learns the dictionary and, where the settings name `auto` among the methods, compares all of
/// them under the held-out protocol.
///
/// # Errors
///
/// As [`learn`] and [`choose_method`].
pub fn learn_and_choose(
    train: &Segments,
    held_out: &Segments,
    demonstrated: Demonstrated,
    settings: &Settings,
) -> Result<Dictionary, SessionError> {
    let choice = choice(held_out, &demonstrated, settings)?;
    Ok(Dictionary {
        choice,
        ..learn(train, held_out, demonstrated, settings)?
    })
}

/// Compares the methods on these segments where the settings name `auto`.
///
/// # Errors
///
/// As [`choose_method`].
pub fn choice(
    demonstrations: &Segments,
    demonstrated: &Demonstrated,
    settings: &Settings,
) -> Result<Option<MethodChoice>, SessionError> {
    (settings.plan.methods.contains(&Method::Auto))
        .then(|| choose_method(demonstrations, demonstrated, &Method::ALL, settings))
        .transpose()
}

/// The methods of the settings with `auto` replaced by the one that was chosen when the dictionary
/// was learned.
///
/// # Errors
///
/// [`SessionError::Settings`] for `auto` with a dictionary that was learned without comparing.
pub fn settled_methods(
    dictionary: &Dictionary,
    settings: &Settings,
) -> Result<Vec<Method>, SessionError> {
    let mut settled = Vec::new();
    for &method in &settings.plan.methods {
        let method = match (method, &dictionary.choice) {
            (Method::Auto, Some(choice)) => choice.method.parse()?,
            (Method::Auto, None) => {
                let expected = "a method by name, or a dictionary that was learned with \
                                `--methods auto`";
                return Err(invalid("plan.methods", expected, &"auto"));
            }
            (method, _) => method,
        };
        if !settled.contains(&method) {
            settled.push(method);
        }
    }
    Ok(settled)
}

/// Compares methods on the training takes: each group of takes in turn is left out, everything is
/// learned from the others, and the left-out segments are planned. The method with the smallest
/// mean error (over segments, fingers and instants) is chosen, but a learned one only if it is better
/// than the best that learns nothing by more than the standard error of the difference. All is learned from the given
/// segments and judged under their protocol. Velocity
/// bounds and hulls are those of all training takes.
///
/// # Errors
///
/// [`SessionError`] as for learning and planning; [`SessionError::Settings`] where there is too
/// little training data to leave any of it out.
pub fn choose_method(
    train: &Segments,
    demonstrated: &Demonstrated,
    candidates: &[Method],
    settings: &Settings,
) -> Result<MethodChoice, SessionError> {
    let folds = folds(train.origins(), train.layout().samples);
    if folds.is_empty() {
        return Err(invalid(
            "plan.methods",
            "a method by name, as there is too little training data to leave any out for `auto`",
            &"auto",
        ));
    }
    let mut errors = Errors {
        methods: candidates.to_vec(),
        by_segment_m: vec![Vec::new(); candidates.len()],
    };
    for fold in &folds {
        add_fold(&mut errors, train, fold, demonstrated, settings)?;
    }
    Ok(MethodChoice {
        protocol: train.protocol(),
        ..errors.choice(folds.len())
    })
}

fn add_fold(
    errors: &mut Errors,
    train: &Segments,
    fold: &Fold,
    demonstrated: &Demonstrated,
    settings: &Settings,
) -> Result<(), SessionError> {
    let known = train.select(&fold.known);
    let left_out = train.select(&fold.left_out);
    let mut fewer = settings.clone();
    // What is left may support fewer primitives than everything does.
    fewer.learn.rank = (settings.learn.rank).filter(|&rank| rank < known.len());
    // One set of deviations serves: they are learned under the protocol of the segments.
    let none = known.select(&[]);
    let dictionary = learn(&known, &none, demonstrated.clone(), &fewer)?;
    for (method, list) in errors.methods.iter().zip(&mut errors.by_segment_m) {
        let generator = Generator::new(*method, &dictionary, left_out.protocol(), settings)?;
        let generated = generator.generate(&left_out)?;
        for (segment, trajectory) in generated.trajectories.iter().enumerate() {
            let recorded_m = left_out.fingertips_m(segment);
            list.push(trajectory.as_ref().map_or(f64::INFINITY, |trajectory| {
                mean_distance_m(recorded_m, trajectory.values_m())
            }));
        }
    }
    Ok(())
}

impl Errors {
    fn choice(&self, folds: usize) -> MethodChoice {
        let means: Vec<f64> = self.by_segment_m.iter().map(|list| mean(list)).collect();
        let best = |learned: bool| {
            let of_kind = (0..means.len()).filter(|&i| self.methods[i].is_learned() == learned);
            of_kind.min_by(|&a, &b| means[a].total_cmp(&means[b]))
        };
        let candidates = (self.methods.iter().zip(&means))
            .map(|(method, &mean_error_m)| MethodCandidate {
                name: method.name().to_owned(),
                mean_error_m,
            })
            .collect();
        let (chosen, gain) = match (best(true), best(false)) {
            (Some(learned), Some(plain)) => {
                let (gain_m, error_m) = self.gain(learned, plain);
                let chosen = if gain_m > error_m { learned } else { plain };
                (chosen, Some((gain_m, error_m)))
            }
            (learned, plain) => (learned.or(plain).unwrap_or(0), None),
        };
        let segments = self.by_segment_m.first().map_or(0, Vec::len);
        MethodChoice {
            protocol: Protocol::Published,
            method: self.methods[chosen].name().to_owned(),
            candidates,
            gain_m: gain.map(|(gain_m, _)| gain_m),
            gain_standard_error_m: gain.map(|(_, error_m)| error_m),
            folds,
            segments,
        }
    }

    /// How much smaller the first method's error is than the second's, with its standard error over
    /// segments, metres.
    fn gain(&self, one: usize, other: usize) -> (f64, f64) {
        let gains: Vec<f64> = (self.by_segment_m[one].iter().zip(&self.by_segment_m[other]))
            .map(|(one, other)| other - one)
            .collect();
        (mean(&gains), standard_error(&gains))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chosen(residual: &[f64], hermite: &[f64]) -> MethodChoice {
        Errors {
            methods: vec![Method::Residual, Method::Hermite],
            by_segment_m: vec![residual.to_vec(), hermite.to_vec()],
        }
        .choice(2)
    }

    #[test]
    fn a_learned_method_has_to_be_better_than_chance() {
        let choice = chosen(&[1e-3, 2e-3, 3e-3, 4e-3], &[2e-3, 3e-3, 4e-3, 5.1e-3]);
        assert_eq!(choice.method, "residual");
        assert!((choice.gain_m.unwrap() - 1.025e-3).abs() < 1e-12);
        // Better on average, by one segment.
        let choice = chosen(&[3e-3, 3e-3, 3e-3, 0.0], &[2e-3, 2e-3, 2e-3, 4e-3]);
        assert!(choice.gain_m.unwrap() > 0.0);
        assert_eq!(choice.method, "hermite");
        // A plan that failed.
        let choice = chosen(&[0.0, f64::INFINITY], &[1e-3, 1e-3]);
        assert_eq!(choice.method, "hermite");
    }
}
