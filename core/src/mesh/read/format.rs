//! Kinds of mesh files, and how their names and messages call them.

use std::fmt;

/// A kind of mesh file.
#[derive(Copy, Clone, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Stereolithography, binary or ASCII.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// Polygon file format, ASCII or binary of either byte order.
    Ply,
    /// Object file format, ASCII.
    Off,
}

impl MeshFormat {
    /// The format that a file name's extension says, in any case; `None` for any other extension.
    pub fn from_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        match extension.to_ascii_lowercase().as_str() {
            "stl" => Some(Self::Stl),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "off" => Some(Self::Off),
            _ => None,
        }
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Stl => "STL",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Off => "OFF",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extensions_say_the_format() {
        assert_eq!(MeshFormat::from_name("a.b/Part.STL"), Some(MeshFormat::Stl));
        assert_eq!(MeshFormat::from_name("part.step"), None);
        assert_eq!(MeshFormat::from_name("stl"), None);
    }
}
