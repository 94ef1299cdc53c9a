//! Detected tags as an ordinary tag file, to read and to edit.

use std::fmt::Write;

use super::detect::{DetectedFace, Detection, Question};
use crate::io::LoadedMesh;

/// The TOML form: one rule a coping face, with what speaks for it as a
/// comment; faces in doubt come first.
pub fn detected_toml(detection: &Detection, loaded: &LoadedMesh) -> String {
    let facets = FacetTags::of(detection, loaded);
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = detected_toml_into(&mut text, detection, loaded, &facets);
    text
}

/// The text form: ranges, face by face.
pub fn detected_text(detection: &Detection, loaded: &LoadedMesh) -> String {
    let facets = FacetTags::of(detection, loaded);
    let mut text = String::new();
    let _ = detected_text_into(&mut text, detection, &facets);
    text
}

/// Facets of the file that are coping: a polygon is if more than half of it is.
struct FacetTags {
    coping: Vec<bool>,
    source: Vec<u32>,
}

impl FacetTags {
    fn of(detection: &Detection, loaded: &LoadedMesh) -> FacetTags {
        let mut balance = vec![(0.0, 0usize); loaded.facet_count()];
        for face in loaded.mesh.faces() {
            let flag = detection.flags[face.index()];
            let (area, votes) = &mut balance[loaded.source[face.index()] as usize];
            let own = loaded.mesh.triangle_area(face);
            *area += if flag { own } else { -own };
            *votes += usize::from(flag);
        }
        FacetTags {
            coping: balance
                .iter()
                .map(|&(area, votes)| area > 0.0 || (area == 0.0 && votes > 0))
                .collect(),
            source: loaded.source.clone(),
        }
    }

    /// Facets of a face that are tagged as the face is, ascending.
    fn facets(&self, face: &DetectedFace) -> Vec<u32> {
        let mut facets: Vec<u32> = face
            .triangles
            .iter()
            .map(|&triangle| self.source[triangle as usize])
            .filter(|&facet| self.coping[facet as usize] == face.coping)
            .collect();
        facets.dedup();
        facets
    }
}

/// Ascending numbers as ranges, `3` or `5-9`.
pub fn ranges(numbers: &[u32]) -> Vec<String> {
    numbers
        .chunk_by(|a, b| a + 1 == *b)
        .map(|run| match run {
            [only] => only.to_string(),
            [first, .., last] => format!("{first}-{last}"),
            [] => String::new(),
        })
        .collect()
}

fn detected_toml_into(
    text: &mut String,
    detection: &Detection,
    loaded: &LoadedMesh,
    facets: &FacetTags,
) -> std::fmt::Result {
    writeln!(text, "# Coping faces found by midsurf.")?;
    writeln!(
        text,
        "# Edit: drop a rule to make its face wall; rules under [[wall]] take back."
    )?;
    if let Some(words) = detection.verdict().text() {
        writeln!(text, "# {words}.")?;
    }
    writeln!(text, "format = \"coping-tags\"\nversion = 1\n")?;
    writeln!(text, "[mesh]")?;
    writeln!(text, "triangles = {}", loaded.facet_count())?;
    writeln!(text, "geometry = \"{}\"", loaded.geometry())?;
    let questions = detection.questions();
    if !questions.is_empty() {
        writeln!(text)?;
    }
    for (number, question) in questions.iter().enumerate() {
        writeln!(
            text,
            "# Question {}: {}",
            number + 1,
            question.text(detection)
        )?;
    }
    let mut order: Vec<&DetectedFace> = detection.faces.iter().filter(|f| f.coping).collect();
    order.sort_by(|a, b| b.doubt.total_cmp(&a.doubt).then(a.number.cmp(&b.number)));
    for face in order {
        let list = facets.facets(face);
        if list.is_empty() {
            continue;
        }
        writeln!(text, "\n[[coping]]")?;
        writeln!(text, "name = \"face {}\"", face.number)?;
        writeln!(text, "# {}", face.summary())?;
        let quoted: Vec<String> = ranges(&list).iter().map(|r| format!("\"{r}\"")).collect();
        writeln!(text, "triangles = [{}]", quoted.join(", "))?;
    }
    Ok(())
}

fn detected_text_into(
    text: &mut String,
    detection: &Detection,
    facets: &FacetTags,
) -> std::fmt::Result {
    writeln!(text, "# Coping faces found by midsurf.")?;
    if let Some(words) = detection.verdict().text() {
        writeln!(text, "# {words}.")?;
    }
    for (number, question) in detection.questions().iter().enumerate() {
        writeln!(
            text,
            "# Question {}: {}",
            number + 1,
            question.text(detection)
        )?;
    }
    for face in detection.faces.iter().filter(|face| face.coping) {
        let list = facets.facets(face);
        if !list.is_empty() {
            writeln!(text, "# face {}: {}", face.number, face.summary())?;
            writeln!(text, "{}", ranges(&list).join("\n"))?;
        }
    }
    Ok(())
}

impl DetectedFace {
    /// Size, place, score, doubt and reasons on one line.
    pub fn summary(&self) -> String {
        let [x, y, z] = self.middle.to_array().map(short);
        let mut line = format!(
            "area {} at ({x}, {y}, {z}), wall {} thick, score {:.2}, by neighbours {:.2}, doubt {:.2}",
            short(self.area),
            short(self.thickness),
            self.score,
            self.by_neighbours,
            self.doubt
        );
        for reason in &self.reasons {
            let _ = write!(line, "; {}", reason.text());
        }
        line
    }
}

impl Question {
    /// The question in words: which face, what it is taken for, why that is not
    /// sure.
    pub fn text(&self, detection: &Detection) -> String {
        let first = &detection.faces[self.faces[0]];
        let [x, y, z] = first.middle.to_array().map(short);
        let who = match self.faces.len() {
            1 => format!("face {}", first.number),
            n => format!("face {} and {} more like it", first.number, n - 1),
        };
        let (taken, or) = if self.coping {
            ("the end of a wall", "or a wall's side?")
        } else {
            ("a wall's side", "or the end of a wall?")
        };
        let why: Vec<&str> = self.reasons.iter().map(|reason| reason.text()).collect();
        format!(
            "{who}, area {} at ({x}, {y}, {z}), beside a wall {} thick: {taken} as now, {or} ({})",
            short(first.area),
            short(first.thickness),
            why.join("; ")
        )
    }
}

/// A number to four digits, for reading.
fn short(value: f64) -> String {
    match format!("{value:.3e}").parse::<f64>() {
        Ok(0.0) => "0".to_owned(),
        Ok(rounded) if (1e-3..1e9).contains(&rounded.abs()) => format!("{rounded}"),
        _ => format!("{value:.3e}"),
    }
}
