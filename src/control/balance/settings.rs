//! What the balance controller is tuned by.

/// How forces of the ground are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BalanceMethod {
    /// As published: the wished centre of pressure is kept inside the hull, and the wrench there is shared among the segments.
    Pressure,
    /// The forces at the points are unknowns, unilateral and inside friction cones; momentum changes by what they can give (after Lee,
    /// Goswami 2012, "A momentum-based balance controller for humanoid robots on non-level and non-stationary ground").
    Cones,
}

impl BalanceMethod {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pressure => "pressure",
            Self::Cones => "cones",
        }
    }
}

/// Gains, weights and rates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BalanceSettings {
    /// How forces of the ground are chosen.
    pub method: BalanceMethod,
    /// Decisions per second; accelerations and forces are held in between, torques are worked out anew at every step.
    pub rate: f64,
    /// Gain of a supporting segment's place and rotation, 1/s^2; the damping is `2 sqrt` of it (k_s of equation 7).
    pub support: f64,
    /// The same of a segment that shall touch and is still in the air, 1/s^2.
    pub landing: f64,
    /// Compliance of the rows of supports; weights of tracking are 1.
    pub support_compliance: f64,
    /// Gain of the centre of mass, 1/s^2; damping `2 sqrt` of it times `linear_damping`.
    pub linear: f64,
    /// Part of the critical damping of the centre of mass.
    pub linear_damping: f64,
    /// Gain of the trunk's uprightness in the wished angular momentum, 1/s^2.
    pub upright: f64,
    /// Damping of the angular momentum, 1/s.
    pub angular: f64,
    /// Gain of joints towards the posture, 1/s^2; damping `2 sqrt` of it.
    pub tracking: f64,
    /// How far outside the support the pivot of the level force may lie, m: the reach of the hip strategy.
    pub hip: f64,
    /// What a newton of missing lift counts for against one along the ground: with little, a body that stands on a corner of its support
    /// sinks onto the rest of it instead of being thrown over.
    pub upward_weight: f64,
    /// What a newton metre of missing moment about the middle of the support counts for against a newton of missing force, 1/m^2.
    pub moment_weight: f64,
    /// Steps that are taken to catch a fall, where standing no longer helps; 0 for none.
    pub steps: u32,
    /// Gain of a swinging foot's place, 1/s^2, critically damped.
    pub swing: f64,
    /// Coefficient of friction that the controller counts on.
    pub friction: f64,
    /// Distance of a point from the ground below which it carries, m; the less the nearer to it.
    pub contact: f64,
    /// Distance of a sole from the ground above which its segment counts as in the air, m.
    pub flying: f64,
    /// Way by which points are drawn to the middle of the support, as a part of the way there.
    pub margin: f64,
    /// Bend of the knees in the posture, rad: straight legs cannot move the body up or down.
    pub knee: f64,
    /// Damping of joints about the velocities that the accelerations lead to, as a part of the character's own servo damping.
    pub damping: f64,
    /// The same for joints of feet.
    pub foot_damping: f64,
    /// Stiffness of the joints of feet beyond the ankle about the pose that foot pose control asks for, as a part of the character's own.
    pub foot_stiffness: f64,
}

impl Default for BalanceSettings {
    fn default() -> Self {
        Self {
            method: BalanceMethod::Cones,
            rate: 150.0,
            support: 100.0,
            landing: 900.0,
            support_compliance: 1e-3,
            linear: 25.0,
            linear_damping: 1.0,
            upright: 20.0,
            angular: 6.0,
            tracking: 40.0,
            hip: 0.1,
            upward_weight: 0.003,
            moment_weight: 1.0,
            steps: 3,
            swing: 900.0,
            friction: 0.5,
            contact: 0.008,
            flying: 0.001,
            margin: 0.03,
            knee: 0.15,
            damping: 1.0,
            foot_damping: 0.3,
            foot_stiffness: 1.0,
        }
    }
}

impl BalanceSettings {
    /// The rates and gains that Park, Yu, Lee 2018 name: decisions at 30 per second, k_s = 28, the wrench at the centre of pressure, no step.
    pub fn published() -> Self {
        Self { method: BalanceMethod::Pressure, rate: 30.0, support: 28.0, steps: 0, ..Self::default() }
    }
}
