//! Arrays for NumPy: an archive `.npz` of arrays `.npy`, not compressed.

use crate::{Error, Result};
use nalgebra::DMatrix;

/// An array.
pub enum Array<'a> {
    /// A matrix of doubles, by columns.
    Matrix(&'a DMatrix<f64>),
    /// A list of doubles.
    List(&'a [f64]),
    /// A list of texts.
    Texts(&'a [String]),
}

impl Array<'_> {
    /// The bytes of the array as a `.npy` file of version 1.0.
    fn bytes(&self) -> Vec<u8> {
        let (kind, shape, data) = match self {
            Self::Matrix(a) => {
                ("<f8".into(), format!("({}, {})", a.nrows(), a.ncols()), doubles(a.as_slice()))
            }
            Self::List(list) => ("<f8".into(), format!("({},)", list.len()), doubles(list)),
            Self::Texts(list) => {
                let width = list.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
                (format!("<U{width}"), format!("({},)", list.len()), texts(list, width))
            }
        };
        let by_columns = if matches!(self, Self::Matrix(_)) { "True" } else { "False" };
        let mut head = format!("{{'descr': '{kind}', 'fortran_order': {by_columns}, 'shape': {shape}, }}");
        // Magic, version and length take ten bytes; data begin at a multiple of 64.
        while (10 + head.len() + 1) % 64 != 0 {
            head.push(' ');
        }
        head.push('\n');
        let length = (head.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00".as_slice(), &length, head.as_bytes(), &data].concat()
    }
}

fn doubles(list: &[f64]) -> Vec<u8> {
    list.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Texts of a common width in UTF-32.
fn texts(list: &[String], width: usize) -> Vec<u8> {
    let padded = |text: &String| {
        let codes: Vec<u32> = text.chars().map(u32::from).collect();
        (0..width).flat_map(move |k| codes.get(k).copied().unwrap_or(0).to_le_bytes()).collect::<Vec<u8>>()
    };
    list.iter().flat_map(padded).collect()
}

/// The checksum of ZIP.
fn crc32(bytes: &[u8]) -> u32 {
    let table: Vec<u32> = (0..256)
        .map(|k| (0..8).fold(k, |c: u32, _| if c & 1 == 1 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 }))
        .collect();
    !bytes.iter().fold(!0, |c: u32, b| table[((c ^ u32::from(*b)) & 0xFF) as usize] ^ (c >> 8))
}

/// The archive of named arrays.
///
/// # Errors
/// An error for 4 GB and more, which need another form of archive.
pub fn archive(arrays: &[(&str, Array)]) -> Result<Vec<u8>> {
    let (mut out, mut directory) = (Vec::new(), Vec::new());
    for (name, array) in arrays {
        let (name, data) = (format!("{name}.npy"), array.bytes());
        if out.len() + data.len() > u32::MAX as usize / 2 {
            return Err(Error::new("basis", "it has more than 2 GB; reduce to fewer modes"));
        }
        let at = (out.len() as u32).to_le_bytes();
        // Version 2.0, no flags, stored, 1980-01-01: the same bytes in every run.
        let mut common = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(crc32(&data).to_le_bytes());
        common.extend([(data.len() as u32).to_le_bytes(); 2].concat());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        out.extend([b"PK\x03\x04".as_slice(), &common, name.as_bytes(), &data].concat());
        let rest = [[0; 10].as_slice(), &at, name.as_bytes()].concat();
        directory.extend([b"PK\x01\x02\x14\x00".as_slice(), &common, &rest].concat());
    }
    let count = (arrays.len() as u16).to_le_bytes();
    let (size, at) = ((directory.len() as u32).to_le_bytes(), (out.len() as u32).to_le_bytes());
    out.extend(directory);
    out.extend([b"PK\x05\x06\0\0\0\0".as_slice(), &count, &count, &size, &at, &[0, 0]].concat());
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_checksum_of_the_digits() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn invariant_data_of_an_array_begin_at_a_multiple_of_64() {
        let a = DMatrix::from_row_slice(2, 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let bytes = Array::Matrix(&a).bytes();
        assert_eq!(
            (bytes.len() % 64, &bytes[bytes.len() - 48..bytes.len() - 40]),
            (48, 1f64.to_le_bytes().as_slice())
        );
        let texts = ["tip.x".to_owned(), "ü".to_owned()];
        let bytes = Array::Texts(&texts).bytes();
        assert!(String::from_utf8_lossy(&bytes[10..74]).contains("'<U5'"), "{bytes:?}");
    }
}
