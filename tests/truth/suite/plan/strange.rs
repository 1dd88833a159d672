//! Physics that is in no library, and ten kinds of it that nobody has seen.

use super::road_or_plate;
use crate::chance::Chance;
use crate::simulate::outside::Strange;
use crate::suite::case::{Case, Class, Noise};

/// Every kind of strange physics at three sizes, under all kinds of noise in turn; shuffled.
pub fn strange(chance: &mut Chance) -> Vec<Case> {
    let mut cases = Vec::new();
    for kind in Strange::all() {
        for size in 0..3 {
            let noise = Noise::ALL[cases.len() % Noise::ALL.len()];
            let setting = road_or_plate(kind.needs_road(), chance);
            let mut case = Case::new(Class::Outside, setting, noise, chance);
            case.strange = Some((kind, (size + chance.index(2)) % 2));
            case.size = size;
            cases.push(case);
        }
    }
    chance.shuffle(&mut cases);
    cases
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::case::Setting;
    use crate::suite::order::Suite;

    #[test]
    fn every_kind_comes_at_three_sizes_and_what_needs_a_road_has_one() {
        let cases = strange(&mut Chance::new(1, 0));
        for kind in Strange::all() {
            let of = |c: &&Case| c.strange.is_some_and(|(k, _)| k == kind);
            let mut sizes: Vec<usize> = cases.iter().filter(of).map(|c| c.size).collect();
            sizes.sort();
            assert_eq!(sizes, [0, 1, 2], "{}", kind.id());
        }
        for noise in Noise::ALL {
            assert!(cases.iter().filter(|c| c.noise == noise).count() >= 20);
        }
        let on_road = |c: &Case| c.setting == Setting::Road;
        let needs = |c: &Case| c.strange.is_some_and(|(kind, _)| kind.needs_road());
        assert!(cases.iter().all(|c| on_road(c) || !needs(c)));
        assert!(cases.iter().any(|c| !on_road(c)));
    }

    #[test]
    fn kinds_kept_back_are_in_no_other_suite() {
        for suite in Suite::ALL.into_iter().filter(|s| *s != Suite::Strange) {
            let cases = suite.cases(&mut Chance::new(1, 0));
            let kept = |c: &Case| {
                c.strange
                    .is_some_and(|(kind, _)| Strange::KEPT_BACK.contains(&kind))
            };
            assert!(!cases.iter().any(kept), "{}", suite.name());
        }
    }
}
