//! A checkpoint laid out as the published ones are: a zip of `archive/data.pkl` and one file a storage,
//! the pickle a dictionary whose `base_model` maps names to tensors.

use std::path::Path;

/// Tensors by name: shape and values.
pub type Tensors = Vec<(String, Vec<usize>, Vec<f32>)>;

/// Write a checkpoint.
pub fn write(file: &Path, tensors: &Tensors) {
    let mut pickle = b"\x80\x02}(".to_vec();
    text(&mut pickle, "base_model");
    pickle.extend(b"}(");
    for (i, (name, shape, values)) in tensors.iter().enumerate() {
        text(&mut pickle, name);
        tensor(&mut pickle, i, shape, values.len());
    }
    pickle.extend(b"u");
    text(&mut pickle, "epoch");
    pickle.extend(b"K\x07u.");
    let mut files = vec![("archive/data.pkl".to_owned(), pickle)];
    for (i, (_, _, values)) in tensors.iter().enumerate() {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        files.push((format!("archive/data/{i}"), bytes));
    }
    files.push(("archive/version".to_owned(), b"3\n".to_vec()));
    std::fs::write(file, zip(&files)).unwrap();
}

fn text(pickle: &mut Vec<u8>, text: &str) {
    pickle.push(b'X');
    pickle.extend((text.len() as u32).to_le_bytes());
    pickle.extend(text.as_bytes());
}

fn integer(pickle: &mut Vec<u8>, value: usize) {
    pickle.push(b'J');
    pickle.extend((value as i32).to_le_bytes());
}

/// `torch._utils._rebuild_tensor_v2(storage, 0, shape, strides, False, OrderedDict())`.
fn tensor(pickle: &mut Vec<u8>, storage: usize, shape: &[usize], count: usize) {
    pickle.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
    text(pickle, "storage");
    pickle.extend(b"ctorch\nFloatStorage\n");
    text(pickle, &storage.to_string());
    text(pickle, "cpu");
    integer(pickle, count);
    pickle.extend(b"tQ");
    integer(pickle, 0);
    pickle.push(b'(');
    shape.iter().for_each(|&s| integer(pickle, s));
    pickle.extend(b"t(");
    let stride = |i: usize| shape[i + 1..].iter().product::<usize>();
    (0..shape.len()).for_each(|i| integer(pickle, stride(i)));
    pickle.extend(b"t\x89ccollections\nOrderedDict\n)RtR");
}

/// A zip archive whose files are stored as they are.
fn zip(files: &[(String, Vec<u8>)]) -> Vec<u8> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, bytes) in files {
        let at = out.len() as u32;
        let mut about = Vec::new();
        // Version, flags, method, time, date.
        for value in [20u16, 0, 0, 0, 0x21] {
            about.extend(value.to_le_bytes());
        }
        for value in [crc32(bytes), bytes.len() as u32, bytes.len() as u32] {
            about.extend(value.to_le_bytes());
        }
        about.extend((name.len() as u16).to_le_bytes());
        about.extend(0u16.to_le_bytes());
        out.extend(b"PK\x03\x04");
        out.extend(&about);
        out.extend(name.as_bytes());
        out.extend(bytes);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&about);
        directory.extend([0u8; 10]);
        directory.extend(at.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (start, count) = (out.len() as u32, files.len() as u16);
    out.extend(&directory);
    out.extend(b"PK\x05\x06\x00\x00\x00\x00");
    out.extend(count.to_le_bytes());
    out.extend(count.to_le_bytes());
    out.extend((directory.len() as u32).to_le_bytes());
    out.extend(start.to_le_bytes());
    out.extend([0u8; 2]);
    out
}

fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32, byte: &u8| {
        let mixed = crc ^ u32::from(*byte);
        (0..8).fold(mixed, |c, _| if c & 1 == 1 { c >> 1 ^ 0xedb8_8320 } else { c >> 1 })
    };
    !bytes.iter().fold(!0, step)
}

#[test]
fn the_checksum_is_the_known_one() {
    assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
}
