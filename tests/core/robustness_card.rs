//! Contract: a card's intervals are Wilson's, and a card whose numbers do not fit each other is refused.
//!
//! The intervals are held against a table printed in a paper, not against the formula again. A card is evidence: one
//! that was edited by hand, or written by a program that counts wrongly, must not be readable.

use bevy_athlete::asset::card::{CARD_VERSION, CardError, CardRow, RobustnessCard, fingerprint, wilson_interval};
use std::collections::BTreeMap;

#[test]
fn intervals_agree_with_the_published_table() {
    // Newcombe 1998, "Two-sided confidence intervals for the single proportion: comparison of seven methods", table I,
    // method 3.
    for (successes, trials, low, high) in
        [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
    {
        let (l, h) = wilson_interval(successes, trials);
        println!("{successes}/{trials}: {l:.4} to {h:.4}");
        assert!((l - low).abs() < 5e-5 && (h - high).abs() < 5e-5, "{successes}/{trials}: {l} to {h}");
    }
}

#[test]
fn intervals_obey_their_laws() {
    assert_eq!(wilson_interval(0, 0), (0.0, 1.0));
    for trials in [1u64, 2, 20, 200, 1_000_000] {
        assert_eq!(wilson_interval(0, trials).0, 0.0);
        assert_eq!(wilson_interval(trials, trials).1, 1.0);
        for successes in [0, 1, trials / 3, trials / 2, trials] {
            let (low, high) = wilson_interval(successes, trials);
            let rate = successes as f64 / trials as f64;
            assert!(0.0 <= low && low <= rate && rate <= high && high <= 1.0 && low < high);
            // Failures are successes of the opposite.
            let (other_low, other_high) = wilson_interval(trials - successes, trials);
            assert!((low + other_high - 1.0).abs() < 1e-12 && (high + other_low - 1.0).abs() < 1e-12);
            // Each bound solves |rate - bound| = z sqrt(bound (1 - bound) / trials), which is how Wilson defines them.
            for bound in [low, high].into_iter().filter(|b| *b > 0.0 && *b < 1.0) {
                let z = (rate - bound).abs() / (bound * (1.0 - bound) / trials as f64).sqrt();
                assert!((z - 1.959_964).abs() < 1e-5, "{successes}/{trials}: {z}");
            }
        }
    }
}

fn card() -> RobustnessCard {
    RobustnessCard {
        version: CARD_VERSION,
        skill: "stroking".into(),
        character: "skater".into(),
        policy: fingerprint(b"policy"),
        crate_version: "0.1.0".into(),
        seed: 7,
        trials: 500,
        rows: vec![CardRow::new("no pushes", 200, 197), CardRow::new("200 N", 300, 0)],
        quality: BTreeMap::from([("slip_m_per_s".to_owned(), 1.5e-3)]),
        command: "athlete evaluate stroking".into(),
    }
}

/// A row counts by its trials, not as one of two.
#[test]
fn a_card_sums_its_rows() {
    let mut card = card();
    assert!((card.rate() - 197.0 / 500.0).abs() < 1e-12);
    card.quality.insert("reward_per_step, no pushes".into(), 0.9);
    assert_eq!(card.reward_per_step(), None, "a row was not measured");
    card.quality.insert("reward_per_step, 200 N".into(), 0.4);
    assert!(card.reward_per_step().is_some_and(|reward| (reward - 0.6).abs() < 1e-12));
}

#[test]
fn a_card_survives_and_a_wrong_one_is_refused() {
    let card = card();
    let path = std::env::temp_dir().join(format!("athlete-card-{}.json", std::process::id()));
    card.save(&path).unwrap();
    let read = RobustnessCard::load(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read.rows[0].successes, 197);
    // Bounds come back to the last bit but one: they are recomputed for the comparison.
    let mut same = read.clone();
    same.rows = read.rows.iter().map(|r| CardRow::new(r.name.clone(), r.trials, r.successes)).collect();
    assert_eq!(same, card);
    assert!((read.rows[0].rate() - 0.985).abs() < 1e-12);
    assert!(matches!(RobustnessCard::load(&path), Err(CardError::File { .. })));

    let json = card.to_json().unwrap();
    for (from, to, words) in [
        ("\"successes\": 197", "\"successes\": 198", "row `no pushes`"),
        ("\"successes\": 197", "\"successes\": 201", "201 successes in 200 trials"),
        ("\"trials\": 200", "\"trials\": 0", "in 0 trials"),
        ("\"trials\": 500", "\"trials\": 501", "500, the sum of the rows"),
        ("\"low\": 0.0,", "\"low\": 0.5,", "row `200 N`"),
        ("\"200 N\"", "\"no pushes\"", "used once"),
        ("\"slip_m_per_s\"", "\" \"", "quality"),
        ("\"seed\": 7,", "", "missing field `seed`"),
        ("\"seed\": 7,", "\"seed\": -7,", "line"),
        ("\"version\": 1", "\"version\": 2", "version"),
        ("\"stroking\"", "\"\"", "skill"),
    ] {
        assert!(json.contains(from), "{from}");
        let error = RobustnessCard::from_json(&json.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(words), "{from} -> {to}: {error}");
    }
    let mut broken = card.clone();
    broken.quality.insert("jerk".into(), f64::NAN);
    assert!(matches!(broken.to_json(), Err(CardError::Value { .. })));
    broken = card.clone();
    broken.rows[0].high = f64::NAN;
    assert!(matches!(broken.check(), Err(CardError::Value { .. })));
    broken.rows.clear();
    assert!(matches!(broken.check(), Err(CardError::Value { .. })));
}

#[test]
fn fingerprints_are_the_published_hash() {
    // Test vectors of the FNV-1a 64-bit hash: the empty text, "a" and "foobar".
    assert_eq!(fingerprint(b""), "fnv1a64-0-cbf29ce484222325");
    assert_eq!(fingerprint(b"a"), "fnv1a64-1-af63dc4c8601ec8c");
    assert_eq!(fingerprint(b"foobar"), "fnv1a64-6-85944171f73967e8");
}
