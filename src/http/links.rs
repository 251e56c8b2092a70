//! The links of the OpenAPI document: where to go on from an answer. A generated client follows them, and a
//! tester reaches jobs that exist.

use serde_json::Value;
use utoipa::openapi::link::Link;
use utoipa::openapi::{OpenApi as Document, RefOr};

/// From the answers of an operation with one of these statuses to another operation, under a name.
pub struct Step {
    pub name: &'static str,
    pub from: &'static str,
    pub statuses: &'static [&'static str],
    pub to: &'static str,
    pub parameters: &'static [(&'static str, &'static str)],
}

/// A step that is named for the operation it goes to.
const fn step(
    from: &'static str,
    statuses: &'static [&'static str],
    to: &'static str,
    parameters: &'static [(&'static str, &'static str)],
) -> Step {
    Step { name: to, from, statuses, to, parameters }
}

/// The job that was answered.
const JOB: (&str, &str) = ("id", "$response.body#/id");
/// The job that was asked about.
const SAME_JOB: (&str, &str) = ("id", "$request.path.id");
/// Submitted: queued, or over within the wait.
const TAKEN: &[&str] = &["200", "202"];

/// Every link.
pub const STEPS: &[Step] = &[
    step("submit_job", TAKEN, "get_job", &[JOB]),
    step("submit_job", TAKEN, "cancel_job", &[JOB]),
    step("submit_job", TAKEN, "delete_job", &[JOB]),
    step("submit_job", TAKEN, "job_events", &[JOB]),
    Step {
        name: "list_events",
        ..step("submit_job", TAKEN, "job_events", &[JOB, ("header.Accept", "application/json")])
    },
    step("submit_job", TAKEN, "list_artifacts", &[JOB]),
    step(
        "submit_job",
        &["200"],
        "get_artifact",
        &[JOB, ("name", "$response.body#/artifacts/0/name")],
    ),
    step("list_jobs", &["200"], "get_job", &[("id", "$response.body#/data/0/id")]),
    step("list_jobs", &["200"], "list_jobs", &[("cursor", "$response.body#/next_cursor")]),
    step("get_job", &["200"], "cancel_job", &[JOB]),
    step("get_job", &["200"], "get_artifact", &[JOB, ("name", "$response.body#/artifacts/0/name")]),
    step("cancel_job", &["200"], "delete_job", &[JOB]),
    step("cancel_job", TAKEN, "get_job", &[JOB]),
    step(
        "list_artifacts",
        &["200"],
        "get_artifact",
        &[SAME_JOB, ("name", "$response.body#/data/0/name")],
    ),
];

/// Write the links into the answers of a document that has these operations.
pub fn add_links(document: &mut Document) {
    for Step { name, from, statuses, to, parameters } in STEPS {
        let link =
            parameters.iter().fold(Link::builder().operation_id(*to), |link, (name, value)| {
                link.parameter(*name, Value::from(*value))
            });
        let link = link.build();
        let paths = document.paths.paths.values_mut();
        let operations = paths.flat_map(|path| [&mut path.get, &mut path.post, &mut path.delete]);
        let answers = operations
            .flatten()
            .filter(|operation| operation.operation_id.as_deref() == Some(from))
            .flat_map(|operation| operation.responses.responses.iter_mut());
        for (status, answer) in answers {
            if let (true, RefOr::T(answer)) = (statuses.contains(&status.as_str()), answer) {
                answer.links.insert((*name).to_owned(), link.clone().into());
            }
        }
    }
}
