//! What a click or a drag on the contact plate asks of a foot.

use crate::control::balance::AnkleStance;

/// What the user did to a foot on the plate, by the foot's number in the character.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlateAction {
    /// Clicked a segment: it shall touch, or no longer.
    Segment {
        /// The foot.
        foot: usize,
        /// The segment, as [`FootAnatomy::segments`](crate::control::foot::FootAnatomy::segments) counts them.
        segment: usize,
    },
    /// Dragged the ankle.
    Ankle {
        /// The foot.
        foot: usize,
        /// By how much upwards, m.
        rise: f64,
        /// By how much it rolled, rad; positive turns the sole outwards (inside tilt).
        roll: f64,
    },
    /// Put the ankle back to where the foot has it by itself.
    Straight {
        /// The foot.
        foot: usize,
    },
}

impl PlateAction {
    /// What two feet are asked after it, where they were asked `asked` before; `None` for another number of feet. That the body can stand so is not said:
    /// [`BalancePose::stance`](crate::engine::BalancePose::stance) tells.
    pub fn on(self, asked: &[AnkleStance]) -> Option<[AnkleStance; 2]> {
        let mut feet: [AnkleStance; 2] = asked.try_into().ok()?;
        match self {
            Self::Segment { foot, segment } => {
                let own = feet.get_mut(foot)?;
                let touches = own.touch.contains(segment);
                own.touch = if touches { own.touch.without(segment) } else { own.touch.with(segment) };
            }
            Self::Ankle { foot, rise, roll } => {
                let own = feet.get_mut(foot)?;
                *own = own.moved(rise, roll);
            }
            Self::Straight { foot } => {
                let own = feet.get_mut(foot)?;
                (own.rise, own.roll) = (0.0, 0.0);
            }
        }
        Some(feet)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::foot::SegmentSet;

    #[test]
    fn a_click_takes_a_segment_away_and_another_brings_it_back() {
        let before = [AnkleStance { touch: SegmentSet::of(&[1, 4]), ..AnkleStance::default() }; 2];
        let click = PlateAction::Segment { foot: 1, segment: 4 };
        let after = click.on(&before).unwrap();
        assert_eq!((after[0], after[1].touch), (before[0], SegmentSet::of(&[1])));
        assert_eq!(click.on(&after), Some(before));
        assert_eq!(click.on(&before[..1]), None, "there is no second foot");
    }

    #[test]
    fn a_drag_ends_where_an_ankle_can_be() {
        let drag = PlateAction::Ankle { foot: 0, rise: 1.0, roll: -1.0 };
        let after = drag.on(&[AnkleStance::default(); 2]).unwrap();
        assert_eq!((after[0].rise, after[0].roll), (AnkleStance::RISE.1, AnkleStance::ROLL.0));
        assert_eq!(PlateAction::Straight { foot: 0 }.on(&after), Some([AnkleStance::default(); 2]));
    }
}
