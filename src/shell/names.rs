//! Names of a part's faces, as its file has them.

use std::collections::BTreeSet;

use super::{ShellModel, coping_patches};
use crate::intake::Input;
use crate::mesh::FaceId;

impl ShellModel {
    /// [`ShellModel::name_faces`], by the names that the part's file gives.
    pub fn name_after(&mut self, input: &Input) {
        let names = Names::of(input);
        self.name_faces(&input.part, &|face| names.coping(face), &|face| {
            names.wall(face)
        });
    }
}

/// Names of the part's faces: the file's own, where it tells them apart.
struct Names<'i> {
    input: &'i Input,
    /// Whether the file has several names for coping faces, and for walls.
    told_apart: [bool; 2],
    patches: Vec<Option<u32>>,
}

impl<'i> Names<'i> {
    fn of(input: &'i Input) -> Names<'i> {
        let mut found = [BTreeSet::new(), BTreeSet::new()];
        for (face, &coping) in (0..).zip(input.part.coping()) {
            found[usize::from(!coping)].extend(input.name_of(FaceId(face)));
        }
        Names {
            input,
            told_apart: found.map(|names| names.len() > 1),
            patches: coping_patches(&input.part),
        }
    }

    /// The file's name, or the number of the flat coping face, from 1.
    fn coping(&self, face: FaceId) -> String {
        let own = self.input.name_of(face).filter(|_| self.told_apart[0]);
        let patch = || self.patches[face.index()].map_or(0, |n| n + 1).to_string();
        own.map_or_else(patch, str::to_owned)
    }

    fn wall(&self, face: FaceId) -> Option<String> {
        let own = self.input.name_of(face).filter(|_| self.told_apart[1]);
        own.map(str::to_owned)
    }
}
