//! Sets of the segments of a foot.

/// Most links of a foot that the controller poses.
pub const MOST_SEGMENTS: usize = 8;

/// A set of segments of one foot, by their index in [`FootAnatomy::segments`](super::FootAnatomy::segments).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SegmentSet(u8);

impl SegmentSet {
    /// No segment: the foot is in the air.
    pub const NONE: Self = Self(0);

    /// The segments with these indices; those from [`MOST_SEGMENTS`] on are left out.
    pub fn of(indices: &[usize]) -> Self {
        indices.iter().fold(Self::NONE, |set, &index| set.with(index))
    }
    /// This set and the segment with this index.
    pub fn with(self, index: usize) -> Self {
        if index < MOST_SEGMENTS { Self(self.0 | 1 << index) } else { self }
    }
    /// This set without the segment with this index.
    pub fn without(self, index: usize) -> Self {
        if index < MOST_SEGMENTS { Self(self.0 & !(1 << index)) } else { self }
    }
    /// Segments that are in both.
    pub fn both(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
    /// Segments that are in either.
    pub fn either(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    /// Whether the segment with this index is in it.
    pub fn contains(self, index: usize) -> bool {
        index < MOST_SEGMENTS && self.0 & 1 << index != 0
    }
    /// Whether it has none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
    /// Number of segments in it.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }
    /// Indices, ascending.
    pub fn iter(self) -> impl Iterator<Item = usize> {
        (0..MOST_SEGMENTS).filter(move |&k| self.contains(k))
    }
    /// As a number of eight bits, bit k for segment k.
    pub fn bits(self) -> u8 {
        self.0
    }
    /// The set with these bits.
    pub fn from_bits(bits: u8) -> Self {
        Self(bits)
    }
}

/// The four basic poses of a foot (Park, Yu, Lee 2018, Figure 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BasicPose {
    /// All that stands in the zero pose.
    Rest,
    /// The toes alone.
    Tiptoe,
    /// Heel and medial toes: the sole looks outwards.
    InsideTilt,
    /// Heel, lateral metatarsals and lateral toes: the sole looks inwards.
    OutsideTilt,
}

impl BasicPose {
    /// All four.
    pub const ALL: [BasicPose; 4] = [Self::Rest, Self::Tiptoe, Self::InsideTilt, Self::OutsideTilt];

    /// Its name, such as `inside_tilt`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Tiptoe => "tiptoe",
            Self::InsideTilt => "inside_tilt",
            Self::OutsideTilt => "outside_tilt",
        }
    }

    /// The pose with this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|p| p.name() == name)
    }
}
