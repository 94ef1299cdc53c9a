//! Files that appear complete or not at all.

use std::collections::BTreeSet;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::{Builder, NamedTempFile};

use super::WriteError;

/// Files under passing names, of all threads.
static PASSING: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn passing() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PASSING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all files under passing names, lets none be made from now on, and
/// calls what ends the process.
///
/// For the handler of an interrupt, which runs while other threads write.
pub fn abandon(end: impl FnOnce()) {
    let mut passing = passing();
    for file in std::mem::take(&mut *passing) {
        // One that has just got its name is there no more.
        let _ = std::fs::remove_file(file);
    }
    end();
}

/// A complete file under a passing name, in the folder of its target.
///
/// Dropped without [`Staged::commit`], it vanishes.
#[derive(Debug)]
pub struct Staged {
    temp: Passing,
    target: PathBuf,
    file: PathBuf,
}

/// A file under a passing name, known to [`abandon`].
#[derive(Debug)]
struct Passing(Option<NamedTempFile>);

impl Passing {
    fn new(builder: &Builder, folder: &Path) -> io::Result<Passing> {
        let mut passing = passing();
        let temp = builder.tempfile_in(folder)?;
        passing.insert(temp.path().to_owned());
        Ok(Passing(Some(temp)))
    }

    fn file(&mut self) -> io::Result<&mut NamedTempFile> {
        self.0.as_mut().ok_or(io::ErrorKind::NotFound.into())
    }

    /// Gives the file its name.
    fn persist(mut self, target: &Path) -> io::Result<()> {
        let Some(temp) = self.0.take() else {
            return Ok(());
        };
        let path = temp.path().to_owned();
        let done = temp.persist(target);
        passing().remove(&path);
        done.map(|_| ()).map_err(|error| error.error)
    }
}

impl Drop for Passing {
    fn drop(&mut self) {
        if let Some(temp) = self.0.take() {
            let path = temp.path().to_owned();
            drop(temp);
            passing().remove(&path);
        }
    }
}

impl Write for Passing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file()?.flush()
    }
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
        temp.persist(&target)
            .map_err(|source| WriteError::Io { file, source })?;
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
    let stage = || -> io::Result<Passing> {
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
        let temp = Passing::new(&builder, &folder)?;
        let mut out = BufWriter::with_capacity(1 << 16, temp);
        write(&mut out)?;
        let mut temp = out.into_inner().map_err(|error| error.into_error())?;
        temp.file()?.as_file().sync_all()?;
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
