//! Terms of a task: what a policy sees and says, one variant and one place each. A term says how many numbers it has for a character, how they
//! are written, what their mirror image is, and the line that it gives to the policy's contract; layout, mirror table and contract
//! are derived from the list of terms.

mod gains;
mod image;
mod layout;
mod mirror;
mod observation;

pub use gains::GainTerm;
pub use layout::ObservationLayout;
pub use mirror::PolicyMirror;
pub use observation::ObservationTerm;
pub(crate) use observation::{BodyFrame, View};
