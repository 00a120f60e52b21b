//! Frames from `calot tell`: a letter, the length of the body (u32, little endian), the body.

use tokio::io::{AsyncRead, AsyncReadExt as _};

use crate::error::CentreError;

/// Largest body, bytes.
const BODY_MAX: u32 = 4_000_000;

/// Kind of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The state as JSON.
    State,
    /// A small picture.
    Tile,
    /// A large picture.
    View,
    /// The answer to an act.
    Answer,
}

/// Reads the next frame. `None`: the program has ended.
///
/// # Errors
/// [`CentreError::Frame`] if the bytes are no frame.
pub async fn read(
    from: &mut (impl AsyncRead + Unpin),
) -> Result<Option<(Kind, Vec<u8>)>, CentreError> {
    let kind = match from.read_u8().await {
        Ok(b's') => Kind::State,
        Ok(b't') => Kind::Tile,
        Ok(b'v') => Kind::View,
        Ok(b'a') => Kind::Answer,
        Ok(other) => return Err(CentreError::Frame(format!("a frame of kind {other}"))),
        Err(_) => return Ok(None),
    };
    let Ok(length) = from.read_u32_le().await else {
        return Ok(None);
    };
    if length > BODY_MAX {
        let problem = format!("a frame of {length} bytes; {BODY_MAX} are allowed");
        return Err(CentreError::Frame(problem));
    }
    let mut body = vec![0; length as usize];
    Ok(from.read_exact(&mut body).await.ok().map(|_| (kind, body)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn frames_are_read_to_the_end_and_others_refused() {
        let mut bytes = &b"s\x02\0\0\0{}t\0\0\0\0v\x05\0\0\0xx"[..];
        let first = read(&mut bytes).await.unwrap();
        assert_eq!(first, Some((Kind::State, b"{}".to_vec())));
        let second = read(&mut bytes).await.unwrap();
        assert_eq!(second, Some((Kind::Tile, Vec::new())));
        assert_eq!(read(&mut bytes).await.unwrap(), None, "it is cut off");
        let said = read(&mut &b"x"[..]).await.unwrap_err().to_string();
        assert!(
            said.contains("sent a frame of kind 120; use programs of one version"),
            "{said}"
        );
        let said = read(&mut &b"s\xff\xff\xff\xff"[..])
            .await
            .unwrap_err()
            .to_string();
        assert!(said.contains("4294967295 bytes"), "{said}");
    }
}
