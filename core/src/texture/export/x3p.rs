//! X3P: `main.xml`, the heights in `bindata/data.bin`, and checksums, in a ZIP container.
//!
//! # Source
//! ISO 25178-72:2017 (once ISO 5436-2), annex A; lengths in metres, heights as little-endian doubles, along the first
//! axis fastest.

use super::matrix::Matrix;
use md5::{Digest, Md5};
use std::io::{Cursor, Write};
use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// mm in a m.
const METRE: f64 = 1e3;
/// Date of the file, so that the same map gives the same bytes; the simulation has no time of its own.
const DATE: &str = "2000-01-01T00:00:00";

/// Why there is no container; a map of a size that no container holds.
#[derive(Debug, Error)]
#[error("texture: the X3P file cannot be made: {0}")]
pub struct X3pError(String);

/// The map as an X3P file.
///
/// # Errors
/// [`X3pError`] if the container refuses its size.
pub fn x3p(map: &Matrix) -> Result<Vec<u8>, X3pError> {
    let data: Vec<u8> = map.heights.iter().flat_map(|h| (h / METRE).to_le_bytes()).collect();
    let main = main_xml(map, &checksum(&data));
    let sums = format!("{} *main.xml\n", checksum(main.as_bytes()));
    let files = [
        ("main.xml", main.as_bytes()),
        ("bindata/data.bin", &data),
        ("md5checksum.hex", sums.as_bytes()),
    ];
    pack(&files).map_err(|error| X3pError(error.to_string()))
}

fn pack(files: &[(&str, &[u8])]) -> zip::result::ZipResult<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(DateTime::default());
    let mut container = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        container.start_file(*name, options)?;
        container.write_all(bytes)?;
    }
    Ok(container.finish()?.into_inner())
}

fn checksum(bytes: &[u8]) -> String {
    Md5::digest(bytes).iter().map(|byte| format!("{byte:02X}")).collect()
}

fn main_xml(map: &Matrix, checksum: &str) -> String {
    let axis = |name: &str, step: f64| {
        format!(
            "      <{name}>\n        <AxisType>I</AxisType>\n        <DataType>D</DataType>\n        \
             <Increment>{:.12e}</Increment>\n        <Offset>0.0</Offset>\n      </{name}>\n",
            step / METRE
        )
    };
    let [x, y] = [axis("CX", map.steps[0]), axis("CY", map.steps[1])];
    let [columns, rows] = map.counts;
    let version = env!("CARGO_PKG_VERSION");
    format!(
        r#"<?xml version="1.0" encoding="UTF-8" standalone="no"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:schemaLocation="http://www.opengps.eu/2008/ISO5436_2 http://www.opengps.eu/2008/ISO5436_2/ISO5436_2.xsd">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>SUR</FeatureType>
    <Axes>
{x}{y}      <CZ>
        <AxisType>A</AxisType>
        <DataType>D</DataType>
        <Increment>1.0</Increment>
        <Offset>0.0</Offset>
      </CZ>
    </Axes>
  </Record1>
  <Record2>
    <Date>{DATE}</Date>
    <Instrument>
      <Manufacturer>evencut</Manufacturer>
      <Model>texture</Model>
      <Serial>not available</Serial>
      <Version>{version}</Version>
    </Instrument>
    <CalibrationDate>{DATE}</CalibrationDate>
    <ProbingSystem>
      <Type>Software</Type>
      <Identification>simulated</Identification>
    </ProbingSystem>
    <Comment>Simulated: what the teeth of a cutter leave. X along the feed, Y across it, Z over the nominal form.</Comment>
  </Record2>
  <Record3>
    <MatrixDimension>
      <SizeX>{columns}</SizeX>
      <SizeY>{rows}</SizeY>
      <SizeZ>1</SizeZ>
    </MatrixDimension>
    <DataLink>
      <PointDataLink>bindata/data.bin</PointDataLink>
      <MD5ChecksumPointData>{checksum}</MD5ChecksumPointData>
    </DataLink>
  </Record3>
  <Record4>
    <ChecksumFile>md5checksum.hex</ChecksumFile>
  </Record4>
</p:ISO5436_2>
"#
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn the_container_holds_heights_and_their_checksum() {
        let heights = [0.0, 0.001, 0.002, -0.003, 0.004, 0.005];
        let map = Matrix { counts: [3, 2], steps: [0.1, 0.2], heights: &heights };
        let bytes = x3p(&map).unwrap();
        assert_eq!(bytes, x3p(&map).unwrap());
        let mut container = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let mut read = |name: &str| {
            let mut content = Vec::new();
            container.by_name(name).unwrap().read_to_end(&mut content).unwrap();
            content
        };
        let data = read("bindata/data.bin");
        assert_eq!(data.len(), 48);
        assert_eq!(f64::from_le_bytes(data[24..32].try_into().unwrap()), -3e-6);
        let main = String::from_utf8(read("main.xml")).unwrap();
        assert!(main.contains(&checksum(&data)) && main.contains("<SizeX>3</SizeX>"));
        let sums = String::from_utf8(read("md5checksum.hex")).unwrap();
        assert_eq!(sums, format!("{} *main.xml\n", checksum(main.as_bytes())));
    }

    #[test]
    fn checksums_are_those_of_the_rfc() {
        assert_eq!(checksum(b"abc"), "900150983CD24FB0D6963F7D28E17F72");
    }
}
