//! What must hold of whatever comes, one program for all, so that no core waits for another: of every job, its path and
//! its files; of whole parts, regions, walls, textures and programs; of the imports of `core`.

mod architecture;
mod avoid;
mod cusps;
mod entries;
mod gcode;
mod hub;
mod jobs;
mod parts;
mod regions;
mod removal_rate;
mod steady_load;
mod stock;
mod tensor;
mod texture;
mod time;
mod walls;
