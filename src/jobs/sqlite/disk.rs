//! SQLite's write-ahead log needs memory that all processes share, which a network file system does
//! not give (<https://sqlite.org/wal.html>): such a place is refused rather than corrupted.

use std::path::Path;

use super::QueueError;

/// Types of file system that lie on another host.
const NETWORK: [&str; 12] = [
    "nfs",
    "nfs4",
    "cifs",
    "smb3",
    "smbfs",
    "9p",
    "afs",
    "ceph",
    "lustre",
    "glusterfs",
    "fuse.sshfs",
    "fuse.glusterfs",
];

/// Refuse a database file on a network file system. Where the system does not tell (no
/// `/proc/self/mounts`), the place is taken to be local.
pub fn refuse_network(file: &Path) -> Result<(), QueueError> {
    let Ok(mounts) = std::fs::read_to_string("/proc/self/mounts") else { return Ok(()) };
    let folder = file.parent().unwrap_or(Path::new("."));
    let folder = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
    match kind_of(&folder, &mounts) {
        Some(kind) if NETWORK.contains(&kind) => Err(QueueError::Schema(format!(
            "{} lies on a network file system ({kind}): SQLite needs a local disk. Choose another \
             data directory",
            file.display()
        ))),
        _ => Ok(()),
    }
}

/// The type of the file system that `folder` lies on: that of the deepest mount above it, and of
/// the latest where several are mounted at one place.
fn kind_of<'a>(folder: &Path, mounts: &'a str) -> Option<&'a str> {
    let above = mounts.lines().filter_map(|line| {
        let mut fields = line.split(' ').skip(1);
        let (place, kind) = (fields.next()?.replace("\\040", " "), fields.next()?);
        folder.starts_with(&place).then_some((Path::new(&place).components().count(), kind))
    });
    above.max_by_key(|(depth, _)| *depth).map(|(_, kind)| kind)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_mount_decides() {
        let mounts = "/dev/sda1 / ext4 rw 0 0\nhost:/x /srv/shared nfs4 rw 0 0\n\
                      tmpfs /srv/shared/local\\040disk tmpfs rw 0 0\n";
        let kind = |folder| kind_of(Path::new(folder), mounts);
        assert_eq!(kind("/srv"), Some("ext4"));
        assert_eq!(kind("/srv/shared/data"), Some("nfs4"));
        assert_eq!(kind("/srv/shared/local disk/data"), Some("tmpfs"));
        assert_eq!(kind("/srv/sharedness"), Some("ext4"));
    }
}
