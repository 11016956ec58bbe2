//! Pictures solved one after the other, each with what those before it leave.

use super::pointing::Pointing;
use super::{PictureSolver, SolveAnswer, answer};
use crate::campaign::progress;
use crate::commands::picture_camera::PictureCamera;
use crate::error::HostError;
use crate::flight::blind::BlindSearch;
use crate::flight::{self, Density};
use crate::formats::picture::Picture;
use fsw_hal::{Detector, DetectorGeometry};
use std::borrow::Cow;
use std::path::Path;

/// What pictures are solved with, and what those before leave for the next.
pub struct Session {
    cameras: Option<PictureCamera>,
    /// The catalogue that the user named.
    named: Option<Cow<'static, [u8]>>,
    /// No progress on a terminal.
    quiet: bool,
    /// The catalogue built for the field of the picture before, degrees.
    built: Option<([f64; 2], Cow<'static, [u8]>)>,
    /// The search over all optics for pictures of the size of the one before.
    blind: Option<(DetectorGeometry, BlindSearch)>,
    solver: PictureSolver,
}

impl Session {
    /// Of what is known of the optics (nothing: all fields of 5 to 40 deg are tried), and bytes of a
    /// catalogue where it is not to be chosen by the field. On a terminal a search over all fields shows its
    /// progress, unless `quiet`.
    pub fn new(cameras: Option<PictureCamera>, catalogue: Option<Cow<'static, [u8]>>, quiet: bool) -> Self {
        Self { cameras, named: catalogue, quiet, built: None, blind: None, solver: PictureSolver::default() }
    }

    /// The answer for a picture, and where it looks if it was identified; `name` is for the answer and the
    /// message.
    ///
    /// # Errors
    /// When the picture has not the camera's size, or no catalogue serves the field.
    pub fn solve(
        &mut self,
        name: &Path,
        picture: &mut Picture,
    ) -> Result<(SolveAnswer, Option<Pointing>), HostError> {
        let Some(cameras) = &self.cameras else { return self.solve_blind(name, picture) };
        let (camera, focal_length) = cameras.flight(name, picture)?;
        let field_deg = flight::field_deg(&camera);
        if self.named.is_none() && self.built.as_ref().is_none_or(|(served, _)| *served != field_deg) {
            let bytes = flight::catalogue_bytes(&camera, Density::Brightest);
            self.built = Some((field_deg, bytes.map_err(|error| error.at(name))?));
        }
        let bytes = self.named.as_ref().or(self.built.as_ref().map(|(_, bytes)| bytes));
        let catalogue = flight::open(bytes.map_or(&[], |bytes| bytes))?;
        let found = self.solver.find(name, picture, (&camera, focal_length), &catalogue)?;
        let pointing = found.solution.as_ref().ok().and_then(Pointing::new);
        Ok((answer::answer(name, &found, Some(&catalogue)), pointing))
    }

    /// The same with nothing known of the optics.
    fn solve_blind(
        &mut self,
        name: &Path,
        picture: &mut Picture,
    ) -> Result<(SolveAnswer, Option<Pointing>), HostError> {
        let geometry = picture.geometry();
        self.blind = self.blind.take().filter(|(served, _)| *served == geometry);
        let (_, search) = self.blind.get_or_insert_with(|| (geometry, BlindSearch::new(geometry)));
        let bar = progress("fields", search.tries(), self.quiet);
        let (found, catalogue) = self.solver.find_blind(name, picture, search, || bar.inc(1))?;
        bar.finish_and_clear();
        let catalogue = found.solution.as_ref().ok().map(|_| flight::open(catalogue)).transpose()?;
        let pointing = found.solution.as_ref().ok().and_then(Pointing::new);
        Ok((answer::answer(name, &found, catalogue.as_ref()), pointing))
    }
}
