//! Every mesh file of the shared set has a verdict: accepted with what was repaired, or refused
//! with a reason.

use std::path::Path;
use std::time::{Duration, Instant};

use evencut_core::geometry::DVec3;
use evencut_core::job::Component;
use evencut_core::mesh::{MeshFormat, TriangleSoup, read};
use evencut_core::surface::{Built, build};
use evencut_tests::{as_it_is, shared_data};

/// Longest that any file may take.
const LONGEST: Duration = Duration::from_secs(10);

enum Verdict {
    /// Vertices, faces, boundary loops, and a part of every warning in order.
    Accepted(usize, usize, usize, &'static [&'static str]),
    /// Parts of the message.
    Refused(&'static [&'static str]),
}
use Verdict::{Accepted, Refused};

const CLOSED: &str = "without boundary";
const EDGES: &str = "non-manifold edges";
const VERTICES: &str = "non-manifold vertices";

/// File, verdict. Counts are those of the shared set's MANIFEST after its checker's welding.
const NASTY: &[(&str, Verdict)] = &[
    ("as_3DSMaxExport.STL", Refused(&["24 connected pieces", CLOSED, EDGES, ": 16, e.g. at ("])),
    ("as_OutOfMemory.off", Refused(&["line 2", "353535235358 vertices", "288 bytes"])),
    ("as_box_UTF16BE.obj", Refused(&["UTF-16"])),
    ("as_box_longline.obj", Refused(&[CLOSED])),
    ("as_cube_binary.ply", Refused(&[CLOSED])),
    ("as_cube_binary_header_with_RN_newline.ply", Refused(&[CLOSED])),
    ("as_empty.obj", Refused(&["empty file"])),
    ("as_empty.ply", Refused(&["empty file"])),
    ("as_malformed.obj", Refused(&["line 28", "0 is not an OBJ index"])),
    ("as_number_formats.obj", Refused(&["line 11", "3.1+e2", "z coordinate"])),
    ("as_testmixed.obj", Refused(&[CLOSED])),
    ("as_triangle_with_empty_solid.stl", Accepted(3, 1, 1, &["too coarse"])),
    ("as_triangle_with_two_solids.stl", Refused(&["2 connected pieces"])),
    ("bff_box.obj", Refused(&[CLOSED])),
    ("bff_teapot.obj", Refused(&["connected pieces", VERTICES])),
    ("cylinder_open.stl", Accepted(1280, 2432, 2, &[])),
    ("gc_fan3.obj", Refused(&[EDGES, ": 1, e.g. at (0, 0, 0)"])),
    ("gc_hourglass_ico.obj", Refused(&["2 connected pieces", CLOSED, VERTICES])),
    ("gc_lego.ply", Accepted(1649, 3072, 1, &[])),
    ("gc_moebius.obj", Refused(&["non-orientable"])),
    ("gismo_half-sphere-sheet.stl", Refused(&["connected pieces", EDGES, VERTICES])),
    ("header_only.stl", Refused(&["no face"])),
    ("hemi_all_inverted.stl", Accepted(145, 256, 1, &["surface.flip"])),
    ("hemi_ascii_comma.stl", Refused(&["line 4", "0,0000000e+00"])),
    ("hemi_ascii_odd.stl", Accepted(61, 90, 1, &[])),
    ("hemi_ascii_zero_normals.stl", Accepted(61, 90, 1, &[])),
    ("hemi_bad_index.obj", Refused(&["line 150", "vertex index 163", "at most 145"])),
    ("hemi_big_endian.ply", Accepted(145, 256, 1, &[])),
    ("hemi_bowtie.obj", Refused(&["2 connected pieces", VERTICES, ": 1, e.g. at (0, 50, 0)"])),
    ("hemi_crack.obj", Refused(&["2 connected pieces", "close the cracks"])),
    ("hemi_dup_faces.obj", Accepted(145, 256, 1, &["20 duplicate faces"])),
    ("hemi_extra_props.ply", Accepted(61, 90, 1, &[])),
    ("hemi_fin.obj", Refused(&[EDGES, ": 1, e.g. at (0, -49.5196, 4.87725)"])),
    ("hemi_flipped30.obj", Accepted(145, 256, 1, &["67 faces turned over"])),
    ("hemi_hole.obj", Accepted(144, 248, 2, &[])),
    ("hemi_huge_offset.obj", Accepted(145, 256, 1, &["from the origin"])),
    ("hemi_huge_offset.stl", Accepted(145, 256, 1, &["resolve only 2.38419 mm"])),
    ("hemi_inf_vertex.stl", Refused(&["byte 646", "inf", "triangle 11"])),
    ("hemi_nan_vertex.obj", Refused(&["line 9", "NaN"])),
    ("hemi_overcount.stl", Refused(&["4294967295 triangles", "room for 256.00"])),
    ("hemi_quads_neg.obj", Accepted(108, 176, 1, &[])),
    ("hemi_repeated_index.obj", Accepted(145, 256, 1, &["20 faces that repeat a vertex"])),
    ("hemi_solid_header.stl", Accepted(145, 256, 1, &[])),
    ("hemi_soup.obj", Accepted(145, 256, 1, &[])),
    ("hemi_tiny_units.obj", Accepted(145, 256, 1, &["only 0.00015 mm across"])),
    ("hemi_truncated.stl", Refused(&["256 triangles", "room for 85.46", "cut off"])),
    ("hemi_two_disks.stl", Refused(&["2 connected pieces"])),
    ("hemi_unreferenced.obj", Accepted(145, 256, 1, &["200 unused vertices"])),
    ("hemi_zero_area.obj", Accepted(124, 214, 1, &["42 faces that repeat", "20 creases"])),
    ("hemi_zero_index.obj", Refused(&["line 147", "0 is not an OBJ index"])),
    ("igl_cube_with_fold.ply", Refused(&[CLOSED])),
    ("igl_degenerated.obj", Refused(&[EDGES, ": 6,"])),
    ("igl_truck.obj", Refused(&["connected pieces", EDGES, ": 54,", VERTICES, ": 55,"])),
    ("not_a_mesh.stl", Refused(&["not an STL file"])),
    ("ocl_failedinpycam.stl", Refused(&[CLOSED])),
    ("ocl_mount_rush.stl", Refused(&["6 connected pieces", EDGES, VERTICES])),
    ("pmp_beetle_binary.off", Refused(&["binary OFF"])),
    ("tm_multibody.stl", Refused(&["2 connected pieces", CLOSED])),
    ("tm_negative_indices.obj", Refused(&[CLOSED])),
    ("tm_not_convex.obj", Refused(&[CLOSED])),
    ("tm_points_emptyface.ply", Refused(&["no face"])),
    ("tm_shared.STL", Refused(&[EDGES, ": 1,"])),
    ("tm_soup.stl", Refused(&["100 connected pieces"])),
    ("tm_stl_empty_bin.stl", Refused(&["no face"])),
    ("tm_whitespace.off", Refused(&[CLOSED])),
];

