//! The way of a job from its submission to its end.

use std::collections::BTreeSet;

use jiff::Timestamp;
use serde_json::json;
use uvsegnet::contract::{ErrorCode, InputRole, Stage};
use uvsegnet::jobs::{
    CancelOutcome, Claim, EventKind, Handover, JobId, JobProgress, JobState, MetricsSummary,
    NewJob, QueueError, Tick, TickAnswer,
};

use super::stores::{Store, on_every_store};
use super::{LIMIT, artifact, claim, error, get, input, kinds, new_job, submit, warning, worker};

on_every_store!(
    a_job_is_stored_as_it_was_given,
    a_job_goes_its_way_to_success,
    claims_go_by_priority_and_then_by_age,
    each_job_is_claimed_once_and_every_event_is_seen,
    only_errors_of_the_machine_are_tried_again,
    cancel_meets_every_state,
);

async fn a_job_is_stored_as_it_was_given(store: Store) {
    let queue = store.fresh().await;
    // The order in which files come does not matter.
    let inputs = [input(InputRole::Labels, "uploads/l"), input(InputRole::Mesh, "uploads/m")];
    let inputs = inputs.into_iter().collect();
    let given = NewJob { inputs, tag: "t".into(), ..new_job() };
    let stored = queue.submit(given.clone(), LIMIT).await.unwrap();
    assert_eq!(stored, get(&*queue, given.id).await);
    assert_eq!((stored.state, stored.attempt, stored.max_attempts), (JobState::Queued, 0, 3));
    assert_eq!((&stored.options, &stored.tag), (&given.options, &given.tag));
    assert_eq!(stored.inputs, given.inputs);
    let roles: Vec<_> = stored.inputs.iter().map(|input| input.role).collect();
    assert_eq!(roles, [InputRole::Mesh, InputRole::Labels]);
    assert_eq!(stored.inputs.labels(), Some(&input(InputRole::Labels, "uploads/l")));
    assert!(stored.created_at <= Timestamp::now() && stored.started_at.is_none());
    assert!(queue.get(JobId::new()).await.unwrap().is_none());
}

async fn a_job_goes_its_way_to_success(store: Store) {
    let queue = store.fresh().await;
    let id = submit(&*queue).await;
    let Claim { job, lease } = claim(&*queue).await;
    assert_eq!((job.id, job.state, job.attempt), (id, JobState::Running, 1));
    assert_eq!((job.versions.engine.as_str(), job.device.as_deref()), ("1.2.3", Some("cpu")));
    assert_eq!(job.versions.weights.as_deref(), Some("sha256:ab"), "those of the worker");
    assert!(job.started_at.is_some());
    assert!(queue.claim(&worker("other")).await.unwrap().is_none());

    let progress = JobProgress {
        stage: Stage::Train,
        fraction: 0.5,
        parts_done: 1,
        parts_total: 2,
        eta_s: Some(3.0),
    };
    let tick =
        Tick { events: vec![warning()], progress: Some(progress.clone()), ..Tick::default() };
    assert_eq!(queue.tick(&lease, tick).await.unwrap(), TickAnswer::Continue);
    let running = get(&*queue, id).await;
    assert_eq!((running.progress, running.last_seq), (Some(progress), 1));
    assert!(running.revision > job.revision);

    let metrics = MetricsSummary { valid: true, charts: 5, ..MetricsSummary::default() };
    let handover = Handover {
        events: vec![warning()],
        artifacts: vec![artifact("model.glb", "artifacts/b"), artifact("a.json", "artifacts/a")],
        metrics: Some(metrics.clone()),
        progress: None,
    };
    queue.finish(&lease, handover.clone()).await.unwrap();
    let over = get(&*queue, id).await;
    assert_eq!((over.state, over.metrics, over.error), (JobState::Succeeded, Some(metrics), None));
    assert_eq!(over.artifacts, handover.artifacts);
    assert!(over.finished_at.unwrap() < over.expires_at.unwrap() && !over.expired);
    assert_eq!(
        kinds(&*queue, id).await,
        [EventKind::Warning, EventKind::Warning, EventKind::Succeeded]
    );
    let last = queue.events_after(id, 2, 10).await.unwrap();
    let data = serde_json::to_value(&last[0].data).unwrap();
    assert_eq!(data["artifacts"], json!(["model.glb", "a.json"]));
    assert_eq!(data["metrics"]["charts"], 5);

    // The lease is worth nothing any more.
    assert!(matches!(queue.finish(&lease, handover).await, Err(QueueError::LeaseLost)));
    let late = Tick { events: vec![warning()], ..Tick::default() };
    assert_eq!(queue.tick(&lease, late).await.unwrap(), TickAnswer::LeaseLost);
    assert_eq!(get(&*queue, id).await.last_seq, 3);
}

