//! Validation of a character's feet, roles and trunk: every name known, every foot able to touch the ground.

use super::{Entry, one_of, shown};
use crate::asset::{Character, CharacterError, FootEntry, FootKindEntry, JointEntry, PointRole, SoleEntry};
use std::collections::HashMap;

/// Most feet of a character.
pub(super) const MAX_FEET: usize = 16;

/// Checks feet, roles and trunk of a character whose links and contact points are valid.
pub(super) fn check_parts(
    character: &Character,
    file: &str,
    links: &HashMap<&str, usize>,
) -> Result<(), CharacterError> {
    let parts = Parts { character, file, links };
    if let Some(trunk) = &character.trunk {
        parts.known("trunk", trunk, trunk)?;
    }
    let mut taken: Vec<(usize, String)> = Vec::new();
    for (index, foot) in character.feet.iter().enumerate() {
        let name = format!("{}", index + 1);
        let entry = Entry { file, part: "foot", name: &name };
        if foot.links.is_empty() {
            return Err(entry.refuse("links", &foot.links, "the names of one or more links"));
        }
        let mut hosts = Vec::new();
        for link in &foot.links {
            parts.known("foot", &name, link)?;
            let host = parts.host(link);
            if let Some((_, other)) = taken.iter().find(|(h, _)| *h == host) {
                return Err(entry.refuse("links", link, format!("links of this foot alone; foot {other} has it")));
            }
            hosts.push(host);
        }
        taken.extend(hosts.iter().map(|h| (*h, name.clone())));
        parts.check_foot(&entry, foot, &hosts)?;
    }
    for point in character.contact_points.iter().filter(|p| p.role == Some(PointRole::Foot)) {
        if !character.feet.is_empty() && !taken.iter().any(|(host, _)| *host == parts.host(&point.link)) {
            let entry = Entry { file, part: "contact point", name: &point.name };
            return Err(entry.refuse("role", PointRole::Foot, "Hand or Body for a point on no link of the feet"));
        }
    }
    Ok(())
}

/// The file as it is looked up here.
struct Parts<'a> {
    character: &'a Character,
    file: &'a str,
    links: &'a HashMap<&'a str, usize>,
}

impl Parts<'_> {
    fn known(&self, part: &'static str, name: &str, link: &str) -> Result<(), CharacterError> {
        if self.links.contains_key(link) {
            return Ok(());
        }
        Err(CharacterError::UnknownLink {
            file: self.file.into(),
            part,
            name: shown(name),
            link: shown(link),
            valid: one_of(self.links).into(),
        })
    }

    /// The entry of the moving link that carries the named one: itself, or for a weld the nearest ancestor that moves.
    fn host(&self, link: &str) -> usize {
        let mut at = self.links[link];
        while let (JointEntry::Weld, Some(parent)) = (self.character.links[at].joint, &self.character.links[at].parent)
        {
            at = self.links[parent.as_str()];
        }
        at
    }

    /// Names of all contact points on these links, blade ends included.
    fn points_on(&self, hosts: &[usize]) -> Vec<String> {
        let on = |link: &str| hosts.contains(&self.host(link));
        let own = self.character.contact_points.iter().filter(|p| on(&p.link)).map(|p| p.name.clone());
        let ends = self.character.blades.iter().filter(|b| on(&b.link)).flat_map(|b| b.end_names());
        own.chain(ends).collect()
    }

    fn check_foot(&self, entry: &Entry, foot: &FootEntry, hosts: &[usize]) -> Result<(), CharacterError> {
        if let FootKindEntry::Blade(name) = &foot.kind {
            let blades = &self.character.blades;
            let Some(blade) = blades.iter().find(|b| b.name == *name) else {
                let names: Vec<&str> = blades.iter().map(|b| b.name.as_str()).collect();
                let valid = match names.as_slice() {
                    [] => "Sole for a character without blades".to_owned(),
                    names => format!("Sole or the name of a blade, one of {}", names.join(", ")),
                };
                return Err(entry.refuse("kind", &foot.kind, valid));
            };
            if !hosts.contains(&self.host(&blade.link)) {
                let valid = format!("a list with the blade's link, {}", blade.link);
                return Err(entry.refuse("links", &foot.links, valid));
            }
        }
        if let Some(sole) = &foot.sole {
            check_sole(entry, sole, &foot.kind)?;
        }
        let points = self.points_on(hosts);
        if points.is_empty() {
            return Err(entry.refuse(
                "links",
                &foot.links,
                "links of which at least one has a contact point or a blade",
            ));
        }
        for (field, end) in [("toe", &foot.toe), ("heel", &foot.heel)] {
            if let Some(end) = end
                && !points.contains(end)
            {
                let more = if points.len() > 24 { format!(" and {} more", points.len() - 24) } else { String::new() };
                let names = points[..points.len().min(24)].join(", ");
                let valid = format!("a contact point on the foot's links, one of {names}{more}");
                return Err(entry.refuse(field, end, valid));
            }
        }
        Ok(())
    }
}

/// A sole under a foot that stands on contact points.
fn check_sole(entry: &Entry, sole: &SoleEntry, kind: &FootKindEntry) -> Result<(), CharacterError> {
    if let FootKindEntry::Blade(_) = kind {
        return Err(entry.refuse("sole", sole, "nothing on a foot that stands on a blade"));
    }
    entry.number("sole thickness", sole.thickness, 1e-3, 0.2, "m")?;
    entry.number("sole front", sole.front, 0.0, 0.1, "m")?;
    entry.number("sole rear", sole.rear, 0.0, 0.1, "m")?;
    entry.number("sole side", sole.side, 0.0, 0.1, "m")?;
    entry.number("sole friction", sole.friction, 0.0, 10.0, "")?;
    entry.number("sole mass", sole.mass, 0.0, 10.0, "kg")
}