/// File, vertices, faces, boundary loops by their number of vertices.
const GOOD: &[(&str, usize, usize, &[usize])] = &[
    ("aorta.stl", 6278, 12455, &[30, 23, 21, 21, 12]),
    ("botanic_garden.off", 1121, 2152, &[88]),
    ("camelhead.off", 11381, 22704, &[56]),
    ("capsule_2holes.off", 89, 152, &[16, 8, 4]),
    ("carpet_110.stl", 75, 110, &[38]),
    ("cowhead.ply", 15049, 29999, &[97]),
    ("demosthenes.obj", 8394, 16719, &[67]),
    ("hecc_hub_passage_coarse.obj", 960, 1696, &[222]),
    ("hecc_hub_passage_coarse.stl", 960, 1696, &[222]),
    ("hecc_hub_passage_fine.obj", 5008, 9449, &[565]),
    ("hecc_hub_passage_splitter_coarse.obj", 990, 1637, &[222, 121]),
    ("hecc_hub_passage_splitter_coarse.stl", 990, 1637, &[222, 121]),
    ("hecc_hub_passage_splitter_fine.obj", 4730, 8592, &[565, 303]),
    ("hemisphere.obj", 2051, 4000, &[100]),
    ("hood_panel_120k.ply", 60752, 120588, &[914]),
    ("lilium.obj", 3389, 6590, &[186]),
    ("mask_face.ply", 17157, 34144, &[168]),
    ("mountain.ply", 25600, 50562, &[636]),
    ("plane_26holes.obj", 8519, 16747, &[28, 13, 12, 12, 12]),
    ("train_station.off", 1753, 3330, &[162, 14]),
];

fn parse(path: &Path, bytes: &[u8]) -> Result<TriangleSoup, String> {
    let name = path.to_string_lossy();
    let format = MeshFormat::from_name(&name).ok_or("no mesh format")?;
    read(bytes, format).map_err(|e| e.to_string())
}

