//! The body of an upload as it comes in: counted against our own limit, given up when it stalls, and
//! read to its end even when the answer is a refusal, so that the client gets to see the answer
//! (a socket closed with unread bytes is reset, and the reset overtakes the answer).

use std::time::Duration;

use axum::body::{Body, BodyDataStream};
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use futures::stream::{BoxStream, StreamExt, unfold};
use tokio::time::timeout;

use super::Problem;
use crate::contract::ErrorCode;

/// A client that sends nothing for this long has gone.
const STALL: Duration = Duration::from_secs(if cfg!(test) { 1 } else { 30 });
/// How long, and how many bytes, a refused body is read on for.
const LINGER: Duration = Duration::from_secs(5);
const LINGER_BYTES: u64 = 256 << 20;

/// Why a body could not be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BodyError {
    /// More bytes than may be.
    #[error("the upload is over the limit of {0} bytes")]
    TooLarge(u64),
    /// No byte came for a while.
    #[error("the body stopped coming for {} s before it was whole", STALL.as_secs())]
    Stalled,
    /// A form has more than this outside of its parts.
    #[error("the form has more than {0} bytes outside of its parts")]
    Unframed(u64),
    /// The connection or its framing broke.
    #[error("the body broke off: {0}")]
    Broken(String),
}

impl From<BodyError> for Problem {
    fn from(error: BodyError) -> Self {
        match error {
            BodyError::TooLarge(limit) => too_large(limit),
            error => Self::malformed(error.to_string()),
        }
    }
}

/// The refusal of an upload over `limit` bytes.
pub fn too_large(limit: u64) -> Problem {
    let detail = format!(
        "The upload is over the limit of {limit} bytes (limits.upload_bytes in /v1/info); send a smaller mesh, \
         or leave out textures and animations"
    );
    Problem::new(ErrorCode::UploadTooLarge, detail)
}

/// The body's chunks, at most `most` bytes in all. A length declared above that is refused before
/// the first byte is read.
pub fn counted(
    headers: &HeaderMap,
    body: Body,
    most: u64,
) -> Result<BoxStream<'static, Result<Bytes, BodyError>>, BodyError> {
    // A client that waits for "100 Continue" has sent nothing yet: nothing is to be read on.
    let waits = headers.contains_key(header::EXPECT);
    let incoming = Incoming { stream: Some(body.into_data_stream()), read: 0, drain: !waits };
    let declared = headers.get(header::CONTENT_LENGTH).and_then(|v| v.to_str().ok()?.parse().ok());
    if declared.is_some_and(|length: u64| length > most) {
        return Err(BodyError::TooLarge(most));
    }
    Ok(unfold(Some(incoming), move |state| async move {
        let mut incoming = state?;
        match incoming.next(most).await {
            Some(Ok(chunk)) => Some((Ok(chunk), Some(incoming))),
            Some(Err(error)) => Some((Err(error), None)),
            None => None,
        }
    })
    .boxed())
}

struct Incoming {
    stream: Option<BodyDataStream>,
    read: u64,
    drain: bool,
}

impl Incoming {
    async fn next(&mut self, most: u64) -> Option<Result<Bytes, BodyError>> {
        self.drain = true;
        let stream = self.stream.as_mut()?;
        let error = match timeout(STALL, stream.next()).await {
            Ok(Some(Ok(chunk))) => {
                self.read += chunk.len() as u64;
                if self.read <= most {
                    return Some(Ok(chunk));
                }
                return Some(Err(BodyError::TooLarge(most)));
            }
            Ok(Some(Err(error))) => BodyError::Broken(error.to_string()),
            Ok(None) => {
                self.stream = None;
                return None;
            }
            Err(_) => BodyError::Stalled,
        };
        self.stream = None;
        Some(Err(error))
    }
}

impl Drop for Incoming {
    fn drop(&mut self) {
        let (Some(mut stream), true) = (self.stream.take(), self.drain) else { return };
        let Ok(runtime) = tokio::runtime::Handle::try_current() else { return };
        runtime.spawn(timeout(LINGER, async move {
            let mut left = LINGER_BYTES;
            while let Some(Ok(chunk)) = stream.next().await {
                left = left.saturating_sub(chunk.len() as u64);
                if left == 0 {
                    break;
                }
            }
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use futures::TryStreamExt;

    fn body(chunks: &'static [&'static str]) -> Body {
        Body::from_stream(
            futures::stream::iter(chunks).map(|c| Ok::<_, BodyError>(Bytes::from(*c))),
        )
    }

    #[tokio::test]
    async fn bytes_are_counted() {
        let all = counted(&HeaderMap::new(), body(&["abc", "de"]), 5).unwrap();
        let chunks: Vec<Bytes> = all.try_collect().await.unwrap();
        assert_eq!(chunks.concat(), b"abcde");

        let mut over = counted(&HeaderMap::new(), body(&["abc", "de"]), 4).unwrap();
        assert_eq!(over.next().await.unwrap().unwrap(), "abc");
        assert_eq!(over.next().await.unwrap(), Err(BodyError::TooLarge(4)));
        assert_eq!(over.next().await, None);
    }

    #[tokio::test]
    async fn a_declared_length_is_refused_unread() {
        let headers = HeaderMap::from_iter([(header::CONTENT_LENGTH, "6".parse().unwrap())]);
        assert_eq!(counted(&headers, body(&["abc"]), 5).err(), Some(BodyError::TooLarge(5)));
    }

    #[tokio::test]
    async fn a_stalled_body_is_given_up() {
        let stream = futures::stream::pending::<Result<Bytes, BodyError>>();
        let mut stalled = counted(&HeaderMap::new(), Body::from_stream(stream), 5).unwrap();
        assert_eq!(stalled.next().await.unwrap(), Err(BodyError::Stalled));
    }
}
