//! Weights in files: safetensors of our own, and the published Point-MAE checkpoints (PyTorch,
//! `ckpt["base_model"]["MAE_encoder.…"]`), whose names are mapped to ours.

use std::path::Path;

use burn::store::{
    ApplyError, FloatCastAdapter, HalfPrecisionAdapter, ModuleSnapshot, PytorchStore,
    SafetensorsStore,
};
use burn::tensor::DType;

use super::config::{ModelSize, PointMaeConfig};
use super::model::PointMae;

/// Published names → ours. The decoder and the mask token have no counterpart and stay behind.
const RENAMED: [(&str, &str); 13] = [
    (r"^module\.", ""),
    (r"^(?:transformer_q\.)?MAE_encoder\.", "encoder."),
    (r"^encoder\.encoder\.first_conv\.0\.", "encoder.embedding.first."),
    (r"^encoder\.encoder\.first_conv\.1\.", "encoder.embedding.norm_1."),
    (r"^encoder\.encoder\.first_conv\.3\.", "encoder.embedding.second."),
    (r"^encoder\.encoder\.second_conv\.0\.", "encoder.embedding.third."),
    (r"^encoder\.encoder\.second_conv\.1\.", "encoder.embedding.norm_2."),
    (r"^encoder\.encoder\.second_conv\.3\.", "encoder.embedding.fourth."),
    (r"^encoder\.pos_embed\.0\.", "encoder.position.first."),
    (r"^encoder\.pos_embed\.2\.", "encoder.position.second."),
    (r"^encoder\.norm\.", "encoder.transformer.norm."),
    (
        r"^encoder\.blocks\.blocks\.(\d+)\.(?:attn\.|mlp\.)?(qkv|proj|fc1|fc2|norm1|norm2)\.",
        "encoder.transformer.blocks.$1.$2.",
    ),
    (r"^(encoder\.transformer\.blocks\.\d+)\.proj\.", "$1.projection."),
];

/// The rest of the renaming: one published name each.
const LAYERS: [(&str, &str); 4] = [
    (r"\.norm1\.", ".norm_1."),
    (r"\.norm2\.", ".norm_2."),
    (r"\.fc1\.", ".up."),
    (r"\.fc2\.", ".down."),
];

/// Why weights cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WeightsError {
    /// The file cannot be read, or is no such file.
    #[error("cannot read the weights {file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// What happened.
        reason: String,
    },
    /// Tensors are missing or have other shapes.
    #[error(
        "the weights {file} do not fit the network ({size}): {reason}. Choose the size that they \
         were trained with"
    )]
    Unfit {
        /// The file.
        file: String,
        /// The size that was asked for.
        size: String,
        /// What does not fit.
        reason: String,
    },
}

/// What was found in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Loaded {
    /// Encoder and heads: it segments.
    Whole,
    /// Encoder and heads, but no boundary classifier: that wants training.
    WithoutPairs,
    /// The encoder alone: it wants fine-tuning.
    EncoderOnly,
}

/// Load weights into a network of that size, by the file's ending: `.safetensors`, else PyTorch.
pub fn load(
    model: &mut PointMae,
    config: &PointMaeConfig,
    file: &Path,
) -> Result<Loaded, WeightsError> {
    let name = file.display().to_string();
    let size = format!("{} channels × {} blocks", config.width, config.depth);
    let unreadable = |reason: String| WeightsError::Unreadable { file: name.clone(), reason };
    std::fs::metadata(file).map_err(|e| unreadable(e.to_string()))?;
    let result = if file.extension().is_some_and(|e| e == "safetensors") {
        let mut store = SafetensorsStore::from_file(file)
            .allow_partial(true)
            .validate(false)
            .with_from_adapter(FloatCastAdapter::to(DType::F32));
        model.load_from(&mut store).map_err(|e| unreadable(first_line(&e.to_string())))?
    } else {
        let mut store =
            PytorchStore::from_file(file).with_top_level_key("base_model").allow_partial(true);
        for (from, to) in RENAMED.iter().chain(&LAYERS) {
            store = store.with_key_remapping(*from, *to);
        }
        model.load_from(&mut store).map_err(|e| unreadable(first_line(&e.to_string())))?
    };
    let unfit = |reason: String| {
        Err(WeightsError::Unfit { file: name.clone(), size: size.clone(), reason })
    };
    // A classifier of other features is as good as none.
    let stale = |e: &ApplyError| e.to_string().contains("pairs.");
    if let Some(error) = result.errors.iter().find(|e| !stale(e)) {
        return unfit(first_line(&error.to_string()));
    }
    let stale = result.errors.iter().any(stale);
    let missing: Vec<&String> = result.missing.iter().map(|m| &m.0).collect();
    match missing.iter().find(|m| m.starts_with("encoder.")) {
        Some(lacking) => unfit(format!("`{lacking}` is missing")),
        None if missing.is_empty() && !stale => Ok(Loaded::Whole),
        None if missing.iter().all(|m| m.starts_with("pairs.")) => Ok(Loaded::WithoutPairs),
        None => Ok(Loaded::EncoderOnly),
    }
}

/// The network of these bytes of a safetensors file.
pub fn from_bytes(
    bytes: Vec<u8>,
    size: ModelSize,
    device: &burn::tensor::Device,
) -> Result<PointMae, WeightsError> {
    let mut model = PointMae::blank(&size.config(), device);
    let mut store = SafetensorsStore::from_bytes(Some(bytes))
        .with_from_adapter(FloatCastAdapter::to(DType::F32));
    let unreadable =
        |reason: String| WeightsError::Unreadable { file: "weights".to_owned(), reason };
    let result = model.load_from(&mut store).map_err(|e| unreadable(first_line(&e.to_string())))?;
    match result.errors.first() {
        Some(error) => Err(unreadable(first_line(&error.to_string()))),
        None => Ok(model),
    }
}

/// Write the weights as safetensors, of half precision if they are to be `small`.
pub fn save(model: &PointMae, file: &Path, small: bool) -> Result<(), WeightsError> {
    let name = file.display().to_string();
    let unreadable = |reason: String| WeightsError::Unreadable { file: name.clone(), reason };
    // Of several entries of metadata the order would differ from run to run.
    let mut store = SafetensorsStore::from_file(file).clear_metadata().overwrite(true);
    if small {
        store = store.with_to_adapter(HalfPrecisionAdapter::new().with_module("Pointwise"));
    }
    model.save_into(&mut store).map_err(|e| unreadable(e.to_string()))
}

fn first_line(message: &str) -> String {
    message.lines().next().unwrap_or_default().to_owned()
}
