//! Metrics of trials.
//!
//! The paper's sensitivity s = h/b (`biswas2017`, equation 2) is defined in words and a figure only. The
//! definition here is a reconstruction: an *excursion* is a maximal run of rows with P > 1, *complete* when
//! the log continues after it; h is the largest P in it minus 1, b its duration in seconds; a trial's s is
//! the mean of h/b over its complete excursions; the s of several trials is the mean of s. On the 30
//! laboratory logs it gives 0.6055 and 0.4535 where the paper has 0.6045 and 0.4536.

mod mean;

pub mod excursion;

pub mod trial;

pub mod guidance;
pub mod perception;

pub mod summary;

pub use excursion::{Excursion, find_excursions};
pub use guidance::GuidanceMetrics;
pub use perception::PerceptionMetrics;
pub use summary::{Arena, PUBLISHED_NORMALISED_SENSITIVITY, Summary, TrialEntry, summarise};
pub use trial::{TrialMetrics, measure};
