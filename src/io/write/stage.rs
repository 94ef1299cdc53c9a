//! Files that appear complete or not at all.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::WriteError;

/// A complete file under a passing name, in the folder of its target.
///
/// Dropped without [`Staged::commit`], it vanishes.
#[derive(Debug)]
pub struct Staged {
    temp: NamedTempFile,
    target: PathBuf,
    file: PathBuf,
}

impl Staged {
    /// The file as it was asked for.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Gives the file its name, replacing what had it before.
    ///
    /// # Errors
    ///
    /// [`WriteError::Io`].
    pub fn commit(self) -> Result<(), WriteError> {
        let Staged { temp, target, file } = self;
        temp.persist(&target).map_err(|error| WriteError::Io {
            file,
            source: error.error,
        })?;
        // So that the new name outlives a power cut; where folders cannot be
        // opened the data is safe all the same.
        if let Some(Ok(folder)) = target.parent().map(std::fs::File::open) {
            let _ = folder.sync_all();
        }
        Ok(())
    }
}

/// Checks early that a file could be written: folder there, name free or a
/// regular file's.
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn check_target(file: &Path) -> Result<(), WriteError> {
    resolve(file).map(|_| ())
}

/// Folder and final name; a link is followed, so that it survives.
fn resolve(file: &Path) -> Result<(PathBuf, PathBuf), WriteError> {
    let not_a_file = || WriteError::NotAFile {
        file: file.to_owned(),
    };
    let target = match std::fs::metadata(file) {
        Ok(meta) if meta.is_file() => file.canonicalize().unwrap_or_else(|_| file.to_owned()),
        Ok(_) => return Err(not_a_file()),
        Err(_) => file.to_owned(),
    };
    if target.file_name().is_none() {
        return Err(not_a_file());
    }
    let folder = match target.parent() {
        Some(folder) if folder != Path::new("") => folder.to_owned(),
        _ => PathBuf::from("."),
    };
    if !folder.is_dir() {
        return Err(WriteError::NoFolder {
            file: file.to_owned(),
            folder,
        });
    }
    Ok((folder, target))
}

/// Writes a file completely, under a passing name beside its target, and
/// onto the disk.
///
/// # Errors
///
/// [`WriteError`] names the file; nothing is left behind.
pub fn stage(
    file: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<Staged, WriteError> {
    let (folder, target) = resolve(file)?;
    let stage = || -> io::Result<NamedTempFile> {
        let mut builder = Builder::new();
        builder.prefix(".midsurf-");
        // Readable as any new file is, not for the owner alone; the umask
        // takes its share.
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(&target).map_or(0o666, |meta| meta.permissions().mode());
            builder.permissions(std::fs::Permissions::from_mode(mode & 0o777));
        }
        let temp = builder.tempfile_in(&folder)?;
        let mut out = BufWriter::with_capacity(1 << 16, temp);
        write(&mut out)?;
        let temp = out.into_inner().map_err(|error| error.into_error())?;
        temp.as_file().sync_all()?;
        Ok(temp)
    };
    let temp = stage().map_err(|source| WriteError::Io {
        file: file.to_owned(),
        source,
    })?;
    Ok(Staged {
        temp,
        target,
        file: file.to_owned(),
    })
}
