//! A loaded model: tract's plan of it, with the buffers of one inference.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use barrelman_vocab::video::Picture;
use tract_onnx::prelude::{
    Datum as _, Framework as _, InferenceModelExt as _, IntoRunnable as _, TValue, TVec, Tensor,
    TypedSimplePlan, tvec,
};
use tract_onnx::tract_hir::internal::{Factoid as _, InferenceFact};

use crate::decode::{Decoded, Decoder, Output};
use crate::error::ModelError;
use crate::preparation::prepare;
use crate::settings::Settings;
use crate::suppression::suppress;
use crate::{Object, Objects};

/// A model that finds objects.
pub struct Detector {
    settings: Settings,
    plan: Arc<TypedSimplePlan>,
    decoder: Decoder,
    values: Vec<f32>,
    decoded: Vec<Decoded>,
}

impl Detector {
    /// Loads a model in ONNX, and tries it on an input of zeros.
    ///
    /// # Errors
    /// If the model cannot be read or computed, or does not fit the settings.
    pub fn new(onnx: &[u8], settings: Settings) -> Result<Self, ModelError> {
        let plan = caught(|| load(onnx, &settings))??;
        let values = vec![0.0; settings.input.shape().iter().product()];
        let outputs = infer(&plan, &settings, &values)?;
        let classes = settings.classes.len();
        let mut decoded = Vec::new();
        let decoder = with_outputs(&outputs, |outputs| {
            let decoder = Decoder::new(&settings.output, classes, &settings.input, outputs)?;
            let not_finite = decoder.decode(outputs, settings.thresholds.score, &mut decoded);
            let is_number = not_finite < decoder.boxes().max(1);
            if is_number { Ok(decoder) } else { Err(ModelError::NotFinite(not_finite)) }
        })??;
        Ok(Self { settings, plan, decoder, values, decoded })
    }

    /// The settings.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Finds the objects in a picture.
    ///
    /// # Errors
    /// If the model cannot be computed.
    pub fn detect(&mut self, picture: &Picture) -> Result<Objects, ModelError> {
        let placement = prepare(picture, &self.settings.input, &mut self.values);
        let outputs = infer(&self.plan, &self.settings, &self.values)?;
        let (decoder, decoded) = (&self.decoder, &mut self.decoded);
        decoded.clear();
        let least = self.settings.thresholds.score;
        let not_finite = with_outputs(&outputs, |outputs| decoder.decode(outputs, least, decoded))?;
        let in_picture = |found: &Decoded| {
            let bounds = placement.in_picture(found.bounds).clipped(picture.size());
            (!bounds.is_empty()).then_some(Object { bounds, class: found.class, score: found.score })
        };
        let mut found: Vec<_> = decoded.iter().filter_map(in_picture).collect();
        suppress(&mut found, self.settings.thresholds.iou);
        Ok(Objects { found, not_finite })
    }
}

/// Calls what may panic on a model that it does not expect.
fn caught<T>(call: impl FnOnce() -> T) -> Result<T, ModelError> {
    let unexpected = |_| ModelError::NotComputable("the library panicked; its message is above".to_owned());
    catch_unwind(AssertUnwindSafe(call)).map_err(unexpected)
}

fn not_computable(error: impl std::fmt::Debug) -> ModelError {
    ModelError::NotComputable(in_one_line(error))
}

/// The causes of an error, without a backtrace.
fn in_one_line(error: impl std::fmt::Debug) -> String {
    let text = format!("{error:?}");
    let text = text.split("Stack backtrace").next().unwrap_or_default();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn load(onnx: &[u8], settings: &Settings) -> Result<Arc<TypedSimplePlan>, ModelError> {
    let model = tract_onnx::onnx().model_for_read(&mut &*onnx);
    let model = model.map_err(|error| ModelError::NotOnnx(in_one_line(error)))?;
    let inputs = model.input_outlets().map_err(not_computable)?.len();
    if inputs != 1 {
        return Err(ModelError::Inputs(inputs));
    }
    let shape = settings.input.shape();
    check_input(model.input_fact(0).map_err(not_computable)?, shape)?;
    let fact = InferenceFact::dt_shape(f32::datum_type(), shape);
    let model = model.with_input_fact(0, fact).map_err(not_computable)?;
    model.into_optimized().and_then(|model| model.into_runnable()).map_err(not_computable)
}

/// A model that declares the shape of its input must declare that of the settings.
fn check_input(declared: &InferenceFact, made: [usize; 4]) -> Result<(), ModelError> {
    let sides: Vec<Option<i64>> =
        declared.shape.dims().map(|side| side.concretize().and_then(|side| side.to_i64().ok())).collect();
    let is_open = declared.shape.is_open();
    let fits = sides.iter().zip(made).all(|(side, made)| side.is_none_or(|side| side == made as i64));
    if fits && (is_open || sides.len() == made.len()) {
        return Ok(());
    }
    let side = |side: &Option<i64>| side.map_or("?".to_owned(), |side| side.to_string());
    let declared = format!("[{}]", sides.iter().map(side).collect::<Vec<_>>().join(", "));
    Err(ModelError::InputShape { declared, made: format!("{made:?}") })
}

fn infer(
    plan: &Arc<TypedSimplePlan>,
    settings: &Settings,
    values: &[f32],
) -> Result<TVec<TValue>, ModelError> {
    caught(|| {
        let input = Tensor::from_shape(&settings.input.shape(), values)?;
        plan.run(tvec!(input.into()))
    })?
    .map_err(not_computable)
}

/// Calls with the outputs as 32-bit floating-point numbers.
fn with_outputs<T>(outputs: &[TValue], call: impl FnOnce(&[Output<'_>]) -> T) -> Result<T, ModelError> {
    let cast: Result<Vec<_>, _> = outputs.iter().map(|output| output.cast_to::<f32>()).collect();
    let cast = cast.map_err(not_computable)?;
    let views: Result<Vec<_>, _> = cast.iter().map(|output| output.try_as_plain_ram()).collect();
    let views = views.map_err(not_computable)?;
    let mut read = Vec::with_capacity(views.len());
    for (tensor, view) in cast.iter().zip(&views) {
        let values = view.as_slice::<f32>().map_err(not_computable)?;
        read.push(Output { shape: tensor.shape(), values });
    }
    Ok(call(&read))
}
