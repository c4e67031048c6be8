//! The one or two videos of a run: colour and thermal, wide and tele.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which of a run's videos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VideoNumber {
    /// The video that the pilot sees at the start.
    #[default]
    First,
    /// The second video, where there is one.
    Second,
}

impl VideoNumber {
    /// Both, in their order.
    pub const ALL: [Self; 2] = [Self::First, Self::Second];

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::First => Self::Second,
            Self::Second => Self::First,
        }
    }

    /// The number as people count, 1 or 2.
    pub const fn count(self) -> u8 {
        match self {
            Self::First => 1,
            Self::Second => 2,
        }
    }
}

/// Something for each video of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Videos<T> {
    /// Of the first video.
    pub first: T,
    /// Of the second one; `None`: there is none.
    pub second: Option<T>,
}

impl<T> Videos<T> {
    /// For a run with one video.
    pub const fn one(first: T) -> Self {
        Self { first, second: None }
    }

    /// That of a video; `None`: there is no such video.
    pub const fn get(&self, number: VideoNumber) -> Option<&T> {
        match number {
            VideoNumber::First => Some(&self.first),
            VideoNumber::Second => self.second.as_ref(),
        }
    }

    /// That of a video, mutable.
    pub const fn get_mut(&mut self, number: VideoNumber) -> Option<&mut T> {
        match number {
            VideoNumber::First => Some(&mut self.first),
            VideoNumber::Second => self.second.as_mut(),
        }
    }

    /// Each with its number.
    pub fn iter(&self) -> impl Iterator<Item = (VideoNumber, &T)> {
        VideoNumber::ALL.into_iter().filter_map(|number| Some((number, self.get(number)?)))
    }

    /// Both by reference.
    pub const fn as_ref(&self) -> Videos<&T> {
        Videos { first: &self.first, second: self.second.as_ref() }
    }

    /// Something else for each video.
    pub fn map<U>(self, mut make: impl FnMut(VideoNumber, T) -> U) -> Videos<U> {
        Videos {
            first: make(VideoNumber::First, self.first),
            second: self.second.map(|second| make(VideoNumber::Second, second)),
        }
    }

    /// Something else for each video.
    ///
    /// # Errors
    /// The first error of `make`.
    pub fn try_map<U, E>(self, mut make: impl FnMut(VideoNumber, T) -> Result<U, E>) -> Result<Videos<U>, E> {
        Ok(Videos {
            first: make(VideoNumber::First, self.first)?,
            second: self.second.map(|second| make(VideoNumber::Second, second)).transpose()?,
        })
    }
}
