//! Answers from the store, for the page: people, their sessions, and the alarms of a station.

use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse as _, Json, Response};
use serde::Deserialize;
use store::{Store, StoreError};

use super::Web;
use super::login::Who;

#[derive(Deserialize)]
pub(super) struct Named {
    name: String,
}

/// Reads the store in a thread that may wait. A missing store is an empty one.
async fn read<T: serde::Serialize + Default + Send + 'static>(
    web: Web,
    read: impl FnOnce(&Store) -> Result<T, StoreError> + Send + 'static,
) -> Response {
    let path = web.hall.store.clone();
    let reading = tokio::task::spawn_blocking(move || match Store::read(&path) {
        Err(StoreError::Missing { .. }) => Ok(T::default()),
        other => read(&other?),
    });
    match reading.await {
        Ok(Ok(found)) => Json(found).into_response(),
        Ok(Err(StoreError::NoTrainee(_))) => StatusCode::NOT_FOUND.into_response(),
        Ok(Err(error)) => (StatusCode::SERVICE_UNAVAILABLE, error.to_string()).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// True if this person may see everybody's results. A person who may see only some stations may
/// not.
async fn may_see_all(web: &Web, who: &str) -> bool {
    let roster = web.hall.roster.read().await;
    let person = roster.instructors.get(who);
    person.is_some_and(|it| it.stations.is_none())
}

pub(super) async fn people(State(web): State<Web>, who: Who) -> Response {
    if !may_see_all(&web, &who.name).await {
        return StatusCode::FORBIDDEN.into_response();
    }
    read(web, Store::trainees).await
}

pub(super) async fn sessions(
    State(web): State<Web>,
    who: Who,
    Query(named): Query<Named>,
) -> Response {
    if !may_see_all(&web, &who.name).await {
        return StatusCode::FORBIDDEN.into_response();
    }
    read(web, move |store| store.sessions(&named.name, None)).await
}

pub(super) async fn alarms(
    State(web): State<Web>,
    who: Who,
    Query(named): Query<Named>,
) -> Response {
    let roster = web.hall.roster.read().await;
    let person = roster.instructors.get(&who.name);
    match person.is_some_and(|it| it.may_see(&named.name)) {
        true => Json(web.hall.board.alarms(&named.name)).into_response(),
        false => StatusCode::NOT_FOUND.into_response(),
    }
}
