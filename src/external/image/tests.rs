//! Files of images, whole and broken.

use super::*;

fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(data);
    bytes
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn read(name: &str, bytes: &[u8], size: [usize; 2]) -> Result<Stack, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Stack::read(&[path], size).map_err(|error| error.to_string())
}

#[test]
fn arrays_are_read_in_every_layout() {
    let six = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let plain = read("a.npy", &npy("<f4", "(2, 3)", &floats(&six)), [3, 2]).unwrap();
    assert_eq!((plain.values.as_slice(), plain.n_images(), plain.is_half), (&six.map(f64::from)[..], 1, false));
    let two = read("a.npy", &npy("<f4", "(2, 1, 3)", &floats(&six)), [3, 1]).unwrap();
    assert_eq!((two.n_images(), two.image(1)), (2, &[4.0, 5.0, 6.0][..]));
    // Three equal channels are one.
    let grey = read("a.npy", &npy("<f4", "(1, 1, 2, 3)", &floats(&[1.0, 1.0, 1.0, 2.0, 2.0, 2.0])), [2, 1]).unwrap();
    assert!(grey.values.iter().zip([1.0, 2.0]).all(|(a, b)| (a - b).abs() < 1e-15));
    let big: Vec<u8> = six.iter().flat_map(|x| f64::from(*x).to_be_bytes()).collect();
    assert_eq!(read("a.npy", &npy(">f8", "(3, 2)", &big), [2, 3]).unwrap().values, six.map(f64::from));
    let halves = read("a.npy", &npy("<f2", "(1, 2)", &[0, 0x3c, 0, 0x40]), [2, 1]).unwrap();
    assert!(halves.is_half && halves.values == [1.0, 2.0]);
}

