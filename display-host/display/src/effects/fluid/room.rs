//! Makes room for parcels: if there are too many, neighbours join. Parcels whose skin a cut has
//! hidden move to whole skin.

use super::super::stain::Skin;
use super::parcel::Lying;
use super::surface::{Place, Surface};
use super::{Fluids, LYING};

/// Side of the smallest cubes whose parcels join when there are too many, m.
const CUBE_M: f32 = 0.001_6;

impl Fluids {
    /// Takes a parcel, after making room for it.
    pub(super) fn lie(&mut self, parcel: Lying, skin: &Skin<'_>) {
        if self.lying.len() >= LYING {
            self.thin_out(skin);
        }
        self.lying.push(parcel);
    }

    /// Lays the parcels whose triangles a cut has hidden on the nearest skin that is whole.
    pub(super) fn lay_anew(&mut self, skin: &Skin<'_>) {
        let mut known: Option<(usize, Option<Place>)> = None;
        let mut lost = [0.0; 3];
        self.lying.retain_mut(|it| {
            let corners = skin.triangles().get(it.place.triangle as usize);
            let [a, b, c] = corners.copied().unwrap_or_default();
            if a != b && b != c {
                return true;
            }
            let vertex = a as usize;
            let place = match known {
                Some((last, place)) if last == vertex => place,
                _ => {
                    let found = skin.place_at(vertex).or_else(|| {
                        let whole = skin.nearest_whole(vertex)?;
                        skin.place_at(whole)
                    });
                    found.map(|(triangle, weights)| Place { triangle, weights })
                }
            };
            known = Some((vertex, place));
            match place {
                Some(place) => it.place = place,
                None => lost = core::array::from_fn(|k| lost[k] + it.volume_m3[k]),
            }
            place.is_some()
        });
        self.lose(lost);
    }

    /// Joins parcels until there is room: first those that lie in one small cube of the tissue at
    /// rest, then in cubes of twice the side, and so on.
    pub(super) fn thin_out(&mut self, skin: &Skin<'_>) {
        let mut cube_m = CUBE_M;
        while self.lying.len() > LYING * 3 / 4 {
            self.join(cube_m, skin);
            cube_m *= 2.0;
        }
    }

    /// Joins parcels that lie in one cube of this side of the tissue at rest.
    fn join(&mut self, cube_m: f32, skin: &Skin<'_>) {
        let cube = |it: &Lying| {
            let at = Surface::at_rest(&it.place, skin) / cube_m;
            at.floor().to_array().map(|v| v as i32)
        };
        let mut keyed: Vec<_> = self.lying.drain(..).map(|it| (cube(&it), it)).collect();
        keyed.sort_by_key(|(key, _)| *key);
        let mut last_key = None;
        for (key, it) in keyed {
            match self.lying.last_mut() {
                Some(last) if last_key == Some(key) => merge(last, &it),
                _ => self.lying.push(it),
            }
            last_key = Some(key);
        }
    }
}

/// Adds a parcel to another, which keeps its place if it is larger.
fn merge(into: &mut Lying, other: &Lying) {
    let (a, b) = (into.total_m3(), other.total_m3());
    let share = (b / (a + b).max(1e-18)) as f32;
    if b > a {
        into.place = other.place;
    }
    into.age_s += (other.age_s - into.age_s) * share;
    for (sum, volume) in into.volume_m3.iter_mut().zip(other.volume_m3) {
        *sum += volume;
    }
}
