//! The tyre model: an isotropic brush whose bristles deflect, relax as the wheel rolls, and slide at the friction limit.
//!
//! Vectors are in the frame of the contact patch: forward and left of the robot, in the floor plane.

/// Parameters of a brush tyre, per unit of load, so that one tyre serves robots of any mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tyre {
    /// Slip stiffness of the tyre, `C/F_z`: its force per load and per unit of slip, at small slip.
    pub slip_stiffness: f64,
    /// Rolled distance in which a deflection of the bristles falls to 1/e.
    pub relaxation_length_m: f64,
    /// Ratio of viscous to elastic force of the rubber: the force is that of the deflection `u + damping_s·u̇`.
    pub damping_s: f64,
}

impl Default for Tyre {
    /// A tyre of solid rubber on a wheel of about 0.2 m diameter.
    fn default() -> Self {
        Tyre {
            // Road tyres have a slip stiffness of 10 to 30. With 25 the P3-DX slips by 0.24 % at 0.5 m/s²; half the stiffness doubles every slip.
            slip_stiffness: 25.0,
            // The relaxation length is about half the length of a contact patch, √(2·0.0975·0.0012) m, plus a part for the carcass. A shorter
            // length stiffens the body's oscillation on its tyres beyond what 1 ms steps resolve.
            relaxation_length_m: 0.02,
            // The damping slows the oscillation of a standing robot on its tyres, at 16 Hz, with a quarter of critical damping; it has no part in
            // steady forces.
            damping_s: 0.005,
        }
    }
}

impl Tyre {
    /// The tyre on a carpet's pile: the bristles of tyre and pile bend in series, `1/C = 1/C_tyre + 1/C_pile`.
    pub fn on_pile(self, pile_stiffness: f64) -> Tyre {
        Tyre { slip_stiffness: 1.0 / (1.0 / self.slip_stiffness + 1.0 / pile_stiffness), ..self }
    }

    /// Deflection from which the whole contact patch slides, `u_sl = ℓ·σ_sl` with `σ_sl = 3μ/(C/F_z)`.
    ///
    /// Pacejka, *Tire and Vehicle Dynamics*, section 3.2.3: `σ_sl = 1/θ`.
    pub fn sliding_deflection_m(&self, friction: f64) -> f64 {
        3.0 * friction * self.relaxation_length_m / self.slip_stiffness
    }

    /// Force of the contact patch on the robot for a deflection, along that deflection.
    ///
    /// `F = μF_z·(3s − 3s² + s³)` with `s = |u|/u_sl ≤ 1`, and `μF_z` beyond: the combined-slip brush of Pacejka, *Tire and Vehicle
    /// Dynamics*, section 3.2.3, with `s = θσ`, for a deflection `u = ℓσ`.
    pub fn force_n(&self, deflection_m: [f64; 2], friction: f64, load_n: f64) -> [f64; 2] {
        let sliding_m = self.sliding_deflection_m(friction);
        let length_m = norm(deflection_m);
        let s = length_m / sliding_m;
        // The force is computed per metre of deflection, so that a deflection of zero needs no case of its own.
        let stiffness_n_per_m = if s < 1.0 {
            friction * load_n * (3.0 - 3.0 * s + s * s) / sliding_m
        } else {
            friction * load_n / length_m
        };
        deflection_m.map(|component_m| stiffness_n_per_m * component_m)
    }
}

/// Deflection of a wheel's tyre bristles: the distance by which the floor holds them back.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Patch {
    deflection_m: [f64; 2],
    rate_m_per_s: [f64; 2],
}

/// Conditions that a tyre's contact patch meets during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Velocity of the robot over the floor at the contact patch.
    pub velocity_m_per_s: [f64; 2],
    /// Vertical force of the floor on the wheel.
    pub load_n: f64,
    /// Friction coefficient of the floor under the contact patch.
    pub friction: f64,
    /// Displacement of a carpet's nap under the contact patch for every metre rolled.
    pub nap: [f64; 2],
}

impl Patch {
    /// Present deflection of the bristles: how far the floor holds them back, the negative of the displacement of the rim against the floor.
    pub fn deflection_m(&self) -> [f64; 2] {
        self.deflection_m
    }

    /// Present force of the floor on the wheel.
    pub fn force_n(&self, tyre: &Tyre, contact: &Contact) -> [f64; 2] {
        let strained_m = [0, 1].map(|axis| self.deflection_m[axis] + tyre.damping_s * self.rate_m_per_s[axis]);
        tyre.force_n(strained_m, contact.friction, contact.load_n)
    }

    /// Advances the tyre's bristles by one step.
    ///
    /// `u̇ = −V_s − |V_r|/ℓ·u` with the sliding velocity `V_s = V − (V_r, 0)` and the rolling speed `V_r = RΩ`: Pacejka, *Tire and Vehicle
    /// Dynamics*, chapter 7 (single contact point). The steady state is the slip `σ = u/ℓ = −V_s/|V_r|`. On a nap that lies down by d per
    /// metre rolled, the sliding velocity is `V − (V_r, 0) − d·|V_r|`, so that a tyre without force drifts by d.
    pub fn advance(&mut self, tyre: &Tyre, contact: &Contact, rolling_m_per_s: f64, step_s: f64) {
        let over_nap_m_per_s =
            [0, 1].map(|axis| contact.velocity_m_per_s[axis] - contact.nap[axis] * rolling_m_per_s.abs());
        let sliding_m_per_s = [over_nap_m_per_s[0] - rolling_m_per_s, over_nap_m_per_s[1]];
        // The relaxation of the bristles is integrated implicitly, so that any step keeps the steady state exact and the decay monotone.
        let relaxation = 1.0 + rolling_m_per_s.abs() / tyre.relaxation_length_m * step_s;
        let before_m = self.deflection_m;
        let mut after_m = [0, 1].map(|axis| (before_m[axis] - sliding_m_per_s[axis] * step_s) / relaxation);
        // The bristles of a contact patch that slides bend no further than this. Without the cap a patch that reverses would first have to slide
        // back by all that its bristles had bent too far.
        let excess = norm(after_m) / tyre.sliding_deflection_m(contact.friction);
        if excess > 1.0 {
            after_m = after_m.map(|component_m| component_m / excess);
        }
        self.deflection_m = after_m;
        self.rate_m_per_s = [0, 1].map(|axis| (after_m[axis] - before_m[axis]) / step_s);
    }
}

fn norm(vector: [f64; 2]) -> f64 {
    (vector[0] * vector[0] + vector[1] * vector[1]).sqrt()
}
