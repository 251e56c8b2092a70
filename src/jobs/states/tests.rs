//! Every way in which a job can stand meets every command: the promises hold each time. The
//! standings are those that any history reaches, found by trying everything from a new job on.

use std::collections::BTreeMap;

use jiff::{SignedDuration, Timestamp};

use super::{Change, Command, Ending, Gone, Held, Policy, Refusal, Standing, apply, submit};
use crate::contract::{ErrorCode, JobError, Stage, WarningCode};
use crate::jobs::{
    EventData, Handover, JobProgress, JobState, MetricsSummary, NewEvent, QueueError,
    StoredArtifact, Swept, Tick, WarningEvent, Worker,
};

const MINE: &str = "mine";
const FOREIGN: &str = "foreign";

fn policy() -> Policy {
    Policy { max_attempts: 2, ..Policy::default() }
}

/// The beginning, when a lease has lapsed, when the files have expired.
fn moments() -> [Timestamp; 3] {
    [0, 60, 30 * 24 * 3600].map(|s| Timestamp::from_second(1_700_000_000 + s).unwrap())
}

fn worker(id: &str) -> Worker {
    Worker {
        id: id.into(),
        pid: 1,
        host: "here".into(),
        device: "cpu".into(),
        engine: "1.2.3".into(),
        weights: Some("sha256:ab".into()),
        threads: 2,
        draining: false,
        last_seen: Timestamp::UNIX_EPOCH,
    }
}

fn warning() -> NewEvent {
    NewEvent {
        data: EventData::Warning(WarningEvent { code: WarningCode::Degraded, message: "y".into() }),
        at: Timestamp::UNIX_EPOCH,
    }
}

fn progress() -> JobProgress {
    JobProgress { stage: Stage::Train, fraction: 0.5, parts_done: 1, parts_total: 2, eta_s: None }
}

fn handover() -> Handover {
    Handover {
        events: vec![warning()],
        progress: Some(progress()),
        artifacts: vec![StoredArtifact {
            name: "model.glb".into(),
            media_type: "model/gltf-binary".into(),
            bytes: 3,
            sha256: "ab".repeat(32),
            blob: "artifacts/x".into(),
        }],
        metrics: Some(MetricsSummary { charts: 5, ..MetricsSummary::default() }),
    }
}

fn failed(code: ErrorCode) -> Ending {
    Ending::Failed(JobError::new(code, "because"))
}

/// What whoever knows this token may say.
fn by_holder(token: &str) -> Vec<Command<'_>> {
    let tick = |events: &[NewEvent], progress, extend| {
        Command::Tick(token, Tick { events: events.to_vec(), progress, extend })
    };
    let mut commands = vec![
        tick(&[], None, false),
        tick(&[], None, true),
        tick(&[warning(), warning()], Some(progress()), true),
        Command::End(token, Ending::Succeeded, handover()),
        Command::End(token, Ending::Succeeded, Handover::default()),
        Command::End(token, Ending::Canceled, handover()),
        Command::Release(token, vec![warning()]),
    ];
    let codes = ErrorCode::ALL.iter();
    commands.extend(codes.map(|code| Command::End(token, failed(*code), handover())));
    commands
}

/// What anybody may say; `MINE` is the token of every claim, "w" the worker.
fn by_anybody(worker: &Worker) -> Vec<Command<'_>> {
    vec![
        Command::Claim { worker, token: MINE },
        Command::RequestCancel,
        Command::TakeBack(Gone::Worker("w")),
        Command::TakeBack(Gone::Worker("another")),
        Command::TakeBack(Gone::Lapsed),
        Command::Expire,
        Command::Delete,
    ]
}

