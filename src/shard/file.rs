//! Shards as files.
//!
//! ```text
//!   "midsurf shard\n"   format: u32   deflated content   SHA-256 of all before
//! ```
//!
//! The content is little-endian numbers, lists after their lengths. Nothing is
//! believed of it that is not checked: a length is no promise of entries, and
//! every number leads to something.

use std::io::{self, Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use glam::DVec3;
use sha2::{Digest, Sha256};

use super::{Carried, Shard, ShardFileError, ShardOf, Task, checksum};
use crate::mesh::{Part, PartOptions, TriMesh};
use crate::trace::walk::wire::{broken, get, get_f64, get_u32, get_u64};
use crate::trace::walk::{Counts, Share};

const MAGIC: &[u8] = b"midsurf shard\n";

/// Changes with every change of the content.
const FORMAT: u32 = 1;

/// Length of the checksum.
const SUM: usize = 32;

impl Shard {
    /// Writes the shard.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(FORMAT.to_le_bytes());
        let mut packed = ZlibEncoder::new(bytes, Compression::fast());
        self.write_content(&mut packed)?;
        let bytes = packed.finish()?;
        out.write_all(&bytes)?;
        out.write_all(&Sha256::digest(&bytes))
    }

    /// Reads a shard from the whole of its file.
    ///
    /// # Errors
    ///
    /// [`ShardFileError`]: what is no shard, or not a whole one, is refused.
    pub fn read(bytes: &[u8]) -> Result<Shard, ShardFileError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(ShardFileError::NoShard)?;
        let damaged = ShardFileError::Damaged("it ends too soon");
        let Some((format, rest)) = rest.split_first_chunk() else {
            return Err(damaged);
        };
        let found = u32::from_le_bytes(*format);
        if found != FORMAT {
            return Err(ShardFileError::OtherFormat {
                found,
                known: FORMAT,
            });
        }
        let Some((content, sum)) = rest.split_last_chunk::<SUM>() else {
            return Err(damaged);
        };
        if Sha256::digest(&bytes[..bytes.len() - SUM])[..] != sum[..] {
            return Err(ShardFileError::Damaged("its checksum does not fit"));
        }
        read_content(&mut ZlibDecoder::new(content))
            .map_err(|_| ShardFileError::Damaged("it holds what no shard holds"))
    }

    fn write_content(&self, out: &mut dyn Write) -> io::Result<()> {
        let task = &self.task;
        out.write_all(&self.which.index.to_le_bytes())?;
        out.write_all(&self.which.count.to_le_bytes())?;
        out.write_all(&(task.version.len() as u32).to_le_bytes())?;
        out.write_all(task.version.as_bytes())?;
        out.write_all(&task.part)?;
        out.write_all(&task.cell.to_le_bytes())?;
        out.write_all(&task.min_angle.to_le_bytes())?;
        out.write_all(&[u8::from(task.keep_fins)])?;
        for count in counts(&self.counts) {
            out.write_all(&count.to_le_bytes())?;
        }
        out.write_all(&self.counts.queries_per_edge.to_le_bytes())?;
        out.write_all(&task.faces.to_le_bytes())?;
        out.write_all(&[u8::from(self.part.is_some())])?;
        if let Some(Carried(part)) = &self.part {
            write_part(part, out)?;
        }
        self.share.write(out)
    }
}

fn counts(c: &Counts) -> [u64; 9] {
    let [cells, tets, faces, edges] = [c.cells, c.tetrahedra, c.faces, c.edges].map(|n| n as u64);
    let [lost, matched, torn, unsettled] =
        [c.lost, c.matched, c.torn, c.unsettled].map(|n| n as u64);
    [
        cells, tets, faces, edges, c.queries, lost, matched, torn, unsettled,
    ]
}

fn get_flag(input: &mut dyn Read) -> io::Result<bool> {
    match get(input)? {
        [0] => Ok(false),
        [1] => Ok(true),
        _ => Err(broken()),
    }
}

/// Longest name of a version.
const LONGEST_VERSION: usize = 64;

fn read_content(input: &mut dyn Read) -> io::Result<Shard> {
    let which = ShardOf::new(get_u32(input)?, get_u32(input)?).ok_or_else(broken)?;
    let length = get_u32(input)? as usize;
    if length > LONGEST_VERSION {
        return Err(broken());
    }
    let mut version = vec![0; length];
    input.read_exact(&mut version)?;
    let version = String::from_utf8(version).map_err(|_| broken())?;
    let part_sum = get(input)?;
    let (cell, min_angle) = (get_f64(input)?, get_f64(input)?);
    let keep_fins = get_flag(input)?;
    let mut numbers = [0; 9];
    for n in &mut numbers {
        *n = get_u64(input)?;
    }
    let [
        cells,
        tetrahedra,
        solved_faces,
        edges,
        queries,
        lost,
        matched,
        torn,
        unsettled,
    ] = numbers;
    let queries_per_edge = get_f64(input)?;
    let faces = get_u32(input)?;
    let task = Task {
        version,
        part: part_sum,
        faces,
        cell,
        min_angle,
        keep_fins,
    };
    let part = match get_flag(input)? {
        true => Some(read_part(input, &task)?),
        false => None,
    };
    if part.is_some() != (which.index == 1) {
        return Err(broken());
    }
    let share = Share::read(input, faces as usize)?;
    if input.read(&mut [0])? != 0 {
        return Err(broken());
    }
    Ok(Shard {
        which,
        task,
        part,
        share,
        counts: Counts {
            cells: cells as usize,
            tetrahedra: tetrahedra as usize,
            faces: solved_faces as usize,
            edges: edges as usize,
            queries,
            queries_per_edge,
            lost: lost as usize,
            matched: matched as usize,
            torn: torn as usize,
            unsettled: unsettled as usize,
        },
    })
}

fn write_part(part: &Part, out: &mut dyn Write) -> io::Result<()> {
    let mesh = part.mesh();
    out.write_all(&(mesh.positions.len() as u32).to_le_bytes())?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for x in mesh.positions.iter().flat_map(|p| p.to_array()) {
        out.write_all(&x.to_le_bytes())?;
    }
    for v in mesh.triangles.iter().flatten() {
        out.write_all(&v.to_le_bytes())?;
    }
    let flags: Vec<u8> = part.coping().iter().map(|&c| u8::from(c)).collect();
    out.write_all(&flags)
}

fn read_part(input: &mut dyn Read, task: &Task) -> io::Result<Carried> {
    let (positions, triangles) = (get_u32(input)?, get_u32(input)?);
    let mut mesh = TriMesh::default();
    for _ in 0..positions {
        let p = DVec3::new(get_f64(input)?, get_f64(input)?, get_f64(input)?);
        mesh.positions.push(p);
    }
    for _ in 0..triangles {
        let corners = [get_u32(input)?, get_u32(input)?, get_u32(input)?];
        if corners.iter().any(|&v| v >= positions) {
            return Err(broken());
        }
        mesh.triangles.push(corners);
    }
    let mut coping = Vec::new();
    for _ in 0..triangles {
        coping.push(get_flag(input)?);
    }
    // Checked when the shard was made; a part that changes now is another.
    let options = PartOptions {
        allow_open: true,
        ..PartOptions::default()
    };
    let (part, _) = Part::new(mesh, coping, options).map_err(|_| broken())?;
    if checksum(&part) != task.part {
        return Err(broken());
    }
    Ok(Carried(part))
}
