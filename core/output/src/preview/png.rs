//! PNG pictures with a palette: small files, and the same bytes everywhere.

use super::colour::Rgb;

/// Effort of the compressor, 0 to 10: above 6 the files hardly shrink.
const LEVEL: u8 = 6;

/// Encodes `width * height` palette indices, row by row; index 0 is transparent.
///
/// `palette`: at most 256 colours.
///
/// # Source
/// W3C, "Portable Network Graphics (PNG) Specification", second edition: colour type 3, 8 bits.
pub fn encode(width: u32, height: u32, indices: &[u8], palette: &[Rgb]) -> Vec<u8> {
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut header = Vec::with_capacity(13);
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    header.extend([8, 3, 0, 0, 0]);
    chunk(&mut out, b"IHDR", &header);
    let colours: Vec<u8> = palette.iter().flat_map(|c| c.0).collect();
    chunk(&mut out, b"PLTE", &colours);
    chunk(&mut out, b"tRNS", &[0]);
    let mut rows = Vec::with_capacity(indices.len() + height as usize);
    for row in indices.chunks(width as usize) {
        rows.push(0);
        rows.extend_from_slice(row);
    }
    chunk(&mut out, b"IDAT", &miniz_oxide::deflate::compress_to_vec_zlib(&rows, LEVEL));
    chunk(&mut out, b"IEND", &[]);
    out
}

fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    out.extend((data.len() as u32).to_be_bytes());
    let start = out.len();
    out.extend(kind);
    out.extend(data);
    let check = crc32(&out[start..]);
    out.extend(check.to_be_bytes());
}

/// CRC of ISO 3309, as PNG wants it.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |c, _| step(c)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crc_of_the_check_string() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn rows_come_back() {
        let indices = [0, 1, 2, 2, 1, 0];
        let png = encode(3, 2, &indices, &[Rgb([0; 3]), Rgb([9; 3]), Rgb([8; 3])]);
        let start = png.windows(4).position(|w| w == b"IDAT").unwrap();
        let length = u32::from_be_bytes(png[start - 4..start].try_into().unwrap()) as usize;
        let rows =
            miniz_oxide::inflate::decompress_to_vec_zlib(&png[start + 4..start + 4 + length]);
        assert_eq!(rows.unwrap(), [0, 0, 1, 2, 0, 2, 1, 0]);
    }
}
