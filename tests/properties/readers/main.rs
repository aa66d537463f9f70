//! Small files of every format, damaged at random places (the same ones every time), are read or refused: see
//! `evencut_fuzz`. `cargo xtask fuzz` looks for harder ones, for as long as it is told.

mod damage;

use damage::{Lcg, damaged, noise};
use evencut_fuzz::{Counts, MOST_MEMORY, TARGETS, Target, watched};
use evencut_tests::shared_data;
use std::alloc::System;
use std::path::{Path, PathBuf};

#[global_allocator]
static MEMORY: cap::Cap<System> = cap::Cap::new(System, MOST_MEMORY);

/// Inputs without any order among those of a reader.
const NOISE: usize = 1000;

/// The reader of that name.
fn target(name: &str) -> Target {
    *TARGETS.iter().find(|target| target.name == name).unwrap()
}

/// All files of folders, in order.
fn files(folders: &[PathBuf]) -> Vec<Vec<u8>> {
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap());
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

fn run(target: Target, inputs: impl Iterator<Item = Vec<u8>> + Send + 'static) -> Counts {
    watched(target, Path::new(env!("CARGO_TARGET_TMPDIR")), inputs)
}

/// Gives a reader damaged files and noise.
fn damaged_files(name: &str, rounds: usize) {
    let target = target(name);
    let (sound, odd) = (files(&target.seeds()), files(&target.odd()));
    let mut random = Lcg(1);
    let inputs = (0..rounds + NOISE).map(move |round| {
        if round < NOISE {
            return noise(&mut random);
        }
        let files = if random.below(4) > 0 || odd.is_empty() { &sound } else { &odd };
        damaged(&files[random.below(files.len())], &mut random)
    });
    let Counts { read, refused } = run(target, inputs);
    println!("{name}: {read} read, {refused} refused");
    // Both ways are well travelled.
    assert!(
        read >= rounds / 100 && refused >= rounds / 3,
        "{name}: {read} read, {refused} refused"
    );
}

#[test]
fn sound_files_are_read() {
    for target in TARGETS {
        let seeds = files(&target.seeds());
        assert!(!seeds.is_empty(), "{}", target.name);
        let count = seeds.len();
        assert_eq!(run(target, seeds.into_iter()).read, count, "{}", target.name);
    }
}

#[test]
fn damaged_jobs_are_read_or_refused() {
    damaged_files("job", 6_000);
}

#[test]
fn damaged_nurbs_surfaces_are_read_or_refused() {
    damaged_files("nurbs", 4_000);
}

#[test]
fn damaged_obj_files_are_read_or_refused() {
    damaged_files("obj", 4_000);
}

#[test]
fn damaged_off_files_are_read_or_refused() {
    damaged_files("off", 4_000);
}

#[test]
fn damaged_ply_files_are_read_or_refused() {
    damaged_files("ply", 12_000);
}

#[test]
fn damaged_posts_are_read_or_refused() {
    damaged_files("post", 4_000);
}

#[test]
fn damaged_programs_are_read_or_refused() {
    damaged_files("program", 10_000);
}

#[test]
fn damaged_step_files_are_read_or_refused() {
    damaged_files("step", 3_000);
}

#[test]
fn damaged_stl_files_are_read_or_refused() {
    damaged_files("stl", 8_000);
}

#[test]
fn damaged_tables_of_paths_are_read_or_refused() {
    damaged_files("toolpath", 8_000);
}

#[test]
fn damaged_libraries_of_tools_are_read_or_refused() {
    damaged_files("tools", 4_000);
}

#[test]
fn real_files_cut_off_anywhere_are_read_or_refused() {
    let Some(data) = shared_data() else { return };
    let cut_off = [
        ("stl", "mesh/carpet_110.stl"),
        ("off", "mesh/capsule_2holes.off"),
        ("obj", "mesh/hecc_hub_passage_coarse.obj"),
        ("ply", "nasty/hemi_big_endian.ply"),
        ("ply", "nasty/hemi_extra_props.ply"),
        ("stl", "nasty/hemi_ascii_odd.stl"),
        ("ply", "nasty/as_cube_binary.ply"),
        ("obj", "nasty/hemi_quads_neg.obj"),
    ];
    for (name, file) in cut_off {
        let bytes = std::fs::read(data.join(file)).unwrap();
        let step = 1 + bytes.len() / 700;
        let pieces = (0..bytes.len()).step_by(step).map(move |length| bytes[..length].to_vec());
        assert!(run(target(name), pieces).refused > 0, "{file}");
    }
}
