//! What a server and its workers can be told, one small struct a concern. Every flag is also an
//! environment variable; a server hands its own values on to the workers that it starts.

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::contract::Limits;

/// Where everything is kept.
#[derive(Debug, Clone, Args)]
pub struct DataDir {
    /// Directory of the database and the blobs, on a local disk. Made if need be.
    #[arg(long = "data", value_name = "DIR", env = "UVSEGNET_DATA")]
    #[arg(default_value = "uvsegnet-data")]
    pub root: PathBuf,
    /// Where uploads and artifacts are kept: a directory, or its URL (file:///PATH). If not given, in
    /// the data directory.
    #[arg(long, value_name = "URL", env = "UVSEGNET_BLOBS")]
    pub blobs: Option<String>,
}

impl DataDir {
    /// The database file.
    pub fn database(&self) -> PathBuf {
        self.root.join("uvsegnet.db")
    }

    /// The directory of the locks that living workers hold.
    pub fn workers(&self) -> PathBuf {
        self.root.join("workers")
    }

    /// These values as flags.
    pub fn to_flags(&self) -> Vec<OsString> {
        let mut flags = vec!["--data".into(), self.root.clone().into()];
        flags.extend(self.blobs.iter().flat_map(|blobs| ["--blobs".into(), blobs.into()]));
        flags
    }
}

/// What the service accepts.
#[derive(Debug, Clone, Args)]
pub struct LimitFlags {
    /// Most bytes of one upload.
    #[arg(long, value_name = "BYTES", env = "UVSEGNET_MAX_UPLOAD")]
    #[arg(default_value_t = Limits::default().upload_bytes)]
    pub max_upload: u64,
    /// Most triangles of one mesh file.
    #[arg(long, value_name = "N", env = "UVSEGNET_MAX_TRIANGLES")]
    #[arg(default_value_t = Limits::default().triangles)]
    pub max_triangles: u64,
    /// Most bytes of the JSON chunk of a glTF file.
    #[arg(long, value_name = "BYTES", env = "UVSEGNET_MAX_JSON")]
    #[arg(default_value_t = Limits::default().json_bytes)]
    pub max_json: u64,
    /// Greatest depth of the node hierarchy.
    #[arg(long, value_name = "N", env = "UVSEGNET_MAX_NODE_DEPTH")]
    #[arg(default_value_t = Limits::default().node_depth)]
    pub max_node_depth: u32,
    /// Seconds that a job may run.
    #[arg(long, value_name = "SECONDS", env = "UVSEGNET_JOB_TIMEOUT")]
    #[arg(default_value_t = Limits::default().job_seconds)]
    pub job_timeout: u64,
    /// Most MiB that a job may use.
    #[arg(long, value_name = "MIB", env = "UVSEGNET_JOB_MEMORY")]
    #[arg(default_value_t = Limits::default().job_mib)]
    pub job_memory: u64,
    /// Most jobs that may wait in the queue.
    #[arg(long, value_name = "N", env = "UVSEGNET_MAX_QUEUED")]
    #[arg(default_value_t = Limits::default().queued_jobs)]
    pub max_queued: u64,
}

impl LimitFlags {
    /// The limits that these flags mean.
    pub fn limits(&self) -> Limits {
        Limits {
            upload_bytes: self.max_upload,
            triangles: self.max_triangles,
            json_bytes: self.max_json,
            node_depth: self.max_node_depth,
            job_seconds: self.job_timeout,
            job_mib: self.job_memory,
            queued_jobs: self.max_queued,
        }
    }

    /// These values as flags.
    pub fn to_flags(&self) -> Vec<OsString> {
        let flags = [
            ("--max-upload", self.max_upload),
            ("--max-triangles", self.max_triangles),
            ("--max-json", self.max_json),
            ("--max-node-depth", u64::from(self.max_node_depth)),
            ("--job-timeout", self.job_timeout),
            ("--job-memory", self.job_memory),
            ("--max-queued", self.max_queued),
        ];
        flags.into_iter().flat_map(|(flag, n)| [flag.into(), n.to_string().into()]).collect()
    }
}

/// How long things take at most.
#[derive(Debug, Clone, Args)]
pub struct TimeFlags {
    /// Hours for which uploads and artifacts are kept once a job is over.
    #[arg(long, value_name = "HOURS", env = "UVSEGNET_RETENTION", default_value_t = 168.0)]
    #[arg(value_parser = not_negative)]
    pub retention: f64,
    /// Seconds a running job gets to finish at a shutdown, before it is handed back.
    #[arg(long, value_name = "SECONDS", env = "UVSEGNET_DRAIN_TIMEOUT", default_value_t = 20.0)]
    #[arg(value_parser = not_negative)]
    pub drain_timeout: f64,
}

impl TimeFlags {
    /// How long uploads and artifacts are kept.
    pub fn retention(&self) -> Duration {
        Duration::from_secs_f64(self.retention * 3600.0)
    }

    /// How long a running job gets at a shutdown.
    pub fn drain_timeout(&self) -> Duration {
        Duration::from_secs_f64(self.drain_timeout)
    }

    /// These values as flags.
    pub fn to_flags(&self) -> Vec<OsString> {
        let flags = [("--retention", self.retention), ("--drain-timeout", self.drain_timeout)];
        flags.into_iter().flat_map(|(flag, n)| [flag.into(), n.to_string().into()]).collect()
    }
}

/// A number of hours or seconds that a [`Duration`] can hold.
fn not_negative(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number".to_string())?;
    let fits = (0.0..=1e9).contains(&number);
    if fits { Ok(number) } else { Err("expected a number from 0 to 1000000000".into()) }
}

/// The name of this host, as its workers register it.
pub fn host_name() -> String {
    let system = ["/proc/sys/kernel/hostname", "/etc/hostname"];
    let name = system.into_iter().find_map(|file| std::fs::read_to_string(file).ok());
    let name = name.or_else(|| std::env::var("HOSTNAME").ok()).unwrap_or_default();
    let name = name.trim();
    if name.is_empty() { "localhost".into() } else { name.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        data: DataDir,
        #[command(flatten)]
        limits: LimitFlags,
        #[command(flatten)]
        times: TimeFlags,
    }

    #[test]
    fn flags_survive_being_handed_on() {
        let given = [
            "x",
            "--data",
            "/a b",
            "--blobs",
            "file:///c%20d",
            "--max-upload",
            "77",
            "--job-timeout",
            "3",
            "--retention",
            "0.5",
        ];
        let flags = Flags::parse_from(given);
        let mut handed_on: Vec<OsString> = vec!["x".into()];
        handed_on.extend(flags.data.to_flags());
        handed_on.extend(flags.limits.to_flags());
        handed_on.extend(flags.times.to_flags());
        let again = Flags::parse_from(handed_on);
        assert_eq!(again.data.root, PathBuf::from("/a b"));
        assert_eq!(again.data.blobs.as_deref(), Some("file:///c%20d"));
        assert_eq!(again.limits.limits(), flags.limits.limits());
        assert_eq!((again.limits.max_upload, again.limits.job_timeout), (77, 3));
        assert_eq!(again.times.retention(), Duration::from_secs(1800));
    }

    #[test]
    fn no_flags_are_the_default_limits() {
        let flags = Flags::parse_from(["x"]);
        assert_eq!(flags.limits.limits(), Limits::default());
        assert!(Flags::try_parse_from(["x", "--retention", "-1"]).is_err());
        assert!(Flags::try_parse_from(["x", "--drain-timeout", "inf"]).is_err());
    }
}
