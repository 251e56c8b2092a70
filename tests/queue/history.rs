//! Whatever happens, in whatever order and with whatever stale lease: the promises hold.

use std::collections::BTreeSet;

use proptest::prelude::*;
use uvsegnet::contract::ErrorCode;
use uvsegnet::jobs::{Handover, JobState, Lease, QueueError, Tick, TickAnswer};

use super::stores::Store;
use super::{error, get, kinds, submit, warning, worker};

/// One thing that may happen to the queue.
#[derive(Debug, Clone)]
enum Step {
    Submit,
    Claim,
    Tick(usize),
    Finish(usize),
    Fail(usize, ErrorCode),
    Canceled(usize),
    Release(usize),
    Cancel(usize),
    Crash,
}

fn step() -> impl Strategy<Value = Step> {
    let code = prop_oneof![Just(ErrorCode::InvalidMesh), Just(ErrorCode::DeviceLost)];
    prop_oneof![
        2 => Just(Step::Submit),
        4 => Just(Step::Claim),
        2 => (0usize..8).prop_map(Step::Tick),
        1 => (0usize..8).prop_map(Step::Finish),
        1 => (0usize..8, code).prop_map(|(lease, code)| Step::Fail(lease, code)),
        1 => (0usize..8).prop_map(Step::Canceled),
        1 => (0usize..8).prop_map(Step::Release),
        1 => (0usize..8).prop_map(Step::Cancel),
        1 => Just(Step::Crash),
    ]
}

/// Whatever happens, in whatever order, with whatever stale lease.
async fn any_history(store: Store, steps: Vec<Step>) {
    let queue = store.fresh().await;
    let (mut jobs, mut leases, mut over) = (Vec::new(), Vec::new(), BTreeSet::new());
    let lease = |leases: &[Lease], number: usize| {
        leases.len().checked_sub(1).map(|last| leases[last.saturating_sub(number)].clone())
    };
    for step in steps {
        match step {
            Step::Submit => jobs.push(submit(&*queue).await),
            Step::Claim => {
                leases.extend(queue.claim(&worker("w")).await.unwrap().map(|claim| claim.lease));
            }
            Step::Crash => {
                queue.worker_gone("w").await.unwrap();
            }
            Step::Cancel(number) if number < jobs.len() => {
                queue.request_cancel(jobs[number]).await.unwrap();
            }
            Step::Cancel(_) => {}
            Step::Tick(number)
            | Step::Finish(number)
            | Step::Canceled(number)
            | Step::Release(number)
            | Step::Fail(number, _) => {
                let Some(lease) = lease(&leases, number) else { continue };
                let before = get(&*queue, lease.job).await;
                let late = match step {
                    Step::Tick(_) => {
                        let tick = Tick { events: vec![warning()], ..Tick::default() };
                        queue.tick(&lease, tick).await.unwrap() == TickAnswer::LeaseLost
                    }
                    Step::Finish(_) => is_late(queue.finish(&lease, Handover::default()).await),
                    Step::Canceled(_) => is_late(queue.canceled(&lease, Handover::default()).await),
                    Step::Fail(_, code) => {
                        is_late(queue.fail(&lease, error(code), Handover::default()).await)
                    }
                    _ => is_late(queue.release(&lease, vec![]).await),
                };
                if late {
                    assert_eq!(
                        get(&*queue, lease.job).await,
                        before,
                        "a lost lease changes nothing"
                    );
                }
            }
        }
        for &id in &jobs {
            let job = get(&*queue, id).await;
            assert!(job.attempt <= job.max_attempts);
            assert_eq!(
                job.state == JobState::Running,
                job.started_at.is_some() && !job.state.is_terminal()
            );
            let kinds = kinds(&*queue, id).await;
            assert_eq!(kinds.len() as u64, job.last_seq);
            let ends = kinds.iter().filter(|kind| kind.is_terminal()).count();
            assert_eq!(ends, usize::from(job.state.is_terminal()));
            if job.state.is_terminal() {
                assert_eq!(kinds.last().unwrap().as_str(), job.state.as_str());
                over.insert(id);
            }
            assert!(!over.contains(&id) || job.state.is_terminal(), "what is over stays over");
            assert_eq!(job.error.is_some(), job.state == JobState::Failed);
        }
    }
}

fn is_late<T>(result: Result<T, QueueError>) -> bool {
    match result {
        Ok(_) => false,
        Err(QueueError::LeaseLost) => true,
        Err(error) => panic!("{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn no_history_breaks_a_promise(steps in prop::collection::vec(step(), 1..30)) {
        let runtime = tokio::runtime::Runtime::new().unwrap();
        runtime.block_on(async {
            any_history(Store::Memory, steps.clone()).await;
            any_history(Store::Sqlite, steps).await;
        });
    }
}
