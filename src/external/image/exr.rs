//! OpenEXR: half or float, one channel or three, any number of parts, each part an image.

use std::io::{Read, Seek};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use exr::meta::MetaData;
use exr::prelude::*;

use super::error::ImageError;
use super::{Sink, grey};
use crate::intake::{EXR_CHANNELS, EXR_HEADER, EXR_PARTS, IMAGE_VALUES};

pub(super) fn read(path: &Path, mut file: impl Read + Seek, sink: &mut Sink) -> std::result::Result<(), ImageError> {
    let broken = |what: String| ImageError::Broken { path: path.to_owned(), what };
    // A crafted file that finds a panic in the decoder is a broken file.
    let guarded = |error: Box<dyn std::any::Any + Send>| {
        let said = error.downcast_ref::<&str>().map(|text| (*text).to_owned());
        let said = said.or_else(|| error.downcast_ref::<String>().cloned()).unwrap_or_default();
        broken(format!("no valid OpenEXR: the decoder gave up ({said})"))
    };
    let meta = catch_unwind(AssertUnwindSafe(|| {
        MetaData::read_from_buffered(std::io::BufReader::new(file.by_ref().take(EXR_HEADER)), false)
    }));
    let meta = meta.map_err(guarded)?.map_err(|error| broken(format!("no valid OpenEXR header: {error}")))?;
    if meta.headers.len() as u64 > EXR_PARTS {
        return Err(broken(format!("{} parts; up to {EXR_PARTS} are accepted", meta.headers.len())));
    }
    for header in &meta.headers {
        let size = header.layer_size;
        if (size.width(), size.height()) != (sink.width, sink.height) {
            return Err(sink.size_error(path, format!("{} x {} pixels", size.width(), size.height())));
        }
        if header.deep {
            return Err(broken("a part of it is deep: many samples a pixel; accepted: flat images".to_owned()));
        }
        let channels = &header.channels.list;
        if channels.len() as u64 > EXR_CHANNELS {
            return Err(broken(format!("{} channels; up to {EXR_CHANNELS} are accepted", channels.len())));
        }
        if let Some(channel) = channels.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(broken(format!("channel {} has fewer pixels than the image", channel.name)));
        }
    }
    // At most 64 channels more than one a part are ever held beside what is kept.
    sink.room_for(path, meta.headers.len())?;
    let all: usize = meta.headers.iter().map(|header| header.channels.list.len()).sum();
    if all.saturating_mul(sink.n_pixels()) as u64 > 2 * IMAGE_VALUES {
        return Err(broken(format!("{all} channels of this size are too many to be held")));
    }
    file.rewind().map_err(|source| ImageError::Unreadable { path: path.to_owned(), source })?;
    let image = catch_unwind(AssertUnwindSafe(|| {
        let reader = exr::prelude::read().no_deep_data().largest_resolution_level().all_channels().all_layers();
        reader.all_attributes().non_parallel().from_buffered(std::io::BufReader::new(file))
    }));
    let image = image.map_err(guarded)?.map_err(|error| broken(format!("its pixels cannot be read: {error}")))?;
    for layer in &image.layer_data {
        part(path, layer, sink)?;
    }
    Ok(())
}

type Part = Layer<AnyChannels<FlatSamples>>;

fn part(path: &Path, layer: &Part, sink: &mut Sink) -> std::result::Result<(), ImageError> {
    let channels = &layer.channel_data.list;
    let named = |channel: &AnyChannel<FlatSamples>| channel.name.to_string();
    let is_variance = |channel: &&AnyChannel<FlatSamples>| {
        named(channel).split('.').any(|word| ["variance", "var"].contains(&word.to_lowercase().as_str()))
    };
    let chosen: Vec<&AnyChannel<FlatSamples>> = channels.iter().filter(|channel| !is_variance(channel)).collect();
    let Some(colours) = colours(&chosen) else {
        let names: Vec<String> = channels.iter().map(named).collect();
        let what = format!(
            "channels {}; accepted: R, G and B (with a layer before them, if it is one alone), Y, or a single one",
            names.join(", ")
        );
        return Err(ImageError::Broken { path: path.to_owned(), what });
    };
    sink.is_half |= colours.iter().any(|channel| matches!(channel.sample_data, FlatSamples::F16(_)));
    let image = together(&colours, sink.n_pixels()).ok_or_else(|| ImageError::Broken {
        path: path.to_owned(),
        what: "a channel has fewer numbers than the image has pixels, or whole numbers".to_owned(),
    })?;
    sink.push(path, &image)?;
    let variances: Vec<&AnyChannel<FlatSamples>> = channels.iter().filter(is_variance).collect();
    if !variances.is_empty() {
        // Of a neutral scene all three are alike.
        let first = together(&variances[..1], sink.n_pixels());
        first.map_or(Ok(()), |variance| sink.push_variance(path, variance))?;
    }
    Ok(())
}

/// Red, green and blue in that order, or the one that there is; alpha does not count.
fn colours<'a>(channels: &[&'a AnyChannel<FlatSamples>]) -> Option<Vec<&'a AnyChannel<FlatSamples>>> {
    let last = |channel: &AnyChannel<FlatSamples>| {
        let name = channel.name.to_string();
        name.rsplit('.').next().unwrap_or_default().to_uppercase()
    };
    let of = |word: &str| {
        let plain = channels.iter().filter(|channel| channel.name.to_string().eq_ignore_ascii_case(word));
        let plain: Vec<_> = plain.collect();
        let found = if plain.is_empty() { channels.iter().filter(|c| last(c) == word).collect() } else { plain };
        (found.len() == 1).then(|| *found[0])
    };
    if let (Some(r), Some(g), Some(b)) = (of("R"), of("G"), of("B")) {
        return Some(vec![r, g, b]);
    }
    if let Some(y) = of("Y") {
        return Some(vec![y]);
    }
    let rest: Vec<_> = channels.iter().filter(|channel| last(channel) != "A").collect();
    (rest.len() == 1).then(|| vec![*rest[0]])
}

fn together(channels: &[&AnyChannel<FlatSamples>], n_pixels: usize) -> Option<Vec<f64>> {
    let numbers = |channel: &AnyChannel<FlatSamples>| -> Option<Vec<f64>> {
        let numbers: Vec<f64> = match &channel.sample_data {
            FlatSamples::F16(values) => values.iter().map(|x| x.to_f64()).collect(),
            FlatSamples::F32(values) => values.iter().map(|x| f64::from(*x)).collect(),
            FlatSamples::U32(_) => return None,
        };
        (numbers.len() == n_pixels).then_some(numbers)
    };
    match channels {
        [r, g, b] => {
            let [r, g, b] = [numbers(r)?, numbers(g)?, numbers(b)?];
            Some((0..n_pixels).map(|i| grey([r[i], g[i], b[i]])).collect())
        }
        [only] => numbers(only),
        _ => None,
    }
}
