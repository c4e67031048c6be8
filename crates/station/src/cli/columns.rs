//! What the columns of the tables are that `trials`, `merge` and `metrics` print.

/// What the columns are, for the help of the commands that print the table.
pub(super) const COLUMNS: &str =
    "Columns of the table (an excursion: the boat is outside the ellipse, P > 1):
  time       length of the trial, s
  exc.       excursions: complete ones (the boat came back) / all
  out        time outside the ellipse, s; * the trial ends outside
  max P      largest P: 0 in the middle, 1 on the ellipse
  h          mean height of the complete excursions: largest P less 1
  b          mean duration of the complete excursions, s
  moves      how often the camera starts to move from rest
  switches   commands followed at once by another one, without rest. The paper's
             law holds one of four commands: a few a trial. The optimal law sets
             its rates anew with every picture: hundreds, most of them small
  travel     integral of |rate| over both axes, rad: how far the camera turns
  effort     integral of the squared rate over both axes, rad2/s: its energy
  s          sensitivity: mean of h/b over the complete excursions, 1/s; - none";

/// What the columns of trials in pixels are.
pub(super) const COLUMNS_IN_PIXELS: &str =
    "Columns of the second table, of trials in pixels (the tracker beside the truth):
  tracked    share of the time with a visible boat in which it is tracked, %
  blind      longest time with a visible boat that is not tracked, s
  wrong      share of the time with confidence >= 0.8 on a wrong place, %
  first      from the first picture to the first time tracked, s
  again      mean time to track a boat again that was out of sight, s
  sel.       selections";

/// What the columns of trials with guidance are.
pub(super) const COLUMNS_OF_GUIDANCE: &str =
    "Columns of the table of trials with guidance (since the boat goes by itself):
  arrived    whether the boat came within 4 m of the person
  time       until then, s
  off line   mean distance from the line from start to person, after 4 s, m
  rudder     sum of the rudder's changes until then; from stop to stop is 2
  closest    least distance to any person, m
  path       length of the path over that of the straight way
  in view    share of the time with boat and person in the picture, %";
