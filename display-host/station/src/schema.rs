//! `calot schema`: the schemas of the JSON that the other commands write.

use std::process::ExitCode;

use clap::Args;
use serde_json::Value;

use crate::document::{ALL, Document};
use crate::problem::Problem;
use crate::say;

/// Options of `calot schema`.
#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Every result in JSON has a key `schema`, such as \"urn:calot:summary:1\". The number is
the version. New keys may come within a version; a key that a version has keeps its name and meaning.

Examples:
  calot schema                              every schema in one line
  calot schema summary > summary.json       the keys of summary.json, with units
  calot run --headless --seconds 5 --json | check-jsonschema --schemafile <(calot schema summary) -")]
pub(crate) struct SchemaArgs {
    /// Schema to print, by its name or by the content of the key `schema`
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Prints one schema, or the list of all.
pub(crate) fn run(args: &SchemaArgs) -> Result<ExitCode, Problem> {
    let Some(wanted) = &args.name else {
        for document in ALL {
            say::answer(format_args!("{:<16} {}", document.name, title(document)?));
        }
        return Ok(ExitCode::SUCCESS);
    };
    let is_wanted = |it: &&Document| it.name == wanted || it.id == wanted;
    let Some(found) = ALL.iter().find(is_wanted) else {
        return Err(format!(
            "no schema is called '{wanted}'; `calot schema` lists the names of all {}",
            ALL.len()
        )
        .into());
    };
    say::answer(found.schema.trim_end());
    Ok(ExitCode::SUCCESS)
}

fn title(document: &Document) -> Result<String, Problem> {
    let schema: Value = serde_json::from_str(document.schema)?;
    Ok(schema["title"].as_str().unwrap_or_default().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_schema_has_the_id_that_its_documents_name() {
        for document in ALL {
            let schema: Value = serde_json::from_str(document.schema).unwrap();
            assert_eq!(schema["$id"], document.id);
            assert!(!title(document).unwrap().is_empty(), "{}", document.id);
            let required = schema["required"].as_array().unwrap();
            assert!(required.contains(&"schema".into()), "{}", document.id);
        }
    }

    #[test]
    fn a_schema_is_found_by_name_and_by_id() {
        for name in ["summary", "urn:calot:summary:1"] {
            let name = Some(name.to_owned());
            assert!(run(&SchemaArgs { name }).is_ok());
        }
        let name = Some("sumary".to_owned());
        let said = run(&SchemaArgs { name }).unwrap_err().to_string();
        assert!(
            said.contains("'sumary'") && said.contains("calot schema"),
            "{said}"
        );
    }
}