/// Every standing that a history of commands at those moments reaches, but for its counters.
fn reachable() -> Vec<Standing> {
    let worker = worker("w");
    let first = submit(0, 1, &policy(), moments()[0]).unwrap();
    let key = |standing: &Standing| {
        format!("{:?}", Standing { last_seq: 0, revision: 0, ..standing.clone() })
    };
    let mut found = BTreeMap::from([(key(&first), first.clone())]);
    let mut open = vec![first];
    while let Some(standing) = open.pop() {
        for command in by_anybody(&worker).into_iter().chain(by_holder(MINE)) {
            for now in moments() {
                let Ok(change) = apply(&standing, command.clone(), &policy(), now) else {
                    continue;
                };
                if found.insert(key(&change.standing), change.standing.clone()).is_none() {
                    open.push(change.standing);
                }
            }
        }
    }
    found.into_values().collect()
}

/// Every standing with every command at every moment.
fn everything(mut look: impl FnMut(&Standing, &Command<'_>, Timestamp, Result<Change, Refusal>)) {
    let worker = worker("w");
    let standings = reachable();
    let states = JobState::ALL.map(|state| standings.iter().filter(|s| s.state == state).count());
    assert!(states.iter().all(|count| *count > 2), "reached {states:?}");
    for standing in &standings {
        let held = by_holder(MINE).into_iter().chain(by_holder(FOREIGN));
        for command in by_anybody(&worker).into_iter().chain(held) {
            for now in moments() {
                look(standing, &command, now, apply(standing, command.clone(), &policy(), now));
            }
        }
    }
}

fn is_claim(command: &Command<'_>) -> bool {
    matches!(command, Command::Claim { .. })
}

fn token<'a>(command: &'a Command<'_>) -> Option<&'a str> {
    match command {
        Command::Tick(token, _) | Command::End(token, ..) | Command::Release(token, _) => {
            Some(token)
        }
        _ => None,
    }
}

#[test]
fn whatever_is_refused_is_refused_for_the_right_reason() {
    everything(|before, command, now, change| {
        let running = before.state == JobState::Running;
        let over = before.state.is_terminal();
        let due = before.expires_at.is_some_and(|at| at <= now);
        let lapsed = before.held.as_ref().is_some_and(|held| held.until < now);
        let expected = match command {
            Command::Claim { .. } if before.state != JobState::Queued => Err(Refusal::NotWaiting),
            Command::TakeBack(Gone::Worker("w")) if !running => Err(Refusal::NotLost),
            Command::TakeBack(Gone::Worker("another")) => Err(Refusal::NotLost),
            Command::TakeBack(Gone::Lapsed) if !lapsed => Err(Refusal::NotLost),
            Command::Expire if !(over && due && !before.expired) => Err(Refusal::NotDue),
            Command::Delete if !over => Err(Refusal::NotOver),
            command if token(command).is_some_and(|token| !running || token != MINE) => {
                Err(Refusal::LeaseLost)
            }
            _ => Ok(()),
        };
        assert_eq!(change.map(|_| ()), expected, "{before:?} {command:?}");
    });
}

#[test]
fn every_standing_is_whole() {
    for standing in reachable() {
        let over = standing.state.is_terminal();
        assert!(standing.attempt <= standing.max_attempts, "{standing:?}");
        assert_eq!(standing.held.is_some(), standing.state == JobState::Running);
        assert_eq!(standing.error.is_some(), standing.state == JobState::Failed);
        assert!(standing.metrics.is_none() || standing.state == JobState::Succeeded);
        assert_eq!((standing.finished_at.is_some(), standing.expires_at.is_some()), (over, over));
        assert!(over || !standing.expired);
        assert!(standing.state != JobState::Queued || standing.started_at.is_none());
        assert!(standing.state != JobState::Queued || !standing.cancel_requested);
        assert!(standing.held.is_none() || standing.started_at.is_some());
    }
}

#[test]
fn what_is_over_stays_as_it_is() {
    everything(|before, command, _, change| {
        let Ok(change) = change else { return };
        if !before.state.is_terminal() {
            return;
        }
        assert!(change.events.is_empty(), "{command:?}");
        assert!(change.effects.artifacts.is_empty());
        let expired = change.standing.expired;
        let but_for_expiry = Standing {
            expired: before.expired,
            revision: before.revision,
            ..change.standing.clone()
        };
        assert_eq!(but_for_expiry, *before, "{command:?}");
        assert_eq!(expired && !before.expired, matches!(command, Command::Expire));
        let goes = matches!(command, Command::Expire | Command::Delete);
        assert_eq!(change.effects.blobs_may_go, goes);
        assert_eq!(change.effects.row_goes, matches!(command, Command::Delete));
    });
}

#[test]
fn numbers_only_grow_and_tell_every_change() {
    everything(|before, command, _, change| {
        let Ok(change) = change else { return };
        let after = &change.standing;
        assert_eq!(after.last_seq, before.last_seq + change.events.len() as u64);
        assert_eq!(
            (after.created_at, after.max_attempts),
            (before.created_at, before.max_attempts)
        );
        let seen = Standing { held: None, revision: 0, ..after.clone() }
            != Standing { held: None, revision: 0, ..before.clone() };
        let grown = after.revision - before.revision;
        assert_eq!(grown, u64::from(seen), "{command:?}");
        let attempts = i64::from(after.attempt) - i64::from(before.attempt);
        match command {
            Command::Claim { .. } => assert_eq!(attempts, 1),
            Command::Release(..) if !before.cancel_requested => assert_eq!(attempts, -1),
            _ => assert_eq!(attempts, 0, "{command:?}"),
        }
    });
}

#[test]
fn an_end_is_told_once_and_last() {
    everything(|before, command, now, change| {
        let Ok(Change { standing: after, events, effects }) = change else { return };
        let ends = events.iter().filter(|event| event.kind().is_terminal()).count();
        let ended = after.state.is_terminal() && !before.state.is_terminal();
        assert_eq!(ends, usize::from(ended), "{command:?}");
        if ended {
            assert_eq!(events.last().unwrap().kind().as_str(), after.state.as_str());
            assert_eq!(after.finished_at, Some(now));
            assert_eq!(after.expires_at, Some(now + policy().retention));
        }
        // A file is named by a job that ended with it, or by none.
        let kept = !effects.artifacts.is_empty();
        assert!(!kept || matches!(after.state, JobState::Succeeded | JobState::Failed));
        let waits_again = before.state == JobState::Running && after.state == JobState::Queued;
        let retrying = events.iter().any(|e| matches!(e.data, EventData::Retrying(_)));
        assert_eq!(waits_again, retrying, "{command:?}");
    });
}

#[test]
fn a_lost_machine_costs_an_attempt_and_the_last_one_the_job() {
    everything(|before, command, _, change| {
        let Ok(change) = change else { return };
        let lost = match command {
            Command::TakeBack(_) => true,
            Command::End(_, Ending::Failed(error), _) => {
                matches!(error.code, ErrorCode::DeviceLost | ErrorCode::WorkerCrashed)
            }
            _ => return,
        };
        let left = before.attempt < before.max_attempts;
        let expected = match (lost, before.cancel_requested) {
            (true, true) => JobState::Canceled,
            (true, false) if left => JobState::Queued,
            _ => JobState::Failed,
        };
        assert_eq!(change.standing.state, expected, "{command:?}");
        let swept = match (command, expected) {
            (Command::TakeBack(_), JobState::Queued) => Swept { requeued: 1, ..Swept::default() },
            (Command::TakeBack(_), JobState::Failed) => Swept { failed: 1, ..Swept::default() },
            (Command::TakeBack(_), _) => Swept { canceled: 1, ..Swept::default() },
            _ => Swept::default(),
        };
        assert_eq!(change.effects.swept, swept);
    });
}

#[test]
fn an_ending_is_what_the_holder_says() {
    everything(|before, command, _, change| {
        let (Ok(change), Command::End(_, ending, handover)) = (change, command) else { return };
        let after = change.standing;
        match ending {
            Ending::Succeeded => {
                assert_eq!(after.state, JobState::Succeeded);
                assert_eq!(after.metrics, handover.metrics);
                assert_eq!(change.effects.artifacts, handover.artifacts);
            }
            Ending::Canceled => assert_eq!(after.state, JobState::Canceled),
            Ending::Failed(error) if after.state == JobState::Failed => {
                assert_eq!(after.error.as_ref(), Some(error));
                assert_eq!(change.effects.artifacts, handover.artifacts);
            }
            Ending::Failed(_) => assert!(change.effects.artifacts.is_empty()),
        }
        assert_eq!(change.events[..handover.events.len()], handover.events);
        if handover.progress.is_some() && after.state != JobState::Queued {
            assert_eq!(after.progress, handover.progress);
        }
        assert_eq!(before.state, JobState::Running);
    });
}

#[test]
fn a_claim_is_a_fresh_lease_of_that_worker() {
    everything(|_, command, now, change| {
        let Ok(Change { standing, events, .. }) = change else { return };
        if is_claim(command) {
            let until = now + policy().lease;
            let held = Held { worker: "w".into(), token: MINE.into(), until };
            assert_eq!((standing.state, standing.held), (JobState::Running, Some(held)));
            assert_eq!((standing.progress, standing.started_at), (None, Some(now)));
            assert_eq!(standing.versions.engine, "1.2.3");
            assert_eq!(standing.versions.weights.as_deref(), Some("sha256:ab"));
            assert_eq!(standing.device.as_deref(), Some("cpu"));
            assert!(events.is_empty());
        }
    });
}

#[test]
fn only_an_extension_moves_the_end_of_a_lease() {
    everything(|before, command, now, change| {
        let (Ok(change), Command::Tick(_, tick)) = (change, command) else { return };
        let before = before.held.clone().unwrap();
        let until = if tick.extend { now + policy().lease } else { before.until };
        assert_eq!(change.standing.held, Some(Held { until, ..before }));
    });
}

#[test]
fn a_lease_has_lapsed_when_its_end_is_over_and_not_before() {
    let [begin, ..] = moments();
    let worker = worker("w");
    let claim = Command::Claim { worker: &worker, token: MINE };
    let waiting = submit(0, 1, &policy(), begin).unwrap();
    let running = apply(&waiting, claim, &policy(), begin).unwrap().standing;
    let end = running.held.as_ref().unwrap().until;
    let at = |now| apply(&running, Command::TakeBack(Gone::Lapsed), &policy(), now).map(|_| ());
    assert_eq!(at(end), Err(Refusal::NotLost));
    assert_eq!(at(end + SignedDuration::from_nanos(1)), Ok(()));
}

#[test]
fn messages_say_what_happened() {
    let [begin, late, _] = moments();
    let first = submit(0, 1, &policy(), begin).unwrap();
    let worker = worker("w");
    let claim = Command::Claim { worker: &worker, token: MINE };
    let running = apply(&first, claim, &policy(), begin).unwrap().standing;
    let told = |command| {
        let change = apply(&running, command, &policy(), late).unwrap();
        serde_json::to_string(&change.events.last().unwrap().data).unwrap()
    };
    assert_eq!(
        told(Command::TakeBack(Gone::Worker("w"))),
        r#"{"attempt":1,"max_attempts":2,"code":"worker_crashed","message":"the worker process died while it ran the job (attempt 1 of 2)"}"#
    );
    assert_eq!(
        told(Command::TakeBack(Gone::Lapsed)),
        r#"{"attempt":1,"max_attempts":2,"code":"worker_crashed","message":"the worker was not heard of any more while it ran the job (attempt 1 of 2)"}"#
    );
    assert_eq!(
        told(Command::Release(MINE, vec![])),
        r#"{"attempt":1,"max_attempts":2,"code":"draining","message":"the worker shut down in the middle"}"#
    );
}

#[test]
fn a_full_queue_takes_nothing() {
    let now = moments()[0];
    assert!(matches!(submit(3, 3, &policy(), now), Err(QueueError::Full { limit: 3 })));
    let waiting = submit(2, 3, &policy(), now).unwrap();
    assert_eq!((waiting.state, waiting.attempt, waiting.max_attempts), (JobState::Queued, 0, 2));
    assert_eq!((waiting.revision, waiting.last_seq), (1, 0));
}
