//! Small files of every format, damaged at random places (the same ones every time), are read or
//! refused, but never make a reader panic or allocate without bound.

use evencut_core::gcode::{self, CheckOptions, Kinematics, ReadOptions};
use evencut_core::geometry::DVec3;
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

/// Programs with every construct that is read.
const PROGRAMS: [&str; 2] = [
    "%\nO7 (name)\nN1 G21 G90 G17 G94 G40 G49 G80 G54\nG64 P0.01\nT1 M6\nG43 H1\nS9000 M3 M8\n\
     G0 Z20\nX0 Y0\nG1 Z1 F500\nG2 X10 I5 J0 Z0.5 P2\nG3 X0 Y5 R-9\nG18 G2 X4 Z0 R7\nG91 G19\n\
     G3 Y2 Z2 K2\nG20 G1 X.1\nG90.1 G17 G90 G2 X1 Y1 I.5 J.5\nG91.1 G4 P1\n/G1 X5\nG53 G0 Z0\n\
     G28 X1\nM5 M9\nM30\n%\n",
    "G21G90G93G61\nG0X1Y2Z30A10C30\nG1X2A11C35F30\nG2X5I2A40C90F9\nG1C720F1\nG94X3A0F100\nC9\nM2\n",
];

#[test]
fn programs_are_sound() {
    for (program, kinematics) in PROGRAMS.iter().zip([Kinematics::ThreeAxis, Kinematics::Xyzac]) {
        let machine_zero = Some(DVec3::splat(100.0));
        let options = ReadOptions { kinematics, machine_zero, ..ReadOptions::default() };
        let read = gcode::read(program, &options).unwrap_or_else(|error| panic!("{error}"));
        assert_sound(&read, options.max_points);
        assert!(read.moves.len() >= 6);
    }
}

#[test]
fn damaged_programs_are_read_or_refused() {
    let mut random = Lcg(2);
    let (mut taken, mut refused) = (0, 0);
    let kinematics = [Kinematics::ThreeAxis, Kinematics::Xyzac, Kinematics::Xyzbc];
    for round in 0..10 * ROUNDS {
        let program = PROGRAMS[random.below(PROGRAMS.len())];
        let damaged = damage(program.as_bytes(), &mut random);
        let options = ReadOptions {
            kinematics: kinematics[random.below(3)],
            machine_zero: (round % 3 > 0).then_some(DVec3::splat(100.0)),
            block_delete: round % 2 > 0,
            max_points: 20_000,
            ..ReadOptions::default()
        };
        match gcode::read(&String::from_utf8_lossy(&damaged), &options) {
            Ok(program) => {
                assert_sound(&program, options.max_points);
                taken += 1;
            }
            Err(error) => {
                assert!(error.to_string().len() < 400, "{error}");
                refused += 1;
            }
        }
    }
    assert!(taken > 2000 && refused > 10_000, "{taken} read, {refused} refused");
}

/// Whatever was read is a path.
fn assert_sound(program: &gcode::GcodeProgram, most: usize) {
    let points = &program.path.points;
    assert!(points.len() <= most && points.len() == program.lines.len());
    assert_eq!(points.len(), program.machine.len());
    assert!(points.iter().all(|p| p.tip.is_finite() && (p.axis.length() - 1.0).abs() < 1e-9));
    assert!(points.iter().all(|p| p.feed >= 0.0 && p.time >= 0.0));
    assert!(points.windows(2).all(|pair| pair[1].time >= pair[0].time));
    assert!(program.lines.windows(2).all(|pair| pair[1] >= pair[0]));
    let limits =
        CheckOptions { clearance_plane: Some(10.0), max_feed: Some(5.0), ..Default::default() };
    let findings = gcode::check(program, &limits);
    assert!(findings.len() <= 8 * program.moves.len() + 1);
    assert!(findings.windows(2).all(|pair| pair[1].line >= pair[0].line));
}

#[test]
fn noise_is_no_program() {
    let mut random = Lcg(3);
    for _ in 0..ROUNDS {
        let length = random.below(200);
        let noise: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
        if let Ok(program) = gcode::read(&String::from_utf8_lossy(&noise), &ReadOptions::default())
        {
            assert_sound(&program, ReadOptions::default().max_points);
        }
    }
}
