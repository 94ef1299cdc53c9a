//! Counts and places in words.

use glam::DVec3;

use crate::settings::quote::figure;

/// Places that are named before the list is cut short.
const PLACES_NAMED: usize = 5;

/// The first few of some places.
pub fn listed(places: impl ExactSizeIterator<Item = DVec3>) -> String {
    let more = if places.len() > PLACES_NAMED {
        " and more"
    } else {
        ""
    };
    let places: Vec<String> = places.take(PLACES_NAMED).map(place).collect();
    format!("{}{more}", places.join(" "))
}

/// A place in brackets.
pub fn place(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(figure);
    format!("({x}, {y}, {z})")
}

/// A number with its noun.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}