fn load(path: &Path) -> Result<Built, String> {
    let soup = parse(path, &std::fs::read(path).map_err(|e| e.to_string())?)?;
    build(soup, &as_it_is(Component::Only)).map_err(|e| e.to_string())
}

/// What speaks against the verdict, if anything does.
fn objection(outcome: Result<Built, String>, verdict: &Verdict) -> Option<String> {
    match (outcome, verdict) {
        (Ok(built), Accepted(vertices, faces, loops, parts)) => {
            let c = built.surface.connectivity();
            let counts = (c.vertex_count(), c.face_count(), c.boundary_loops().len());
            let told: Vec<String> = built.warnings.iter().map(|w| w.to_string()).collect();
            let agree = told.len() == parts.len()
                && told.iter().zip(*parts).all(|(told, part)| told.contains(part));
            (counts != (*vertices, *faces, *loops) || !agree)
                .then(|| format!("accepted as {counts:?} with {told:?}"))
        }
        (Err(message), Refused(parts)) => {
            (!parts.iter().all(|part| message.contains(part))).then(|| format!("said: {message}"))
        }
        (Ok(built), Refused(_)) => Some(format!("accepted with {:?}", built.warnings)),
        (Err(message), Accepted(..)) => Some(format!("refused: {message}")),
    }
}

#[test]
fn every_nasty_file_has_its_verdict() {
    let Some(data) = shared_data() else { return };
    let mut objections = Vec::new();
    for (name, verdict) in NASTY {
        let start = Instant::now();
        let outcome = load(&data.join("nasty").join(name));
        if start.elapsed() > LONGEST {
            objections.push(format!("{name}: {:?}", start.elapsed()));
        }
        objections.extend(objection(outcome, verdict).map(|text| format!("{name}: {text}")));
    }
    for entry in std::fs::read_dir(data.join("nasty")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if !NASTY.iter().any(|(known, _)| *known == name) {
            objections.push(format!("{name}: no verdict"));
        }
    }
    assert!(objections.is_empty(), "{}", objections.join("\n"));
}

#[test]
fn what_a_selection_leaves_of_any_file_is_sound_or_refused() {
    let Some(data) = shared_data() else { return };
    let mut options = as_it_is(Component::Largest);
    options.select.normal_within = Some((75_f64.to_radians(), DVec3::Z));
    let files = NASTY.iter().map(|(name, _)| data.join("nasty").join(name));
    let mut accepted = 0;
    for path in files.chain(GOOD.iter().map(|(name, ..)| data.join("mesh").join(name))) {
        let Ok(soup) = parse(&path, &std::fs::read(&path).unwrap()) else { continue };
        let Ok(built) = build(soup, &options) else { continue };
        let c = built.surface.connectivity();
        let loops = c.boundary_loops().len() as i64;
        assert!(loops > 0 && c.euler_characteristic() == 2 - loops, "{}", path.display());
        accepted += 1;
    }
    assert!(accepted > 50, "{accepted}");
}

#[test]
fn every_good_mesh_has_the_topology_of_the_manifest() {
    let Some(data) = shared_data() else { return };
    for (name, vertices, faces, longest_loops) in GOOD {
        let built = load(&data.join("mesh").join(name)).unwrap();
        let c = built.surface.connectivity();
        assert_eq!((c.vertex_count(), c.face_count()), (*vertices, *faces), "{name}");
        let mut loops: Vec<usize> = c.boundary_loops().iter().map(Vec::len).collect();
        loops.sort_unstable_by(|a, b| b.cmp(a));
        assert_eq!(loops[..longest_loops.len()], **longest_loops, "{name}");
        let holes = if *name == "plane_26holes.obj" { 27 } else { longest_loops.len() };
        assert_eq!(loops.len(), holes, "{name}");
        assert_eq!(built.texture.is_some(), name.starts_with("hecc") && name.ends_with("obj"));
        assert_eq!(built.part.faces.len(), *faces);
    }
}

#[test]
fn curvature_of_every_good_mesh_is_finite() {
    let Some(data) = shared_data() else { return };
    for (name, ..) in GOOD {
        let built = load(&data.join("mesh").join(name)).unwrap();
        let field = built.surface.curvature(None);
        assert!(field.operators().iter().all(|o| o.k.iter().all(|k| k.is_finite())), "{name}");
        assert_eq!(field.poor(), 0, "{name}");
    }
}
