//! What a part is as a whole, where there is nothing to tag.

use super::Detection;

/// Share of the surface that thin walls have at least on a thin-wall part.
const THIN_WALL_PART: f64 = 0.5;

/// Below this share a part has no thin wall to speak of.
const SOME_THIN_WALL: f64 = 0.02;

/// What was found, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Thin walls that coping closes.
    Tagged,
    /// Thin walls without an end: a closed shell.
    ClosedShell,
    /// Most of the part is no thin wall.
    LittleThinWall,
    /// A block, a bar or a ball.
    NoThinWall,
    /// The mesh has gaps, so that inside and outside are guesses.
    Open,
}

impl Verdict {
    /// What to say and what to do; none where all is well.
    pub fn text(self) -> Option<&'static str> {
        Some(match self {
            Verdict::Tagged => return None,
            Verdict::ClosedShell => {
                "no coping: its walls close up all round, as those of a hollow ball or a closed box do; nothing needs to be tagged"
            }
            Verdict::LittleThinWall => {
                "most of this part is solid, not thin wall: a mid-surface stands for the thin walls only; look at the tags, and cut the solid off or model it with solid elements"
            }
            Verdict::NoThinWall => {
                "no thin wall: this part is a block, a bar or a pin, as thick as wide; a mid-surface does not stand for it, use solid or beam elements"
            }
            Verdict::Open => {
                "the mesh has gaps, so that inside and outside are not sure: close it (`midsurf info` counts the open edges), then detect again"
            }
        })
    }
}

impl Detection {
    /// What the part is as a whole.
    pub fn verdict(&self) -> Verdict {
        let tagged = self.flags.iter().any(|&flag| flag);
        if self.open {
            Verdict::Open
        } else if self.thin_share < SOME_THIN_WALL {
            Verdict::NoThinWall
        } else if self.thin_share < THIN_WALL_PART {
            Verdict::LittleThinWall
        } else if !tagged {
            Verdict::ClosedShell
        } else {
            Verdict::Tagged
        }
    }
}
