//! Small files of every format, damaged at random places (the same ones every time), are read or
//! refused, but never make a reader panic or allocate without bound.

use evencut_core::job::Component;
use evencut_core::mesh::{MeshFormat, read};
use evencut_core::surface::build;
use evencut_tests::as_it_is;

/// Damaged versions of each file.
const ROUNDS: u32 = 4000;

/// Knuth's 64-bit linear congruential generator.
struct Lcg(u64);

impl Lcg {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n.max(1)
    }
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    let triangles: [[[f32; 3]; 3]; 2] = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5]],
        [[0.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]],
    ];
    bytes.extend(2_u32.to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn binary_ply(
    order: &str,
    write: impl Fn(f32) -> [u8; 4],
    index: impl Fn(u16) -> [u8; 2],
) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {order} 1.0\ncomment made up\nelement vertex 4\nproperty float x\n\
         property float y\nproperty float z\nelement face 2\nproperty uchar red\n\
         property list uchar ushort vertex_indices\nend_header\n"
    )
    .into_bytes();
    for corner in [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]] {
        bytes.extend(corner.into_iter().flat_map(&write));
    }
    for face in [[0, 1, 2], [0, 2, 3]] {
        bytes.extend([200, 3]);
        bytes.extend(face.into_iter().flat_map(&index));
    }
    bytes
}

fn samples() -> Vec<(MeshFormat, Vec<u8>)> {
    let ascii_stl = "solid a b\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   \
                     vertex 1 0 0\n   vertex 1 1 .5\n  endloop\n endfacet\nendsolid a b\n";
    let obj = "# quad\nv 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
               f 1/1/1 2/2/1 \\\n 3/3/1 -1/-1/1\nv 2 0 0\nv 2 1 0\nf 2//1 5//1 6//1 3//1\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n\
               property double z\nelement face 1\nproperty list uchar int vertex_index\n\
               element edge 1\nproperty list uchar float weights\nend_header\n\
               0 0 0\n1 0 0\n1 1 .5\n0 1 0\n4 0 1 2 3\n2 0.5 1e3\n";
    let off =
        "OFF # comment\n5 2 0\n0 0 0\n1 0 0\n1 1 0.5\n0 1 0\n2 0 1\n4 0 1 2 3 255 0 0\n3 1 4 2\n";
    vec![
        (MeshFormat::Stl, binary_stl()),
        (MeshFormat::Stl, ascii_stl.into()),
        (MeshFormat::Obj, obj.into()),
        (MeshFormat::Ply, ply.into()),
        (MeshFormat::Ply, binary_ply("binary_little_endian", f32::to_le_bytes, u16::to_le_bytes)),
        (MeshFormat::Ply, binary_ply("binary_big_endian", f32::to_be_bytes, u16::to_be_bytes)),
        (MeshFormat::Off, off.into()),
    ]
}

/// Overwrites, deletes, doubles or inserts a few bytes.
fn damage(bytes: &[u8], random: &mut Lcg) -> Vec<u8> {
    const TELLING: &[u8] = b"0123456789.-+eE/ \n\r\t\\#fv\x00\x7f\x80\xff";
    let mut damaged = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(damaged.len());
        let byte = match random.below(2) {
            0 => TELLING[random.below(TELLING.len())],
            _ => random.below(256) as u8,
        };
        let end = (at + random.below(12)).min(damaged.len());
        match random.below(5) {
            0 => drop(damaged.drain(at..end)),
            1 => damaged.insert(at, byte),
            2 => {
                let piece = damaged[at..end].to_vec();
                let to = random.below(damaged.len());
                damaged.splice(to..to, piece);
            }
            _ => {
                if let Some(slot) = damaged.get_mut(at) {
                    *slot = byte;
                }
            }
        }
    }
    damaged
}

#[test]
fn samples_are_sound() {
    for (format, bytes) in samples() {
        let soup = read(&bytes, format).unwrap();
        build(soup, &as_it_is(Component::Only)).unwrap();
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let mut random = Lcg(1);
    let (mut taken, mut refused) = (0, 0);
    for (format, bytes) in samples() {
        for _ in 0..ROUNDS {
            let damaged = damage(&bytes, &mut random);
            match read(&damaged, format) {
                Ok(soup) => {
                    // Triangles and vertices stay within what the bytes can hold.
                    assert!(soup.faces.len() + soup.positions.len() <= 2 * damaged.len());
                    taken += 1;
                    drop(build(soup, &as_it_is(Component::Largest)));
                }
                Err(error) => {
                    assert!(error.to_string().len() < 400, "{error}");
                    refused += 1;
                }
            }
        }
    }
    // Both ways are well travelled.
    assert!(taken > 2000 && refused > 10_000, "{taken} read, {refused} refused");
}
