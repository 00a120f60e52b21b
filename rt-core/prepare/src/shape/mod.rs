//! Built-in organs, made from signed distance functions.
//!
//! Axes are those of the Human Reference Atlas: x to the patient's left, y to the head, z to the
//! front. Lengths are in metres.

mod anatomy;
mod bodies;
mod connective_tissue;
mod fat;
mod gallbladder;
mod intestine;
mod liver;
mod phantom;
mod place;
mod primitive;
mod skin;
mod stomach;
#[cfg(test)]
mod tests;
mod vessel;

pub use anatomy::{Anatomy, Build, Course};
pub use skin::skin;

use serde::Deserialize;

use crate::Vec3;
use crate::mesh::Mesh;
use bodies::Bodies;
use phantom::Part;

/// A built-in organ's form: the key `form` of a recipe's `shape` table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// A liver with its gallbladder fossa.
    Liver,
    /// A gallbladder with fundus, body, infundibulum and neck, in that fossa.
    Gallbladder,
    /// A stomach under the liver's left lobe.
    Stomach,
    /// The duodenum, from the pylorus around to the right.
    Duodenum,
    /// Loops of small intestine below the liver.
    Intestine,
    /// The cystic duct, from the gallbladder's neck to the bile duct.
    CysticDuct,
    /// The bile duct, from the liver to the duodenum.
    BileDuct,
    /// The hepatic artery, to the liver beside the bile duct.
    HepaticArtery,
    /// The cystic artery, from the hepatic artery to the gallbladder.
    CysticArtery,
    /// An accessory right hepatic artery, from behind the duodenum to the liver.
    AccessoryArtery,
    /// Fat in and over Calot's triangle.
    Fat,
    /// Connective tissue between the gallbladder and the liver.
    ConnectiveTissue,
    /// The board of the phantom.
    PhantomBoard,
    /// A ball on that board, in the picture's upper left.
    PhantomUpperLeftBall,
    /// The ball at the right.
    PhantomRightBall,
    /// The ball below the first one.
    PhantomLowerLeftBall,
    /// A rope with a free end.
    PhantomRope,
    /// A thin tube.
    PhantomTube,
    /// A bar, around which the fat lies.
    PhantomCore,
    /// Fat around that bar.
    PhantomFat,
}

impl Form {
    /// The part of the phantom, if it is one.
    const fn part(self) -> Option<Part> {
        Some(match self {
            Self::PhantomBoard => Part::Board,
            Self::PhantomUpperLeftBall => Part::UpperLeftBall,
            Self::PhantomRightBall => Part::RightBall,
            Self::PhantomLowerLeftBall => Part::LowerLeftBall,
            Self::PhantomRope => Part::Rope,
            Self::PhantomTube => Part::Tube,
            Self::PhantomCore => Part::Core,
            Self::PhantomFat => Part::Fat,
            _ => return None,
        })
    }
}

/// A built-in organ: the form from a recipe's `shape` table, in the anatomy of `[anatomy]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// The organ.
    pub form: Form,
    /// Sizes and places of all organs.
    pub anatomy: Anatomy,
}

/// The `shape` table of a recipe.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeRaw {
    form: Form,
}

impl From<Form> for Shape {
    /// The organ in the usual anatomy.
    fn from(form: Form) -> Self {
        let anatomy = Anatomy::default();
        Self { form, anatomy }
    }
}

impl Shape {
    pub(crate) fn from_table(table: toml::Table, anatomy: Anatomy) -> Result<Self, String> {
        let raw: Result<ShapeRaw, _> = table.try_into();
        let raw = raw.map_err(|error: toml::de::Error| error.message().to_owned())?;
        let form = raw.form;
        Ok(Self { form, anatomy })
    }

    /// The surface as triangles.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        if let Some(part) = self.form.part() {
            let (bounds, edge_m) = part.extent();
            return skin(&*part.distance(), bounds, edge_m);
        }
        let bodies = place::bodies(&self.anatomy);
        let (bounds, edge_m) = self.extent(&bodies);
        skin(&|p: &Vec3| self.distance(&bodies, p), bounds, edge_m)
    }

    /// Signed distance, m: negative inside, accurate only near the surface.
    fn distance(&self, bodies: &Bodies, p: &Vec3) -> f64 {
        match self.form {
            Form::Liver => liver::distance(bodies, p),
            Form::Gallbladder => gallbladder::distance(bodies, p),
            Form::Stomach => stomach::distance(bodies, p),
            Form::Duodenum => stomach::duodenum(bodies, p),
            Form::Intestine => bodies.intestine.distance(p),
            Form::CysticDuct => vessel::distance(bodies, &bodies.cystic_duct, p),
            Form::BileDuct => vessel::distance(bodies, &bodies.bile_duct, p),
            Form::HepaticArtery => vessel::distance(bodies, &bodies.hepatic_artery, p),
            Form::CysticArtery => vessel::distance(bodies, &bodies.cystic_artery, p),
            Form::AccessoryArtery => vessel::distance(bodies, &bodies.accessory_artery, p),
            Form::Fat => fat::distance(bodies, p),
            Form::ConnectiveTissue => connective_tissue::distance(bodies, p),
            // `mesh` has made the parts of the phantom.
            _ => f64::INFINITY,
        }
    }

    /// A box around the organ, and the length of a triangle's side, m.
    fn extent(&self, bodies: &Bodies) -> ([Vec3; 2], f64) {
        let around = |tube: &primitive::Tube, margin: f64| {
            let [low, high] = tube.bounds();
            [low.add_scalar(-margin), high.add_scalar(margin)]
        };
        let of_vessel = |tube: &primitive::Tube| {
            let widest = tube.widest();
            (around(tube, widest), 0.45 * widest)
        };
        match self.form {
            Form::Liver => (liver::bounds(&self.anatomy.liver), liver::EDGE_M),
            Form::Gallbladder => (around(&bodies.gallbladder, 0.006), gallbladder::EDGE_M),
            Form::ConnectiveTissue => (
                around(&bodies.gallbladder, 0.008),
                connective_tissue::EDGE_M,
            ),
            Form::Stomach => (around(&bodies.stomach, 0.006), stomach::EDGE_M),
            Form::Duodenum => (around(&bodies.duodenum, 0.006), stomach::DUODENUM_EDGE_M),
            Form::Intestine => (around(&bodies.intestine, 0.006), intestine::EDGE_M),
            Form::Fat => (fat::bounds(bodies), fat::EDGE_M),
            Form::CysticDuct => of_vessel(&bodies.cystic_duct),
            Form::BileDuct => of_vessel(&bodies.bile_duct),
            Form::HepaticArtery => of_vessel(&bodies.hepatic_artery),
            Form::CysticArtery => of_vessel(&bodies.cystic_artery),
            Form::AccessoryArtery => of_vessel(&bodies.accessory_artery),
            _ => ([Vec3::zeros(); 2], 1.0),
        }
    }
}
