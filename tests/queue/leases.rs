//! Workers that die, fall silent or shut down.

use std::time::{Duration, Instant};

use uvsegnet::contract::ErrorCode;
use uvsegnet::jobs::{
    EventData, EventKind, Handover, JobState, QueueError, Tick, TickAnswer, Worker,
};

use super::stores::{Store, on_every_store};
use super::{claim, get, kinds, submit, worker};

on_every_store!(
    a_lapsed_lease_costs_an_attempt_and_the_last_one_the_job,
    an_extended_lease_does_not_lapse,
    the_jobs_of_a_dead_worker_are_taken_back_at_once,
    a_job_that_is_handed_back_has_spent_no_attempt,
);

async fn a_lapsed_lease_costs_an_attempt_and_the_last_one_the_job(store: Store) {
    let queue = store.fresh_with(|policy| policy.lease = Duration::from_millis(20)).await;
    let id = submit(&*queue).await;
    let mut leases = Vec::new();
    for attempt in 1..=3 {
        let claimed = claim(&*queue).await;
        assert_eq!((claimed.job.id, claimed.job.attempt), (id, attempt));
        leases.push(claimed.lease);
        tokio::time::sleep(Duration::from_millis(30)).await;
    }
    // The first two were taken back by the claims, the last one by the sweep.
    let swept = queue.sweep().await.unwrap();
    assert_eq!((swept.requeued, swept.failed, swept.canceled), (0, 1, 0));
    let job = get(&*queue, id).await;
    assert_eq!((job.state, job.attempt), (JobState::Failed, 3));
    let error = job.error.unwrap();
    assert_eq!(error.code, ErrorCode::WorkerCrashed);
    assert!(error.message.contains("attempt 3 of 3"), "{}", error.message);
    assert_eq!(
        kinds(&*queue, id).await,
        [EventKind::Retrying, EventKind::Retrying, EventKind::Failed]
    );
    for lease in leases {
        assert!(matches!(
            queue.finish(&lease, Handover::default()).await,
            Err(QueueError::LeaseLost)
        ));
    }
    assert!(queue.claim(&worker("w")).await.unwrap().is_none());
}

async fn an_extended_lease_does_not_lapse(store: Store) {
    let queue = store.fresh_with(|policy| policy.lease = Duration::from_millis(400)).await;
    submit(&*queue).await;
    let lease = claim(&*queue).await.lease;
    let began = Instant::now();
    while began.elapsed() < Duration::from_millis(1200) {
        let tick = Tick { extend: true, ..Tick::default() };
        assert_eq!(queue.tick(&lease, tick).await.unwrap(), TickAnswer::Continue);
        assert_eq!(queue.sweep().await.unwrap().requeued, 0);
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    queue.finish(&lease, Handover::default()).await.unwrap();
}

async fn the_jobs_of_a_dead_worker_are_taken_back_at_once(store: Store) {
    let queue = store.fresh().await;
    let (dead, alive) = (worker("dead"), worker("alive"));
    for one in [&dead, &alive] {
        queue.register(one).await.unwrap();
    }
    let (first, second) = (submit(&*queue).await, submit(&*queue).await);
    let lost = queue.claim(&dead).await.unwrap().unwrap();
    queue.claim(&alive).await.unwrap().unwrap();
    assert_eq!(queue.worker_gone("dead").await.unwrap().requeued, 1);
    assert_eq!(queue.worker_gone("dead").await.unwrap().requeued, 0);
    assert_eq!(get(&*queue, first).await.state, JobState::Queued);
    assert_eq!(get(&*queue, second).await.state, JobState::Running);
    let stats = queue.stats().await.unwrap();
    assert_eq!((stats.queued, stats.running, stats.workers_ready()), (1, 1, 1));
    assert_eq!(queue.workers_on("here").await.unwrap()[0].id, "alive");
    assert!(queue.workers_on("elsewhere").await.unwrap().is_empty());
    assert_eq!(queue.tick(&lost.lease, Tick::default()).await.unwrap(), TickAnswer::LeaseLost);
    let event = &queue.events_after(first, 0, 10).await.unwrap()[0];
    let EventData::Retrying(retrying) = &event.data else { panic!("{event:?}") };
    assert_eq!((retrying.attempt, retrying.code), (1, ErrorCode::WorkerCrashed));
    queue.register(&Worker { draining: true, ..alive }).await.unwrap();
    assert_eq!(queue.stats().await.unwrap().workers_ready(), 0);
}

async fn a_job_that_is_handed_back_has_spent_no_attempt(store: Store) {
    let queue = store.fresh().await;
    let id = submit(&*queue).await;
    for _ in 0..5 {
        let claimed = claim(&*queue).await;
        assert_eq!(claimed.job.attempt, 1);
        queue.release(&claimed.lease, vec![]).await.unwrap();
        let job = get(&*queue, id).await;
        assert_eq!((job.state, job.attempt, job.started_at), (JobState::Queued, 0, None));
    }
    assert_eq!(kinds(&*queue, id).await, [EventKind::Retrying; 5]);
    let lease = claim(&*queue).await.lease;
    queue.request_cancel(id).await.unwrap();
    queue.release(&lease, vec![]).await.unwrap();
    assert_eq!(get(&*queue, id).await.state, JobState::Canceled);
}
