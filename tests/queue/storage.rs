//! Blobs: written whole, kept while a row names them, swept when none does.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::{Duration, Instant};

use bytes::Bytes;
use futures::TryStreamExt;
use uvsegnet::contract::InputRole;
use uvsegnet::jobs::{BlobError, BlobFolder, Blobs, Claim, Handover, NewJob};

use super::stores::{Store, on_every_store};
use super::{LIMIT, artifact, claim, get, input, mesh, new_job, submit};

on_every_store!(blobs_expire_and_the_row_stays, what_no_row_names_is_swept,);

async fn blobs_expire_and_the_row_stays(store: Store) {
    let queue = store.fresh_with(|policy| policy.retention = Duration::ZERO).await;
    let (done, waiting) = (submit(&*queue).await, submit(&*queue).await);
    let Claim { lease, job } = claim(&*queue).await;
    assert_eq!(job.id, done);
    let artifacts = vec![artifact("model.glb", "artifacts/x")];
    queue.finish(&lease, Handover { artifacts, ..Handover::default() }).await.unwrap();
    assert!(get(&*queue, done).await.expired);
    let gone: BTreeSet<_> = queue.expire().await.unwrap().into_iter().collect();
    assert_eq!(gone, BTreeSet::from(["artifacts/x".to_string(), mesh(&job)]));
    assert!(queue.expire().await.unwrap().is_empty());
    let over = get(&*queue, done).await;
    assert!(over.expired && over.artifacts.len() == 1);
    let kept = mesh(&get(&*queue, waiting).await);
    let names = [mesh(&job), kept.clone()];
    assert_eq!(queue.named(&names).await.unwrap(), BTreeSet::from([kept]));
}

fn files(folder: &Path) -> usize {
    let folders = ["uploads", "artifacts"].map(|name| folder.join(name));
    folders.iter().map(|folder| std::fs::read_dir(folder).unwrap().count()).sum()
}

#[tokio::test]
async fn a_blob_is_there_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let blobs = Blobs::local(folder.path()).await.unwrap();
    let mut writer = blobs.begin(BlobFolder::Uploads).await.unwrap();
    let mut whole = Vec::new();
    for number in 0..13u32 {
        let chunk = Bytes::from(vec![number as u8; 1 << 20]);
        whole.extend_from_slice(&chunk);
        writer.write(chunk).await.unwrap();
    }
    assert_eq!(writer.len(), 13 << 20);
    let stored = writer.finish().await.unwrap();
    assert_eq!(stored.bytes, 13 << 20);
    assert_eq!(blobs.read(&stored.name).await.unwrap(), whole);
    let range = (1u64 << 20) - 1..(1u64 << 20) + 2;
    let chunks: Vec<Bytes> =
        blobs.get(&stored.name, Some(range)).await.unwrap().try_collect().await.unwrap();
    assert_eq!(chunks.concat(), [0, 1, 1]);

    let abc = blobs.put(BlobFolder::Artifacts, Bytes::from_static(b"abc")).await.unwrap();
    // The first test vector of FIPS 180-2.
    assert_eq!(abc.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    assert!(abc.name.starts_with("artifacts/"));

    let mut aborted = blobs.begin(BlobFolder::Uploads).await.unwrap();
    aborted.write(Bytes::from(vec![1; 6 << 20])).await.unwrap();
    assert_eq!(files(folder.path()), 3);
    drop(aborted);
    let began = Instant::now();
    while files(folder.path()) > 2 && began.elapsed() < Duration::from_secs(5) {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert_eq!(files(folder.path()), 2, "a writer that was dropped leaves nothing");

    blobs.delete(&stored.name).await.unwrap();
    blobs.delete(&stored.name).await.unwrap();
    assert!(matches!(blobs.read(&stored.name).await, Err(BlobError::NotFound(_))));
    assert!(matches!(blobs.get(&stored.name, None).await, Err(BlobError::NotFound(_))));
}

async fn what_no_row_names_is_swept(store: Store) {
    let queue = store.fresh().await;
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("blobs");
    let blobs = Blobs::open(&format!("file://{}", root.display())).await.unwrap();
    let kept = blobs.put(BlobFolder::Uploads, Bytes::from_static(b"kept")).await.unwrap();
    let inputs = [input(InputRole::Mesh, &kept.name)].into_iter().collect();
    queue.submit(NewJob { inputs, ..new_job() }, LIMIT).await.unwrap();
    let orphan = blobs.put(BlobFolder::Artifacts, Bytes::from_static(b"orphan")).await.unwrap();
    std::fs::write(root.join("uploads/left-by-a-dead-writer#1"), b"half").unwrap();

    let grace = Duration::from_secs(3600);
    assert_eq!(blobs.sweep_orphans(&*queue, grace).await.unwrap(), 0, "their rows may come yet");
    assert_eq!(blobs.sweep_orphans(&*queue, Duration::ZERO).await.unwrap(), 2);
    assert_eq!(blobs.read(&kept.name).await.unwrap(), "kept");
    assert!(matches!(blobs.read(&orphan.name).await, Err(BlobError::NotFound(_))));
    assert_eq!(files(&root), 1);
}
