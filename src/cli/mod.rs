//! What the `athlete` command line is made of, for programs that want the same (feature `cli`).
//!
//! | item | what it does |
//! | --- | --- |
//! | [`ArgumentError`], [`within`], [`exit_code`] | wrong arguments: option, what was given, what would be valid |
//! | [`check_output`], [`check_folder`], [`keep_earlier`], [`write_whole`] | results: places tried before the work, nothing replaced unasked |
//! | [`load_character`] | a preset's name or a `.character.ron` file to a model |
//! | [`find_key_poses`] | the key pose file of a skill |
//! | [`load_motion`] | a `.bvh` or `.clip.ron` file to a clip for a character |
//! | [`WorldSpec`] | the worlds that have a name: `ice`, `ground`, `slope:10` ... |
//! | [`ChosenWorld`] | one of those with a course on it: `--course FILE --set height=0.5` |
//! | [`Push`] | a force on a link for a while: `pelvis:0,0,-50:0.5:0.2` |
//! | [`perform`] | simulates a motion (plain stable PD) or a control and measures it |
//! | [`run_course`] | runs a course of obstacles from a disturbed start |
//! | [`random_course`], [`single_obstacle`] | courses of the kinds and sizes that a runner's skills clear |
//! | [`run_program`] | performs a program of skills from a disturbed start |
//! | [`load_trained_skill`] | a skill with its motion and its policy |
//! | [`skill_of_policy`] | the skill of a policy, from what lies in its folder |
//! | [`skill_export`] | from what a training left to the files of a skill |
//! | [`FrameRecorder`] | instants of a performance for a storyboard |
//! | [`clip_frames`], [`key_pose_frames`] | instants of a motion that nothing simulates, for a storyboard |
//! | [`map_picture`] | the skeleton of a file beside the character that follows it, for a storyboard |
//! | [`basic_poses`], [`foot_alone`], [`foot_frames`] | one foot by itself in its basic poses, for a storyboard |
//! | [`feet`] | feet of several segments against feet of two: episodes of standing, the largest disturbance held |
//! | [`gait`] | gait analysis of a trained walk, beside tables of people |
//! | [`time_scene`] | microseconds per character and step |
//! | [`character_table`] | links, masses, joints and contact points as plain data |

mod arguments;
mod chosen_world;
mod course_run;
pub mod feet;
mod find_key_poses;
mod foot_picture;
mod frames;
pub mod gait;
mod info;
mod input;
mod input_error;
mod map_picture;
mod motion_frames;
mod output;
mod perform;
mod policy_folder;
mod program_run;
mod push;
mod random_course;
mod skill_export;
mod skills;
mod timing;
mod world_spec;

pub use arguments::{ArgumentError, FAILED, STOPPED, Stopped, WRONG_ARGUMENTS, exit_code, threads, within};
pub use chosen_world::{ChosenWorld, Setting, WorldChoiceError, course_scenery};
pub use course_run::{CourseEnd, CourseRun, CourseTask, run_course};
pub use find_key_poses::find_key_poses;
pub use foot_picture::{PosedFoot, basic_poses, foot_alone, foot_frames};
pub use frames::FrameRecorder;
pub use info::{CharacterTable, FootRow, LinkRow, PointRow, character_table};
pub use input::{load_character, load_motion, load_motion_with};
pub use input_error::InputError;
pub use map_picture::{MapPicture, map_picture};
pub use motion_frames::{clip_frames, key_pose_frames};
pub use output::{check_folder, check_output, keep_earlier, trace_bytes, write_whole};
pub use perform::{PerformError, PerformOptions, PerformanceReport, Script, perform, perform_on};
pub use policy_folder::{PolicyFolderError, check_motion, skill_beside, skill_of_policy};
pub use program_run::{ProgramRun, run_program};
pub use push::Push;
pub use random_course::{RandomCourse, random_course, single_obstacle};
pub use skill_export::{CARD_FILE, POLICY_FILE, SkillExport, SkillExportError, skill_export};
pub use skills::{
    SKILLS_FOLDER, SkillInputError, TellMotion, find_program, find_skill, load_task, load_task_with,
    load_trained_skill, load_trained_skill_with,
};
pub use timing::{BenchRow, LANE_NAMES, time_scene};
pub use world_spec::WorldSpec;
