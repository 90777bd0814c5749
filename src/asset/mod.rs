pub mod bvh;
mod bvh_parse;
pub mod clip;
mod clip_edit;
mod clip_file;
pub mod joint_map;
pub(crate) mod turn;
