//! Real files of the shared data; skipped where it is not present.

use super::*;
use crate::geometry::{DMat3, DVec3};
use crate::nurbs::MeshOptions;

#[test]
fn faces_of_real_files_mesh() {
    let Some(folder) = crate::shared_data::shared_data("step") else { return };
    // Faces, and how many of them are known not to mesh: loops that touch, edges off the surface.
    let files = [
        ("car_hood_capot.step", 18, 0),
        ("component8.step", 21, 0),
        ("drone_propeller.step", 20, 0),
        ("hecc_one_main_one_splitter.step", 14, 2),
        ("mainbody_back.stp", 31, 0),
        ("bladex_propeller_hub_one_blade.step", 10, 2),
    ];
    for (name, count, most_unusable) in files {
        let file = StepFile::read(&std::fs::read(folder.join(name)).unwrap()).unwrap();
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
        assert_eq!(file.faces().len(), count, "{name}");
        assert!(unusable <= most_unusable, "{name}: {unusable}");
    }
}

/// One face of a B-spline surface, 10 inches square and bent, without loops.
const SQUARE: &str = "ISO-10303-21;
HEADER;
FILE_NAME('a;''b');
ENDSEC;
DATA;
#1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#2=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#1);
#3=(CONVERSION_BASED_UNIT('INCH',#2)LENGTH_UNIT()NAMED_UNIT($));
#4=(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNIT_ASSIGNED_CONTEXT((#3)));
#10=CARTESIAN_POINT('',(0.,0.,0.));
#11=CARTESIAN_POINT('',(5.,0.,1.));
#12=CARTESIAN_POINT('',(10.,0.,0.));
#13=CARTESIAN_POINT('',(0.,10.,0.));
#14=CARTESIAN_POINT('',(5.,10.,1.));
#15=CARTESIAN_POINT('',(10.,10.,0.));
#62=B_SPLINE_SURFACE_WITH_KNOTS('',2,1,((#10,#13),(#11,#14),(#12,#15)),.UNSPECIFIED.,
.F.,.F.,.F.,(3,3),(2,2),(0.,1.),(0.,1.),.UNSPECIFIED.);
#63=ADVANCED_FACE('',(),#62,.T.); /* a comment */
#64=OPEN_SHELL('',(#63));
ENDSEC;
END-ISO-10303-21;
";

#[test]
fn inches_are_understood() {
    let file = StepFile::read(SQUARE.as_bytes()).unwrap();
    assert_eq!((file.faces().len(), file.faces()[0].kind.as_str()), (1, "B-spline"));
    // The parabola through (0, 0), (5, 1/2), (10, 0) is 10.066 long.
    let area = file.area(0).unwrap();
    assert!((area / (25.4 * 25.4 * 100.66) - 1.0).abs() < 2e-3, "{area}");
    let error = file.choose(Some(2), false).unwrap_err().to_string();
    assert!(error.contains("has 1 faces: 1 B-spline"), "{error}");
}