#[test]
fn float_maps_run_upwards() {
    let rows = floats(&[3.0, 4.0, 1.0, 2.0]);
    let file = |head: &str| [head.as_bytes(), &rows].concat();
    assert_eq!(read("a.pfm", &file("Pf\n2 2\n-1.0\n"), [2, 2]).unwrap().values, [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(read("a.pfm", &file("Pf\n2 2\n-0.5\n"), [2, 2]).unwrap().values, [0.5, 1.0, 1.5, 2.0]);
    let big: Vec<u8> = [3.0f32, 4.0].iter().flat_map(|x| x.to_be_bytes()).collect();
    assert_eq!(read("a.pfm", &[b"Pf 1 2 1 ", &big[..]].concat(), [1, 2]).unwrap().values, [4.0, 3.0]);
}

#[test]
fn every_fault_of_a_file_is_named() {
    let four = floats(&[1.0, 2.0, 3.0, 4.0]);
    let nan = floats(&[1.0, f32::NAN, f32::INFINITY, 4.0]);
    for (bytes, said) in [
        (Vec::new(), "empty"),
        (b"hello, world".to_vec(), "begins as none"),
        (b"\x89PNG\r\n\x1a\n".to_vec(), "clamped"),
        (npy("<f4", "(2, 2)", &four[..15]), "cut off: an array [2, 2] needs 16 bytes, 15 are there"),
        (npy("<f4", "(2, 2)", &[&four[..], b"more"].concat()), "goes on"),
        (npy("<f4", "(4, 4)", &four), "an array [4, 4]; the manifest says 2 x 2"),
        (
            npy("<f4", "(2, 2)", &nan),
            "2 of 4 pixels of image 0 (counted from 0, over all files) are no finite numbers: column 1, row 0: NaN; column 0, row 1: inf",
        ),
        (npy("<f4", "(2, 2, 2)", &four.repeat(2)), "images 0 and 1, counted from 0, are equal"),
        (npy("<f4", "(9999999999999, 2, 2)", &four), "held in memory"),
        (npy("<f4", "(18446744073709551615, 2, 2)", &four), "held in memory"),
        (npy("<f4", "(0, 2, 2)", &[]), "no image"),
        (npy("<c8", "(2, 2)", &four), "'<c8'"),
        (b"\x93NUMPY\x01".to_vec(), "cut off"),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(), "a header of 4294967295 bytes"),
        (b"\x93NUMPY\x09\x00\x00\x00".to_vec(), "version 9"),
        (b"Pf\n2 2\n-1.0\n1234".to_vec(), "cut off"),
        (b"Pf\n99999999 99999999\n-1.0\n1234".to_vec(), "99999999 x 99999999 pixels"),
        (b"Pf\n2 2\nnan\n1234".to_vec(), "scale"),
        (b"Pf\n2".to_vec(), "cut off before its width"),
        (b"Pf\n\xff\xff".to_vec(), "no word"),
        (b"\x76\x2f\x31\x01".to_vec(), "no valid OpenEXR"),
    ] {
        let error = read("file", &bytes, [2, 2]).unwrap_err();
        assert!(error.contains(said) && error.contains("file") | error.contains("equal"), "{said}: {error}");
    }
    let black = read("a.npy", &npy("<f4", "(2, 1, 2)", &floats(&[0.0; 4])), [2, 1]);
    assert!(black.is_ok(), "two black images are two images of the dark");
    assert!(Stack::read(&["/".into()], [1, 1]).unwrap_err().to_string().contains("no file"));
}

/// OpenEXR as the crate writes it, whole and with every byte of its head changed: an image, or a message.
#[cfg(feature = "plots")]
#[test]
fn parts_are_images_and_damage_is_survived() {
    use ::exr::prelude::*;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let layer = |name: &str, add: f32, half: bool| {
        let values: Vec<f32> = (0..6).map(|i| i as f32 + add).collect();
        let samples = |values: &[f32]| match half {
            true => FlatSamples::F16(values.iter().map(|x| f16::from_f32(*x)).collect()),
            false => FlatSamples::F32(values.to_vec()),
        };
        let channel = |name: &str| AnyChannel::new(name, samples(&values));
        let channels = AnyChannels::sort(["B", "G", "R", "variance.Y"].map(channel).into_iter().collect());
        Layer::new((3, 2), LayerAttributes::named(name), Encoding::FAST_LOSSLESS, channels)
    };
    let write = |layers: Vec<Layer<AnyChannels<FlatSamples>>>| {
        let size = IntegerBounds::from_dimensions((3, 2));
        Image::from_layers(ImageAttributes::new(size), Layers::from(layers)).write().to_file(&path).unwrap();
    };
    write(vec![layer("one", 0.0, false), layer("two", 1.0, false)]);
    let stack = Stack::read(std::slice::from_ref(&path), [3, 2]).unwrap();
    assert!(!stack.is_half && stack.n_images() == 2 && stack.variance.is_none());
    assert!(stack.image(1).iter().zip(1..).all(|(a, b)| (a - f64::from(b)).abs() < 1e-12));
    write(vec![layer("one", 0.5, true)]);
    let stack = Stack::read(std::slice::from_ref(&path), [3, 2]).unwrap();
    assert!(stack.is_half && stack.variance.as_ref().is_some_and(|v| v[5] == 5.5));
    assert!(Stack::read(std::slice::from_ref(&path), [2, 3]).unwrap_err().to_string().contains("3 x 2 pixels"));

    let whole = std::fs::read(&path).unwrap();
    let quiet = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| ()));
    let mut refused = 0;
    for at in 4..whole.len() {
        for byte in [0x00, 0xff, whole[at] ^ 0x10] {
            let mut bytes = whole.clone();
            bytes[at] = byte;
            refused += usize::from(self::read("b.exr", &bytes, [3, 2]).is_err());
        }
        refused += usize::from(self::read("c.exr", &whole[..at], [3, 2]).is_err());
    }
    std::panic::set_hook(quiet);
    assert!(refused > whole.len(), "{refused} of {}", 4 * whole.len());
}
