//! The boxes and scores in what a model answers, by its output format.

use crate::error::ModelError;
use crate::settings::{BoxUnit, InputSettings, OutputOrder, OutputSettings, ScoreFunction};

/// Most boxes that a model may answer for a picture.
const MAX_BOXES: usize = 100_000;

/// One output of a model: its shape and its values.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Output<'a> {
    pub(crate) shape: &'a [usize],
    pub(crate) values: &'a [f32],
}

/// A box with its class, in the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Decoded {
    /// Centre, width and height, pixels of the input.
    pub(crate) bounds: [f64; 4],
    pub(crate) class: usize,
    pub(crate) score: f32,
}

/// Where the numbers of each box stand in the outputs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decoder {
    format: OutputSettings,
    classes: usize,
    sides: [f64; 2],
    boxes: usize,
}

impl Decoder {
    /// A decoder of outputs of these shapes.
    ///
    /// # Errors
    /// If the shapes do not fit the settings.
    pub(crate) fn new(
        format: &OutputSettings,
        classes: usize,
        input: &InputSettings,
        outputs: &[Output<'_>],
    ) -> Result<Self, ModelError> {
        let values = values_of_box(format, classes);
        let boxes = match (format, outputs) {
            (OutputSettings::Yolo { order, .. }, [Output { shape: [1, first, second], .. }]) => {
                let (found, boxes) = match order {
                    OutputOrder::ValuesFirst => (first, second),
                    OutputOrder::BoxesFirst => (second, first),
                };
                (*found == values).then_some(*boxes)
            }
            (
                OutputSettings::Detr { .. },
                [Output { shape: [1, logits, found], .. }, Output { shape: [1, boxes, 4], .. }],
            ) => (*found == values && logits == boxes).then_some(*boxes),
            _ => None,
        };
        let Some(boxes) = boxes else {
            let answered: Vec<_> = outputs.iter().map(|output| format!("{:?}", output.shape)).collect();
            let expected = match format {
                OutputSettings::Yolo { order: OutputOrder::ValuesFirst, .. } => format!("[1, {values}, N]"),
                OutputSettings::Yolo { order: OutputOrder::BoxesFirst, .. } => format!("[1, N, {values}]"),
                OutputSettings::Detr { .. } => format!("logits of [1, N, {values}] and boxes of [1, N, 4]"),
            };
            return Err(ModelError::Outputs { answered: answered.join(" and "), expected });
        };
        if boxes > MAX_BOXES {
            return Err(ModelError::TooManyBoxes { boxes, most: MAX_BOXES });
        }
        let sides = [input.width as f64, input.height as f64];
        Ok(Self { format: format.clone(), classes, sides, boxes })
    }

    /// The number of boxes.
    pub(crate) const fn boxes(&self) -> usize {
        self.boxes
    }

    /// Adds the boxes whose score is at least this, and returns how many have a number that is not finite.
    pub(crate) fn decode(&self, outputs: &[Output<'_>], least: f32, found: &mut Vec<Decoded>) -> usize {
        let mut scores = Vec::with_capacity(self.classes + 1);
        let mut not_finite = 0;
        for index in 0..self.boxes {
            scores.clear();
            let bounds = self.read(outputs, index, &mut scores);
            let values = bounds.iter().map(|value| *value as f32).chain(scores.iter().copied());
            if values.into_iter().any(|value| !value.is_finite()) {
                not_finite += 1;
                continue;
            }
            let best = scores.iter().enumerate().max_by(|(_, one), (_, other)| one.total_cmp(other));
            if let Some((class, &score)) = best.filter(|(_, score)| **score >= least) {
                found.push(Decoded { bounds, class, score: score.clamp(0.0, 1.0) });
            }
        }
        not_finite
    }

    /// The box of an index in pixels of the input, and the scores of the classes.
    fn read(&self, outputs: &[Output<'_>], index: usize, scores: &mut Vec<f32>) -> [f64; 4] {
        let value = |output: usize, at: usize| {
            outputs.get(output).and_then(|output| output.values.get(at)).copied().unwrap_or(f32::NAN)
        };
        match &self.format {
            OutputSettings::Yolo { order, objectness, boxes, scores: function } => {
                let count = values_of_box(&self.format, self.classes);
                let at = |row: usize| match order {
                    OutputOrder::ValuesFirst => value(0, row * self.boxes + index),
                    OutputOrder::BoxesFirst => value(0, index * count + row),
                };
                scores.extend((count - self.classes..count).map(at));
                function.apply(scores);
                if *objectness {
                    let mut object = [at(4)];
                    function.apply(&mut object);
                    scores.iter_mut().for_each(|score| *score *= object[0]);
                }
                let bounds = [0, 1, 2, 3].map(|row| f64::from(at(row)));
                match boxes {
                    BoxUnit::Pixels => bounds,
                    BoxUnit::Shares => self.in_pixels(bounds),
                }
            }
            OutputSettings::Detr { scores: function } => {
                let count = values_of_box(&self.format, self.classes);
                scores.extend((0..count).map(|class| value(0, index * count + class)));
                function.apply(scores);
                scores.truncate(self.classes);
                self.in_pixels([0, 1, 2, 3].map(|side| f64::from(value(1, 4 * index + side))))
            }
        }
    }

    fn in_pixels(&self, [x, y, w, h]: [f64; 4]) -> [f64; 4] {
        let [width, height] = self.sides;
        [x * width, y * height, w * width, h * height]
    }
}

/// Numbers of one box in the output with the scores.
fn values_of_box(format: &OutputSettings, classes: usize) -> usize {
    match format {
        OutputSettings::Yolo { objectness, .. } => 4 + usize::from(*objectness) + classes,
        OutputSettings::Detr { scores } => classes + usize::from(*scores == ScoreFunction::Softmax),
    }
}

impl ScoreFunction {
    fn apply(self, values: &mut [f32]) {
        match self {
            Self::None => {}
            Self::Sigmoid => values.iter_mut().for_each(|value| *value = 1.0 / (1.0 + libm::expf(-*value))),
            Self::Softmax => {
                let largest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                values.iter_mut().for_each(|value| *value = libm::expf(*value - largest));
                let sum: f32 = values.iter().sum();
                values.iter_mut().for_each(|value| *value /= sum);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    /// Decodes with an input of 100 x 50 pixels and the classes a and b.
    fn decode(output: &str, outputs: &[Output<'_>], least: f32) -> Result<(Vec<Decoded>, usize), ModelError> {
        let text =
            format!("classes = [\"a\", \"b\"]\n[input]\nwidth = 100\nheight = 50\n[output]\n{output}\n");
        let settings = Settings::from_toml(&text).unwrap();
        let decoder = Decoder::new(&settings.output, settings.classes.len(), &settings.input, outputs)?;
        let mut found = Vec::new();
        let not_finite = decoder.decode(outputs, least, &mut found);
        Ok((found, not_finite))
    }

    fn output<'a>(shape: &'a [usize], values: &'a [f32]) -> Output<'a> {
        assert_eq!(shape.iter().product::<usize>(), values.len());
        Output { shape, values }
    }

    const BOX: [f64; 4] = [10.0, 20.0, 4.0, 8.0];

    #[test]
    fn yolo_in_both_orders() {
        let boxes_first = [10.0, 20.0, 4.0, 8.0, 0.25, 0.75, 0.0, 0.0, 1.0, 1.0, 0.125, 0.25];
        let values_first = [10.0, 0.0, 20.0, 0.0, 4.0, 1.0, 8.0, 1.0, 0.25, 0.125, 0.75, 0.25];
        let expected = vec![Decoded { bounds: BOX, class: 1, score: 0.75 }];
        let found = decode("format = \"yolo\"", &[output(&[1, 6, 2], &values_first)], 0.5);
        assert_eq!(found, Ok((expected.clone(), 0)));
        let order = "format = \"yolo\"\norder = \"boxes-first\"";
        assert_eq!(decode(order, &[output(&[1, 2, 6], &boxes_first)], 0.5), Ok((expected, 0)));
    }

    #[test]
    fn objectness_is_a_factor_of_the_scores() {
        let keys = "format = \"yolo\"\norder = \"boxes-first\"\nobjectness = true\nboxes = \"shares\"";
        let values = [0.1, 0.4, 0.04, 0.16, 0.5, 1.0, 0.25];
        let (found, _) = decode(keys, &[output(&[1, 1, 7], &values)], 0.1).unwrap();
        assert_eq!((found[0].class, found[0].score), (0, 0.5));
        for (side, expected) in found[0].bounds.iter().zip(BOX) {
            assert!((side - expected).abs() < 1e-5, "{found:?}");
        }
    }

    #[test]
    fn detr_leaves_out_the_logit_of_no_object() {
        let logits = [0.0, 2.0, 0.0, 0.0, 0.0, 9.0];
        let boxes = [0.5, 0.5, 0.25, 0.5, 0.5, 0.5, 1.0, 1.0];
        let outputs = [output(&[1, 2, 3], &logits), output(&[1, 2, 4], &boxes)];
        let (found, _) = decode("format = \"detr\"", &outputs, 0.5).unwrap();
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].bounds, found[0].class), ([50.0, 25.0, 25.0, 25.0], 1));
        // e^2 / (e^2 + 2).
        assert!((found[0].score - 0.786_986).abs() < 1e-5, "{found:?}");
        let sigmoid = "format = \"detr\"\nscores = \"sigmoid\"";
        let outputs = [output(&[1, 3, 2], &logits), output(&[1, 3, 4], &[0.5; 12])];
        let (found, _) = decode(sigmoid, &outputs, 0.9).unwrap();
        assert_eq!(found.iter().map(|found| found.class).collect::<Vec<_>>(), [1]);
    }

    #[test]
    fn what_is_not_finite_is_left_out_and_counted() {
        let values = [1.0, 1.0, 1.0, 1.0, f32::NAN, 0.9, f32::INFINITY, 1.0, 1.0, 1.0, 0.9, 0.1];
        let keys = "format = \"yolo\"\norder = \"boxes-first\"";
        assert_eq!(decode(keys, &[output(&[1, 2, 6], &values)], 0.5), Ok((Vec::new(), 2)));
        let logits = [f32::INFINITY, 0.0, 0.0];
        let outputs = [output(&[1, 1, 3], &logits), output(&[1, 1, 4], &[0.5; 4])];
        assert_eq!(decode("format = \"detr\"", &outputs, 0.5), Ok((Vec::new(), 1)));
    }

    #[test]
    fn outputs_that_do_not_fit_are_refused_with_their_shapes() {
        let error = |keys: &str, outputs: &[Output<'_>]| decode(keys, outputs, 0.5).unwrap_err().to_string();
        let values = [0.0; 12];
        let text = error("format = \"yolo\"", &[output(&[1, 2, 6], &values)]);
        assert!(text.contains("[1, 2, 6], but the settings make [1, 6, N]"), "{text}");
        let text = error("format = \"detr\"", &[output(&[1, 2, 6], &values)]);
        assert!(text.contains("logits of [1, N, 3] and boxes of [1, N, 4]"), "{text}");
        let many = vec![0.0; 6 * (MAX_BOXES + 1)];
        let text = error("format = \"yolo\"", &[output(&[1, 6, MAX_BOXES + 1], &many)]);
        assert!(text.contains("100001 boxes"), "{text}");
    }
}
