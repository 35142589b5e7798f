//! The messages of `schemas/inhand`, generated, and how the nouns' enums stand in them.

// Generated for a public module; here everything stays inside the crate.
#![expect(
    unreachable_pub,
    reason = "generated code is public; the module is not"
)]

include!("generated/inhand.rs");

use inhand_model as model;

impl From<model::Status> for Status {
    fn from(status: model::Status) -> Self {
        match status {
            model::Status::Measured => Status::Measured,
            model::Status::Filled => Status::Filled,
            model::Status::Missing => Status::Missing,
        }
    }
}

impl Status {
    /// The noun, unless the number is none of ours.
    pub(crate) fn to_model(number: i32) -> Option<model::Status> {
        match Status::try_from(number).ok()? {
            Status::Unspecified => None,
            Status::Measured => Some(model::Status::Measured),
            Status::Filled => Some(model::Status::Filled),
            Status::Missing => Some(model::Status::Missing),
        }
    }
}

impl From<model::PlanStatus> for PlanStatus {
    fn from(status: model::PlanStatus) -> Self {
        match status {
            model::PlanStatus::Solved => PlanStatus::Solved,
            model::PlanStatus::AlmostSolved => PlanStatus::AlmostSolved,
            model::PlanStatus::Infeasible => PlanStatus::Infeasible,
            model::PlanStatus::Failed => PlanStatus::Failed,
        }
    }
}

impl From<model::ConstraintFamily> for ConstraintFamily {
    fn from(family: model::ConstraintFamily) -> Self {
        match family {
            model::ConstraintFamily::Targets => ConstraintFamily::Targets,
            model::ConstraintFamily::TargetVelocities => ConstraintFamily::TargetVelocities,
            model::ConstraintFamily::Activations => ConstraintFamily::Activations,
            model::ConstraintFamily::Velocity => ConstraintFamily::Velocity,
            model::ConstraintFamily::Acceleration => ConstraintFamily::Acceleration,
            model::ConstraintFamily::Reachability => ConstraintFamily::Reachability,
            model::ConstraintFamily::Separation => ConstraintFamily::Separation,
            model::ConstraintFamily::Holding => ConstraintFamily::Holding,
        }
    }
}

impl ConstraintFamily {
    /// The noun, unless the number is none of ours.
    pub(crate) fn to_model(number: i32) -> Option<model::ConstraintFamily> {
        let family = ConstraintFamily::try_from(number).ok()?;
        (model::ConstraintFamily::ALL.into_iter())
            .find(|&noun| ConstraintFamily::from(noun) == family)
    }
}

impl From<model::DictionaryKind> for DictionaryKind {
    fn from(kind: model::DictionaryKind) -> Self {
        match kind {
            model::DictionaryKind::Nmf => DictionaryKind::Nmf,
            model::DictionaryKind::Pca => DictionaryKind::Pca,
        }
    }
}

impl DictionaryKind {
    /// The noun, unless the number is none of ours.
    pub(crate) fn to_model(number: i32) -> Option<model::DictionaryKind> {
        match DictionaryKind::try_from(number).ok()? {
            DictionaryKind::Unspecified => None,
            DictionaryKind::Nmf => Some(model::DictionaryKind::Nmf),
            DictionaryKind::Pca => Some(model::DictionaryKind::Pca),
        }
    }
}

impl From<model::StopReason> for StopReason {
    fn from(reason: model::StopReason) -> Self {
        match reason {
            model::StopReason::Converged => StopReason::Converged,
            model::StopReason::TargetReached => StopReason::TargetReached,
            model::StopReason::IterationLimit => StopReason::IterationLimit,
            model::StopReason::ClosedForm => StopReason::ClosedForm,
        }
    }
}

impl StopReason {
    /// The noun, unless the number is none of ours.
    pub(crate) fn to_model(number: i32) -> Option<model::StopReason> {
        match StopReason::try_from(number).ok()? {
            StopReason::Unspecified => None,
            StopReason::Converged => Some(model::StopReason::Converged),
            StopReason::TargetReached => Some(model::StopReason::TargetReached),
            StopReason::IterationLimit => Some(model::StopReason::IterationLimit),
            StopReason::ClosedForm => Some(model::StopReason::ClosedForm),
        }
    }
}
