//! A listed effect on one axle, strange physics on the other.

use super::{any_noise, road_or_plate};
use crate::chance::Chance;
use crate::simulate::effect::{Axle, Kind};
use crate::simulate::outside::Strange;
use crate::suite::case::{Case, Class};

/// Rides on which one effect of the library acts on one axle, and strange physics on the other.
pub fn beside(count: usize, chance: &mut Chance) -> Vec<Case> {
    let one_axle = |kind: &Kind| kind.axles().iter().all(|axle| Axle::ONE.contains(axle));
    let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(one_axle).collect();
    let strange: Vec<Strange> = (Strange::KNOWN.into_iter())
        .filter(|kind| *kind != Strange::LateralCoupling)
        .collect();
    (0..count)
        .map(|i| {
            let (kind, other) = (kinds[i % kinds.len()], strange[i % strange.len()]);
            let setting = road_or_plate(kind.needs_road() || other.needs_road(), chance);
            let mut case = Case::new(Class::Beside, setting, any_noise(chance), chance);
            let axle = chance.pick(kind.axles());
            case.effects = vec![(kind, axle)];
            case.strange = Some((other, usize::from(axle == Axle::Front)));
            case.size = 1 + chance.index(2);
            case
        })
        .collect()
}
