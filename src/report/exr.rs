//! OpenEXR: linear numbers in 32 bits, by named channels.

use std::io::Cursor;

use exr::prelude::*;

/// A picture in memory. The same channels give the same bytes.
///
/// - `channels`: names and values, `[height][width]`; `units`, `comments`: Latin-1, attributes of the file
pub(super) fn written(
    [width, height]: [usize; 2],
    channels: Vec<(&str, Vec<f64>)>,
    units: &str,
    comments: &str,
) -> std::result::Result<Vec<u8>, String> {
    let channel = |(name, values): (&str, Vec<f64>)| {
        AnyChannel::new(name, FlatSamples::F32(values.into_iter().map(|value| value as f32).collect()))
    };
    let channels = AnyChannels::sort(channels.into_iter().map(channel).collect());
    let text = |text: &str| Text::new_or_none(text).ok_or_else(|| format!("no Latin-1 text: {text}"));
    let mut attributes = LayerAttributes {
        comments: Some(text(comments)?),
        software_name: Some(text(concat!("etendue ", env!("CARGO_PKG_VERSION")))?),
        ..LayerAttributes::default()
    };
    // The writer keeps these in no order: one alone has one.
    attributes.other.insert(text("units")?, AttributeValue::Text(text(units)?));
    let layer = Layer::new((width, height), attributes, Encoding::SMALL_LOSSLESS, channels);
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).map_err(|e| e.to_string())?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_read_back_by_name() {
        let made = || {
            let channels = vec![("z", vec![-1.5, 2.0, 0.25, 1e9]), ("Y", vec![f64::NAN, 0.5, 1.0, 2.0])];
            written([2, 2], channels, "Y: W/m2; z: none", "made up").unwrap()
        };
        let bytes = made();
        assert_eq!(bytes, made());
        let reader =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let image = reader.from_buffered(Cursor::new(bytes)).unwrap();
        let channels = &image.layer_data.channel_data.list;
        let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["Y", "z"]);
        let values: Vec<f32> = channels[1].sample_data.values_as_f32().collect();
        assert_eq!(values, [-1.5, 2.0, 0.25, 1e9]);
        assert!(channels[0].sample_data.values_as_f32().next().unwrap().is_nan());
        let units = image.layer_data.attributes.other.get(&Text::from("units"));
        assert_eq!(units, Some(&AttributeValue::Text(Text::from("Y: W/m2; z: none"))));
    }
}
