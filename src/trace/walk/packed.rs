//! Shares of a walk as bytes: little-endian numbers, lists after their lengths.

use std::io::{self, Read, Write};

use glam::DVec3;

use super::Share;
use super::piece::{Piece, PieceTet, PieceVertex};
use super::wire::{broken, get, get_f64, get_u32, get_u64};
use crate::lattice::{EdgeKey, FaceKey, TetKey};
use crate::mesh::FaceId;
use crate::surface::marked::Line;
use crate::trace::tet::VertexKey;

/// Lines by the byte that stands for them.
const LINES: [Line; 5] = [
    Line::Sheet,
    Line::Seam,
    Line::CopingBorder,
    Line::FadingBorder,
    Line::Crease,
];

/// Entries of a list for which room is made before they are read: a length may
/// be a lie.
const ROOM: usize = 1 << 16;

fn put_list<T>(
    out: &mut dyn Write,
    list: &[T],
    mut put: impl FnMut(&mut dyn Write, &T) -> io::Result<()>,
) -> io::Result<()> {
    let length = u32::try_from(list.len()).map_err(|_| io::ErrorKind::FileTooLarge)?;
    out.write_all(&length.to_le_bytes())?;
    list.iter().try_for_each(|item| put(out, item))
}

fn get_list<T>(
    input: &mut dyn Read,
    mut get: impl FnMut(&mut dyn Read) -> io::Result<T>,
) -> io::Result<Vec<T>> {
    let length = get_u32(input)? as usize;
    let mut list = Vec::with_capacity(length.min(ROOM));
    for _ in 0..length {
        list.push(get(input)?);
    }
    list.shrink_to_fit();
    Ok(list)
}

fn put_u32s(out: &mut dyn Write, numbers: &[u32]) -> io::Result<()> {
    (numbers.iter()).try_for_each(|n| out.write_all(&n.to_le_bytes()))
}

impl Share {
    /// Writes it.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        put_list(out, &self.pieces, |out, piece| piece.write(out))?;
        put_list(out, &self.cut_in, |out, tet| {
            out.write_all(&tet.to_bits().to_le_bytes())
        })
    }

    /// Reads what [`Share::write`] wrote about a part of so many faces.
    ///
    /// # Errors
    ///
    /// Those of the reader, and `InvalidData` for what no share is.
    pub fn read(input: &mut dyn Read, faces: usize) -> io::Result<Share> {
        let share = Share {
            pieces: get_list(input, |input| Piece::read(input))?,
            cut_in: get_list(input, |input| Ok(TetKey::from_bits(get_u64(input)?)))?,
        };
        let sound = share.pieces.iter().all(|piece| piece.is_sound(faces));
        if sound { Ok(share) } else { Err(broken()) }
    }
}

impl Piece {
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        put_list(out, &self.keys, |out, key| {
            let (kind, bits, n) = match *key {
                VertexKey::Edge(e, n) => (0, e.to_bits(), n),
                VertexKey::Face(f, n) => (1, f.to_bits(), n),
                VertexKey::Inner(t, n) => (2, t.to_bits(), n),
            };
            out.write_all(&[kind])?;
            out.write_all(&bits.to_le_bytes())?;
            out.write_all(&n.to_le_bytes())
        })?;
        put_list(out, &self.vertices, |out, v| {
            for x in v.at.to_array() {
                out.write_all(&x.to_le_bytes())?;
            }
            put_u32s(out, &[v.coping.map_or(u32::MAX, |c| c.0), v.walls_end])
        })?;
        put_list(out, &self.walls, |out, wall| put_u32s(out, &[wall.0]))?;
        put_list(out, &self.tets, |out, tet| {
            out.write_all(&tet.key.to_bits().to_le_bytes())?;
            put_u32s(out, &[tet.triangles_end, tet.lines_end])
        })?;
        put_list(out, &self.triangles, |out, corners| put_u32s(out, corners))?;
        put_list(out, &self.lines, |out, (ends, line)| {
            put_u32s(out, ends)?;
            // All lines are in the list.
            let byte = LINES.iter().position(|l| l == line).unwrap_or(0);
            out.write_all(&[byte as u8])
        })
    }

    fn read(input: &mut dyn Read) -> io::Result<Piece> {
        Ok(Piece {
            keys: get_list(input, |input| {
                let [kind] = get(input)?;
                let bits = get_u64(input)?;
                let n = u16::from_le_bytes(get(input)?);
                match kind {
                    0 => Ok(VertexKey::Edge(EdgeKey::from_bits(bits), n)),
                    1 => Ok(VertexKey::Face(FaceKey::from_bits(bits), n)),
                    2 => Ok(VertexKey::Inner(TetKey::from_bits(bits), n)),
                    _ => Err(broken()),
                }
            })?,
            vertices: get_list(input, |input| {
                let at = DVec3::new(get_f64(input)?, get_f64(input)?, get_f64(input)?);
                let coping = get_u32(input)?;
                Ok(PieceVertex {
                    at,
                    coping: (coping != u32::MAX).then_some(FaceId(coping)),
                    walls_end: get_u32(input)?,
                })
            })?,
            walls: get_list(input, |input| Ok(FaceId(get_u32(input)?)))?,
            tets: get_list(input, |input| {
                Ok(PieceTet {
                    key: TetKey::from_bits(get_u64(input)?),
                    triangles_end: get_u32(input)?,
                    lines_end: get_u32(input)?,
                })
            })?,
            triangles: get_list(input, |input| {
                Ok([get_u32(input)?, get_u32(input)?, get_u32(input)?])
            })?,
            lines: get_list(input, |input| {
                let ends = [get_u32(input)?, get_u32(input)?];
                let [byte] = get(input)?;
                let line = LINES.get(byte as usize).ok_or_else(broken)?;
                Ok((ends, *line))
            })?,
        })
    }

    /// Whether every number in it leads to something, on a part of so many faces.
    fn is_sound(&self, faces: usize) -> bool {
        let count = self.keys.len();
        let known = |v: &u32| (*v as usize) < count;
        let ends = |ends: Vec<u32>, whole: usize| {
            ends.is_sorted() && ends.last().map_or(0, |&end| end as usize) == whole
        };
        let a_face = |face: &FaceId| face.index() < faces;
        self.vertices.len() == count
            && self.keys.is_sorted_by(|a, b| a < b)
            && self.tets.is_sorted_by(|a, b| a.key < b.key)
            && ends(
                self.vertices.iter().map(|v| v.walls_end).collect(),
                self.walls.len(),
            )
            && ends(
                self.tets.iter().map(|t| t.triangles_end).collect(),
                self.triangles.len(),
            )
            && ends(
                self.tets.iter().map(|t| t.lines_end).collect(),
                self.lines.len(),
            )
            && self.vertices.iter().all(|v| v.at.is_finite())
            && self
                .vertices
                .iter()
                .filter_map(|v| v.coping.as_ref())
                .all(a_face)
            && self.walls.iter().all(a_face)
            && self.triangles.iter().flatten().all(known)
            && self.lines.iter().flat_map(|(ends, _)| ends).all(known)
    }
}
