/// Weighted sums over rides: weight, time, value and their products.
#[derive(Clone, Copy, Default)]
pub struct Sums {
    pub w: f64,
    pub t: f64,
    pub y: f64,
    tt: f64,
    ty: f64,
    yy: f64,
}

impl Sums {
    pub fn and(self, [t, y, w]: [f64; 3]) -> Self {
        Self {
            w: self.w + w,
            t: self.t + w * t,
            y: self.y + w * y,
            tt: self.tt + w * t * t,
            ty: self.ty + w * t * y,
            yy: self.yy + w * y * y,
        }
    }

    pub fn less(self, part: Self) -> Self {
        Self {
            w: self.w - part.w,
            t: self.t - part.t,
            y: self.y - part.y,
            tt: self.tt - part.tt,
            ty: self.ty - part.ty,
            yy: self.yy - part.yy,
        }
    }
}

/// Levels of groups of rides, with a common slope or none.
#[derive(Clone, Copy)]
pub struct Levels {
    /// Weighted squares that are left.
    pub left: f64,
    pub slope: f64,
    /// Weighted squares of the times about those of their groups: what the slope is known by; nothing without a slope.
    pub spread: f64,
}

impl Levels {
    pub fn of(groups: impl Iterator<Item = Sums>, sloped: bool) -> Self {
        let (mut yy, mut ty, mut tt) = (0.0, 0.0, 0.0);
        for g in groups {
            yy += g.yy - g.y * g.y / g.w;
            ty += g.ty - g.t * g.y / g.w;
            tt += g.tt - g.t * g.t / g.w;
        }
        match sloped && tt > 0.0 {
            true => Self {
                left: yy - ty * ty / tt,
                slope: ty / tt,
                spread: tt,
            },
            false => Self {
                left: yy,
                slope: 0.0,
                spread: 0.0,
            },
        }
    }
}