async fn claims_go_by_priority_and_then_by_age(store: Store) {
    let queue = store.fresh().await;
    let mut ids = Vec::new();
    for priority in [0, 5, 0, 5] {
        let job = NewJob { priority, ..new_job() };
        ids.push(queue.submit(job, LIMIT).await.unwrap().id);
    }
    let expected = [ids[1], ids[3], ids[0], ids[2]];
    for (position, id) in (0..).zip(expected) {
        assert_eq!(get(&*queue, id).await.queue_position, position);
    }
    for id in expected {
        let claimed = claim(&*queue).await;
        assert_eq!((claimed.job.id, claimed.job.queue_position), (id, 0));
    }
    assert!(queue.claim(&worker("w")).await.unwrap().is_none());
}

async fn each_job_is_claimed_once_and_every_event_is_seen(store: Store) {
    let queue = store.fresh().await;
    let mut ids = BTreeSet::new();
    for _ in 0..40 {
        ids.insert(submit(&*queue).await);
    }
    let mut workers = Vec::new();
    for number in 0..4 {
        // Each with connections of its own, as in processes of their own.
        let queue = queue.again().await;
        workers.push(tokio::spawn(async move {
            let (me, mut mine) = (worker(&format!("w{number}")), Vec::new());
            while let Some(Claim { job, lease }) = queue.claim(&me).await.unwrap() {
                let events = vec![warning(), warning()];
                queue.tick(&lease, Tick { events, ..Tick::default() }).await.unwrap();
                queue.finish(&lease, Handover::default()).await.unwrap();
                mine.push(job.id);
            }
            mine
        }));
    }
    // A reader that only ever goes on from the last id that it saw must see every event.
    let (mut last, mut seen) = (0, Vec::new());
    while seen.len() < 3 * ids.len() {
        for event in queue.all_events_after(last, 7).await.unwrap() {
            assert!(event.event_id > last);
            last = event.event_id;
            seen.push((event.job_id, event.seq));
        }
    }
    let mut claimed = Vec::new();
    for worker in workers {
        claimed.extend(worker.await.unwrap());
    }
    assert_eq!(claimed.len(), ids.len());
    assert_eq!(claimed.into_iter().collect::<BTreeSet<_>>(), ids);
    let expected: BTreeSet<_> = ids.iter().flat_map(|&id| [(id, 1), (id, 2), (id, 3)]).collect();
    assert_eq!(seen.into_iter().collect::<BTreeSet<_>>(), expected);
    assert_eq!(queue.last_event_id().await.unwrap(), last);
}

async fn only_errors_of_the_machine_are_tried_again(store: Store) {
    let queue = store.fresh().await;
    let id = submit(&*queue).await;
    let lease = claim(&*queue).await.lease;
    let handover =
        Handover { artifacts: vec![artifact("log.jsonl", "artifacts/log")], ..Handover::default() };
    let state = queue.fail(&lease, error(ErrorCode::InvalidMesh), handover).await.unwrap();
    let job = get(&*queue, id).await;
    assert_eq!((state, job.state, job.attempt), (JobState::Failed, JobState::Failed, 1));
    assert_eq!(job.error, Some(error(ErrorCode::InvalidMesh)));
    assert_eq!(job.artifacts[0].name, "log.jsonl");

    let id = submit(&*queue).await;
    for expected in [JobState::Queued, JobState::Queued, JobState::Failed] {
        let lease = claim(&*queue).await.lease;
        let lost = error(ErrorCode::DeviceLost);
        assert_eq!(queue.fail(&lease, lost, Handover::default()).await.unwrap(), expected);
    }
    assert_eq!(get(&*queue, id).await.error, Some(error(ErrorCode::DeviceLost)));
}

async fn cancel_meets_every_state(store: Store) {
    let queue = store.fresh().await;
    assert!(matches!(queue.request_cancel(JobId::new()).await.unwrap(), CancelOutcome::NotFound));

    let waiting = submit(&*queue).await;
    for _ in 0..2 {
        let outcome = queue.request_cancel(waiting).await.unwrap();
        assert!(matches!(outcome, CancelOutcome::Over(job) if job.state == JobState::Canceled));
    }
    assert_eq!(kinds(&*queue, waiting).await, [EventKind::Canceled]);
    assert!(queue.claim(&worker("w")).await.unwrap().is_none());

    let running = submit(&*queue).await;
    let lease = claim(&*queue).await.lease;
    for _ in 0..2 {
        let outcome = queue.request_cancel(running).await.unwrap();
        assert!(matches!(outcome, CancelOutcome::Requested(job) if job.cancel_requested));
    }
    assert_eq!(queue.tick(&lease, Tick::default()).await.unwrap(), TickAnswer::Cancel);
    queue.canceled(&lease, Handover::default()).await.unwrap();
    assert_eq!(get(&*queue, running).await.state, JobState::Canceled);

    let crashed = submit(&*queue).await;
    claim(&*queue).await;
    queue.request_cancel(crashed).await.unwrap();
    assert_eq!(queue.worker_gone("w").await.unwrap().canceled, 1);
    assert_eq!(kinds(&*queue, crashed).await, [EventKind::Canceled]);
}
