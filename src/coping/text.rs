//! The text form: indices, ranges and name patterns, line by line.

use super::error::Located;
use super::error::TagProblem;
use super::rule::{Condition, NameKind, Rule, TagFile, facet_range};

/// Reads the text form. Neighbouring lines of indices are one rule.
pub(super) fn parse(text: &str) -> Result<TagFile, Located> {
    let mut file = TagFile::default();
    // Lines of indices that go on from the line before.
    let mut open_list = false;
    let mut start = 0;
    for (number, whole) in text.split_inclusive('\n').enumerate() {
        let line_start = start;
        start += whole.len();
        let line = whole.split('#').next().unwrap_or("");
        let offset = line_start + (line.len() - line.trim_start().len());
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        let span = offset..offset + line.len();
        if let Some((keyword, pattern)) = line.split_once(':')
            && let Some(kind) = name_kind(keyword.trim())
        {
            let pattern = pattern.trim();
            if pattern.is_empty() {
                let message = format!("{:?} needs a name", keyword.trim());
                return Err((span, TagProblem::Syntax(message)));
            }
            open_list = false;
            file.rules.push(Rule {
                name: format!("{}: {pattern}", keyword.trim()),
                coping: true,
                conditions: vec![Condition::Names {
                    kind,
                    patterns: vec![(pattern.to_owned(), span.clone())],
                }],
                span,
            });
            continue;
        }
        if line.starts_with('[') || line.contains('=') {
            return Err((span, TagProblem::TomlInText));
        }
        let mut ranges = Vec::new();
        for word in line.split([' ', '\t', ',']).filter(|word| !word.is_empty()) {
            if !word.starts_with(|c: char| c.is_ascii_digit()) {
                let word = word.to_owned();
                return Err((span, TagProblem::NotATag { word }));
            }
            ranges.push(facet_range(word, 0, span.clone())?);
        }
        match file.rules.last_mut() {
            Some(Rule { conditions, .. }) if open_list => {
                if let Some(Condition::Facets(list)) = conditions.first_mut() {
                    list.append(&mut ranges);
                }
            }
            _ => file.rules.push(Rule {
                name: format!("triangles from line {}", number + 1),
                coping: true,
                conditions: vec![Condition::Facets(ranges)],
                span,
            }),
        }
        open_list = true;
    }
    Ok(file)
}

/// `group` stands for a name of any kind, as programs disagree on which one
/// they write.
fn name_kind(keyword: &str) -> Option<NameKind> {
    match keyword.to_ascii_lowercase().as_str() {
        "group" => Some(NameKind::Any),
        "object" => Some(NameKind::Object),
        "material" => Some(NameKind::Material),
        _ => None,
    }
}
