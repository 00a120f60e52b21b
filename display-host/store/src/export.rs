//! Export of one trainee's data, or of everybody's, as JSON.

use serde_json::{Value, json};

use crate::error::StoreError;
use crate::open::Store;

impl Store {
    /// Everything the store holds about one trainee, or about everybody: names, sessions with their
    /// sheets, answers. `sheet` has the points of the last sheet of GOALS by their full names,
    /// `sheets` all sheets with their raters.
    ///
    /// # Errors
    /// When no trainee has this name, or the file cannot be read.
    pub fn export_json(&self, name: Option<&str>) -> Result<Value, StoreError> {
        let mut people = Vec::new();
        for person in self.people(name)? {
            let ratings = self.ratings_of(&person.name)?;
            let mut sessions = Vec::new();
            for session in self.sessions(&person.name, None)? {
                let sheet = self.sheet(&session.id)?;
                let mut value = serde_json::to_value(&session).unwrap_or_default();
                if let Some(object) = value.as_object_mut() {
                    let sheet = sheet.into_iter().map(|(item, value)| (item, value.into()));
                    object.insert("sheet".to_owned(), Value::Object(sheet.collect()));
                    let all = ratings.iter().filter(|it| it.session == session.id);
                    object.insert("sheets".to_owned(), json!(all.collect::<Vec<_>>()));
                }
                sessions.push(value);
            }
            people.push(json!({
                "name": person.name,
                "cohort": person.cohort,
                "consent": person.consent,
                "sessions": sessions,
                "answers": self.answers_of(&person.name)?,
            }));
        }
        Ok(json!({ "trainees": people }))
    }
}
