//! What acts on an axle beside its spring and damper. The integrator is compiled for nothing, for each effect by itself, and for
//! lists, since choosing the effect again in every step would take longer than the step.

use std::hint::black_box;
use std::marker::PhantomData;

use super::axle::{EffectLanes, MAX_EFFECTS};
use crate::law::{Effect, LaneValues, Motion, States};
use veloid_core::numerics::lanes::Lanes;

pub(super) trait Laws {
    /// Where a wheel of its own, which stands on the tyre in place of the mass, has its states.
    fn wheel(&self) -> Option<usize>;

    /// What the effects make of the tyre's force and of the others on the mass.
    fn forces<const S: usize>(&self, m: &Motion, x: &[Lanes; S], forces: [Lanes; 2]) -> [Lanes; 2];

    /// The acceleration under a `force`, with the rates of the effects' own states written to `out`; the tyre's force moves a
    /// wheel of its own.
    fn moved<const S: usize>(
        &self,
        m: &Motion,
        x: &[Lanes; S],
        force: Lanes,
        tyre: Lanes,
        out: &mut [Lanes; S],
    ) -> Lanes;
}

pub(super) struct Nothing;

impl Laws for Nothing {
    #[inline(always)]
    fn wheel(&self) -> Option<usize> {
        None
    }

    #[inline(always)]
    fn forces<const S: usize>(&self, _: &Motion, _: &[Lanes; S], forces: [Lanes; 2]) -> [Lanes; 2] {
        forces
    }

    #[inline(always)]
    fn moved<const S: usize>(
        &self,
        _: &Motion,
        _: &[Lanes; S],
        force: Lanes,
        _: Lanes,
        _: &mut [Lanes; S],
    ) -> Lanes {
        force
    }
}

/// One effect, whose states follow the mass's.
pub(super) struct One<'a, E> {
    values: &'a LaneValues,
    effect: PhantomData<E>,
}

impl<'a, E> One<'a, E> {
    pub fn of(effect: &'a EffectLanes) -> Self {
        Self {
            values: &effect.values,
            effect: PhantomData,
        }
    }
}

impl<E: Effect> Laws for One<'_, E> {
    #[inline(always)]
    fn wheel(&self) -> Option<usize> {
        E::SPEC.carries.then_some(2)
    }

    #[inline(always)]
    fn forces<const S: usize>(
        &self,
        m: &Motion,
        x: &[Lanes; S],
        [tyre, body]: [Lanes; 2],
    ) -> [Lanes; 2] {
        let own = own(x);
        [
            E::tyre(self.values, m, &own, tyre),
            E::body(self.values, m, &own, body),
        ]
    }

    #[inline(always)]
    fn moved<const S: usize>(
        &self,
        m: &Motion,
        x: &[Lanes; S],
        force: Lanes,
        tyre: Lanes,
        out: &mut [Lanes; S],
    ) -> Lanes {
        let own = own(x);
        if E::SPEC.states > 0 {
            let mut rates = E::rates(self.values, m, &own);
            if E::SPEC.carries {
                rates[1] += tyre / self.values[0];
            }
            for (out, rate) in out.iter_mut().skip(2).zip(rates) {
                *out = rate;
            }
        }
        E::inertia(self.values, m, &own, force)
    }
}

/// Effects as they come. The compiler would compute beforehand whatever any effect of the library makes of the motion alone, and
/// so must not know that they all see the same.
pub(super) struct Listed<'a> {
    effects: &'a [EffectLanes],
    /// Where each one's states lie.
    offsets: [usize; MAX_EFFECTS],
    wheel: Option<usize>,
}

impl<'a> Listed<'a> {
    pub fn of(effects: &'a [EffectLanes]) -> Self {
        let mut listed = Self {
            effects,
            offsets: [0; MAX_EFFECTS],
            wheel: None,
        };
        let mut at = 2;
        for (offset, e) in listed.offsets.iter_mut().zip(effects) {
            let spec = e.kind.spec();
            *offset = at;
            if spec.carries {
                listed.wheel = Some(at);
            }
            at += spec.states;
        }
        listed
    }

    #[inline(always)]
    fn each(&self) -> impl Iterator<Item = (&'a EffectLanes, usize)> {
        self.effects.iter().zip(self.offsets)
    }
}

impl Laws for Listed<'_> {
    #[inline(always)]
    fn wheel(&self) -> Option<usize> {
        self.wheel
    }

    #[inline(always)]
    fn forces<const S: usize>(
        &self,
        m: &Motion,
        x: &[Lanes; S],
        mut forces: [Lanes; 2],
    ) -> [Lanes; 2] {
        for (e, at) in self.each() {
            let own = x.get(at..).unwrap_or_default();
            forces = (e.kind).forces(&e.values, black_box(m), own, forces);
        }
        forces
    }

    #[inline(always)]
    fn moved<const S: usize>(
        &self,
        m: &Motion,
        x: &[Lanes; S],
        mut force: Lanes,
        tyre: Lanes,
        out: &mut [Lanes; S],
    ) -> Lanes {
        for (e, at) in self.each() {
            let own = x.get(at..).unwrap_or_default();
            let spec = e.kind.spec();
            let rates = out.get_mut(at..at + spec.states).unwrap_or_default();
            force = (e.kind).moved(&e.values, black_box(m), own, force, rates);
            if let (true, Some(rate)) = (spec.carries, rates.get_mut(1)) {
                *rate += tyre / e.values[0];
            }
        }
        force
    }
}

/// The states of an effect by itself, after the mass's; zeros where it has none.
#[inline(always)]
fn own<const S: usize>(x: &[Lanes; S]) -> States {
    [2, 3].map(|q| if q < S { x[q] } else { Lanes::ZERO })
}
