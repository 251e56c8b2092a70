//! Lists, deletions, limits, changes.

use std::time::{Duration, Instant};

use uvsegnet::jobs::{Claim, Deleted, Handover, JobState, ListFilter, NewJob, QueueError};

use super::stores::{Store, on_every_store};
use super::{LIMIT, artifact, claim, mesh, new_job, submit};

on_every_store!(
    pages_are_stable_while_jobs_come,
    a_deleted_job_leaves_nothing,
    a_full_queue_takes_nothing,
    commits_of_others_are_noticed,
);

async fn pages_are_stable_while_jobs_come(store: Store) {
    let queue = store.fresh().await;
    let mut ids = Vec::new();
    for number in 0..25 {
        let tag = if number % 2 == 0 { "even" } else { "" };
        let job = NewJob { tag: tag.into(), ..new_job() };
        ids.push(queue.submit(job, LIMIT).await.unwrap().id);
    }
    ids.reverse();
    let mut filter = ListFilter { limit: 10, ..ListFilter::default() };
    let mut listed = Vec::new();
    loop {
        let page = queue.list(&filter).await.unwrap();
        listed.extend(page.jobs.iter().map(|job| job.id));
        submit(&*queue).await;
        match page.next_cursor {
            Some(cursor) => filter.cursor = Some(cursor),
            None => break,
        }
    }
    assert_eq!(listed, ids);

    let tagged = ListFilter { tag: Some("even".into()), ..ListFilter::default() };
    assert_eq!(queue.list(&tagged).await.unwrap().jobs.len(), 13);
    let running = claim(&*queue).await.job.id;
    let filter = ListFilter { state: Some(JobState::Running), ..ListFilter::default() };
    let page = queue.list(&filter).await.unwrap();
    assert_eq!((page.jobs.len(), page.jobs[0].id, page.next_cursor), (1, running, None));
    let filter = ListFilter { cursor: Some("nonsense".into()), ..ListFilter::default() };
    assert!(matches!(queue.list(&filter).await, Err(QueueError::Cursor)));
}

async fn a_deleted_job_leaves_nothing(store: Store) {
    let queue = store.fresh().await;
    let id = submit(&*queue).await;
    assert_eq!(queue.delete(id).await.unwrap(), Deleted::NotTerminal);
    let Claim { lease, job } = claim(&*queue).await;
    assert_eq!(queue.delete(id).await.unwrap(), Deleted::NotTerminal);
    let artifacts = vec![artifact("model.glb", "artifacts/x")];
    queue.finish(&lease, Handover { artifacts, ..Handover::default() }).await.unwrap();
    let last = queue.last_event_id().await.unwrap();
    let blobs = vec!["artifacts/x".to_string(), mesh(&job)];
    assert_eq!(queue.delete(id).await.unwrap(), Deleted::Deleted { blobs: blobs.clone() });
    assert_eq!(queue.delete(id).await.unwrap(), Deleted::NotFound);
    assert!(queue.get(id).await.unwrap().is_none());
    assert!(queue.events_after(id, 0, 10).await.unwrap().is_empty());
    assert!(queue.named(&blobs).await.unwrap().is_empty());
    // Ids of events are never given twice, or a stream that resumes would miss some.
    assert_eq!(queue.last_event_id().await.unwrap(), last);
    submit(&*queue).await;
    queue.release(&claim(&*queue).await.lease, vec![]).await.unwrap();
    assert!(queue.last_event_id().await.unwrap() > last);
}

async fn a_full_queue_takes_nothing(store: Store) {
    let queue = store.fresh().await;
    for _ in 0..3 {
        queue.submit(new_job(), 3).await.unwrap();
    }
    let full = queue.submit(new_job(), 3).await;
    assert!(matches!(full, Err(QueueError::Full { limit: 3 })));
    claim(&*queue).await;
    queue.submit(new_job(), 3).await.unwrap();
}

async fn commits_of_others_are_noticed(store: Store) {
    let queue = store.fresh().await;
    let mut changes = queue.changes.clone();
    tokio::time::timeout(Duration::from_secs(5), changes.changed()).await.unwrap();
    let quiet = tokio::time::timeout(Duration::from_millis(400), changes.changed()).await;
    assert!(quiet.is_err(), "nothing was committed");
    let other = queue.again().await;
    let began = Instant::now();
    submit(&*other).await;
    tokio::time::timeout(Duration::from_secs(5), changes.changed()).await.unwrap();
    assert!(began.elapsed() < Duration::from_secs(2), "{:?}", began.elapsed());
}
