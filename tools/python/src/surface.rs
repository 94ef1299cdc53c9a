//! Mid-surfaces: looked at, saved, read back, taken apart and put together for
//! other processes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use midsurf::extract::Extraction;
use midsurf::intake::Input;
use midsurf::io::read_surface;
use midsurf::io::write::{
    Dialect, ShellFormat, ShellOptions, Staged, SurfaceOptions, Template, WriteError, stage_shell,
    stage_surface, vertex_code,
};
use midsurf::report::extraction::{account, warnings};
use midsurf::settings::warning::Warning;
use midsurf::shell::{Faces, Order, ShellModel, ShellSettings, ThicknessFrom};
use midsurf::surface::graph::SheetGraph;
use midsurf::surface::listing::listing;
use midsurf::surface::{
    Ball, Border, BorderKind, Crease, MidSurface, MidTriangle, MidVertex, Seam, SurfaceParts,
    VertexKind,
};
use numpy::{PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use serde_json::json;

use crate::arrays::{self, Field, Rows, flat};
use crate::fault::{Fault, pairs};

/// A mid-surface, and what is known of where it came from.
#[pyclass(frozen, module = "midsurf._midsurf")]
pub(crate) struct Surface {
    result: Extraction,
    /// The part; none of a surface that was read or sent.
    input: Option<Arc<Input>>,
    warnings: Vec<Warning>,
}

impl Surface {
    /// The mesh.
    pub(crate) fn surface(&self) -> &MidSurface {
        &self.result.surface
    }

    /// The result of an extraction from an input.
    pub(crate) fn of(result: Extraction, input: Input) -> Surface {
        let mut all = input.warnings.clone();
        all.extend(warnings(&input, &result));
        Surface {
            result,
            input: Some(Arc::new(input)),
            warnings: all,
        }
    }

    /// The result of joining shards, which do not bring the part.
    pub(crate) fn merged(result: Extraction) -> Surface {
        Surface {
            result,
            input: None,
            warnings: Vec::new(),
        }
    }

    /// A mesh of which nothing else is known.
    fn alone(surface: MidSurface, warnings: Vec<Warning>) -> Surface {
        let graph = SheetGraph::of(&surface);
        Surface {
            result: Extraction {
                surface,
                graph,
                quads: Vec::new(),
                middles: Vec::new(),
                solid: None,
                closed_over: Vec::new(),
                work: Default::default(),
            },
            input: None,
            warnings,
        }
    }
}

/// Reads a mid-surface that was saved as `.ply`, or as `.obj` with its table.
#[pyfunction]
pub(crate) fn read(py: Python<'_>, file: PathBuf) -> PyResult<Surface> {
    let loaded = py.detach(|| read_surface(&file, None));
    let loaded = loaded.map_err(|error| Fault::input(&error).raise(&[]))?;
    let told = loaded.warnings.iter();
    let told = told.map(|w| midsurf::intake::read_warning(&file, w));
    Ok(Surface::alone(loaded.surface, told.collect()))
}

/// A line: its vertices, its sheets, whether it is closed; of a border its kind.
type Told<'py> = (
    Bound<'py, PyArray1<u32>>,
    Vec<u32>,
    bool,
    Option<&'static str>,
);

/// The pieces of a surface, for another process.
type Pieces<'py> = (
    Rows<'py, f64>,
    Bound<'py, PyArray1<u8>>,
    [Bound<'py, PyArray1<f64>>; 2],
    (Rows<'py, f64>, Bound<'py, PyArray1<u64>>),
    Rows<'py, u32>,
    Bound<'py, PyArray1<u32>>,
    [Vec<Told<'py>>; 3],
    (Vec<u32>, Vec<[u32; 2]>),
);

#[pymethods]
impl Surface {
    #[getter]
    fn vertices(of: Bound<'_, Surface>) -> Rows<'_, f64> {
        arrays::vertex_rows(of, Field::Position)
    }

    #[getter]
    fn thickness(of: Bound<'_, Surface>) -> Bound<'_, PyArray1<f64>> {
        arrays::vertex_numbers(of, Field::Thickness)
    }

    #[getter]
    fn radius(of: Bound<'_, Surface>) -> Bound<'_, PyArray1<f64>> {
        arrays::vertex_numbers(of, Field::Radius)
    }

    #[getter]
    fn triangles(of: Bound<'_, Surface>) -> Rows<'_, u32> {
        arrays::triangle_rows(of, Field::Corners)
    }

    #[getter]
    fn sheet(of: Bound<'_, Surface>) -> Bound<'_, PyArray1<u32>> {
        arrays::triangle_numbers(of, Field::Sheet)
    }

    #[getter]
    fn kind<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        let kinds = self.surface().vertices().iter();
        PyArray1::from_iter(py, kinds.map(|v| vertex_code(v.kind)))
    }

    /// The two footpoints of every vertex that are farthest apart.
    #[getter]
    fn footpoints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let vertices = self.surface().vertices();
        let none = [DVec3::NAN; 2];
        let widest = vertices.iter().map(|v| v.ball.widest().unwrap_or(none));
        let feet: Vec<DVec3> = widest.flatten().collect();
        PyArray1::from_vec(py, flat(feet)).reshape([vertices.len(), 2, 3])
    }

    /// All footpoints, one after the other, and where those of a vertex begin.
    #[getter]
    fn all_footpoints<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Rows<'py, f64>, Bound<'py, PyArray1<u64>>)> {
        let vertices = self.surface().vertices();
        let mut starts = vec![0];
        let mut feet: Vec<DVec3> = Vec::new();
        for vertex in vertices {
            feet.extend(&vertex.ball.footpoints);
            starts.push(feet.len() as u64);
        }
        let rows = feet.len();
        Ok((
            PyArray1::from_vec(py, flat(feet)).reshape([rows, 3])?,
            PyArray1::from_vec(py, starts),
        ))
    }

    #[getter]
    fn seams<'py>(&self, py: Python<'py>) -> Vec<Told<'py>> {
        let line = |l: &Seam| (path(py, &l.path), l.sheets.clone(), l.closed, None);
        self.surface().seams().iter().map(line).collect()
    }

    #[getter]
    fn borders<'py>(&self, py: Python<'py>) -> Vec<Told<'py>> {
        let kind = |kind| match kind {
            BorderKind::Coping => "coping",
            BorderKind::Fading => "fading",
        };
        let line = |l: &Border| {
            (
                path(py, &l.path),
                vec![l.sheet],
                l.closed,
                Some(kind(l.kind)),
            )
        };
        self.surface().borders().iter().map(line).collect()
    }

    #[getter]
    fn creases<'py>(&self, py: Python<'py>) -> Vec<Told<'py>> {
        let line = |l: &Crease| (path(py, &l.path), vec![l.sheet], l.closed, None);
        self.surface().creases().iter().map(line).collect()
    }

    #[getter]
    fn junctions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, self.surface().junctions())
    }

    #[getter]
    fn quads<'py>(&self, py: Python<'py>) -> PyResult<Rows<'py, u32>> {
        let pairs = self.result.quads.clone();
        let rows = pairs.len();
        PyArray1::from_vec(py, pairs.into_flattened()).reshape([rows, 2])
    }

    #[getter]
    fn cracks<'py>(&self, py: Python<'py>) -> PyResult<Rows<'py, f64>> {
        let places: Vec<DVec3> = self.result.graph.cracks().iter().map(|c| c.at).collect();
        let rows = places.len();
        PyArray1::from_vec(py, flat(places)).reshape([rows, 3])
    }

    #[getter]
    fn cell(&self) -> Option<f64> {
        let cell = self.result.work.cell;
        // None of a surface that was read.
        (cell > 0.0).then_some(cell)
    }

    #[getter]
    fn sheet_count(&self) -> u32 {
        self.surface().sheet_count()
    }

    #[getter]
    fn warnings(&self) -> Vec<(&'static str, String)> {
        pairs(&self.warnings)
    }

    /// Figures, as the command's report has them, in JSON.
    fn report(&self) -> String {
        let mut report = account(&self.result.surface, &self.result.graph);
        report["closed_over"] = json!(self.result.closed_over);
        if self.result.work.cell > 0.0 {
            report["work"] = json!(self.result.work);
        }
        report.to_string()
    }

    fn listing(&self) -> String {
        listing(&self.result.surface, &self.result.graph)
    }

    /// Writes the surface in the format of the file's suffix.
    #[pyo3(signature = (file, obj_lines, order, abaqus, template, placement))]
    #[allow(clippy::too_many_arguments)]
    fn save(
        &self,
        py: Python<'_>,
        file: PathBuf,
        obj_lines: bool,
        order: Option<u8>,
        abaqus: bool,
        template: Option<&str>,
        placement: f64,
    ) -> PyResult<()> {
        let model = Model {
            order,
            abaqus,
            template: match template {
                None => None,
                Some("cantilever") => Some(Template::Cantilever),
                Some("modal") => Some(Template::Modal),
                Some(_) => {
                    let words = "expected \"cantilever\" or \"modal\"";
                    return Err(Fault::argument("template", words).raise(&[]));
                }
            },
            placement,
        };
        let write = || -> Result<(), Fault> {
            let staged = if ShellFormat::of(&file).is_some() {
                vec![self.stage_model(&file, &model)?]
            } else {
                let options = SurfaceOptions { obj_lines };
                stage_surface(self.surface(), &file, options).map_err(unwritten)?
            };
            staged.into_iter().try_for_each(commit)
        };
        py.detach(write)
            .map_err(|fault| fault.raise(&["placement"]))
    }

    /// What it takes to build the surface again elsewhere.
    fn pieces<'py>(of: Bound<'py, Surface>, py: Python<'py>) -> PyResult<Pieces<'py>> {
        let this = of.get();
        Ok((
            Surface::vertices(of.clone()),
            this.kind(py),
            [Surface::radius(of.clone()), Surface::thickness(of.clone())],
            this.all_footpoints(py)?,
            Surface::triangles(of.clone()),
            Surface::sheet(of.clone()),
            [this.seams(py), this.borders(py), this.creases(py)],
            (
                this.surface().junctions().to_vec(),
                this.result.quads.clone(),
            ),
        ))
    }

    /// The surface of such pieces.
    #[staticmethod]
    #[allow(clippy::type_complexity, clippy::too_many_arguments)]
    fn of_pieces(
        vertices: PyReadonlyArray2<'_, f64>,
        kind: PyReadonlyArray1<'_, u8>,
        lengths: [PyReadonlyArray1<'_, f64>; 2],
        feet: (PyReadonlyArray2<'_, f64>, PyReadonlyArray1<'_, u64>),
        triangles: PyReadonlyArray2<'_, u32>,
        sheet: PyReadonlyArray1<'_, u32>,
        lines: [Vec<(PyReadonlyArray1<'_, u32>, Vec<u32>, bool, Option<String>)>; 3],
        rest: (Vec<u32>, Vec<[u32; 2]>),
    ) -> PyResult<Surface> {
        let refuse = |words: &str| Fault::argument("pieces", words).raise(&[]);
        if !arrays::are_triples(&vertices, &triangles) {
            return Err(refuse("vertices and triangles need three columns each"));
        }
        let mesh = arrays::mesh_in(&vertices, &triangles);
        let (kind, sheet) = (kind.as_array(), sheet.as_array());
        let [radius, thickness] = [lengths[0].as_array(), lengths[1].as_array()];
        let (points, starts) = (feet.0.as_array(), feet.1.as_array());
        let ascend = starts
            .iter()
            .zip(starts.iter().skip(1))
            .all(|(a, b)| a <= b);
        let fits = points.ncols() == 3
            && [kind.len(), radius.len(), thickness.len()] == [mesh.positions.len(); 3]
            && sheet.len() == mesh.triangles.len()
            && starts.len() == mesh.positions.len() + 1
            && ascend
            && starts.iter().last() == Some(&(points.nrows() as u64));
        if !fits {
            return Err(refuse("the arrays do not fit each other"));
        }
        let foot = |n: usize| DVec3::new(points[[n, 0]], points[[n, 1]], points[[n, 2]]);
        let ball = |v: usize| Ball {
            radius: radius[v],
            thickness: thickness[v],
            footpoints: (starts[v] as usize..starts[v + 1] as usize)
                .map(foot)
                .collect(),
        };
        let vertices = mesh.positions.iter().enumerate().map(|(v, &position)| {
            Some(MidVertex {
                position,
                kind: kind_of(kind[v])?,
                ball: ball(v),
            })
        });
        let vertices: Option<Vec<MidVertex>> = vertices.collect();
        let corners = mesh.triangles.iter().zip(&sheet);
        let [seams, borders, creases] = lines;
        let (junctions, quads) = rest;
        let parts = SurfaceParts {
            vertices: vertices.ok_or_else(|| refuse("a kind of vertex that is none"))?,
            triangles: corners
                .map(|(&corners, &sheet)| MidTriangle { corners, sheet })
                .collect(),
            seams: (seams.into_iter())
                .map(|(path, sheets, closed, _)| Seam {
                    path: path.as_array().to_vec(),
                    sheets,
                    closed,
                    unmarked: 0,
                })
                .collect(),
            borders: (borders.into_iter())
                .map(|(path, sheets, closed, kind)| Border {
                    path: path.as_array().to_vec(),
                    sheet: sheets.first().copied().unwrap_or_default(),
                    kind: match kind.as_deref() {
                        Some("fading") => BorderKind::Fading,
                        _ => BorderKind::Coping,
                    },
                    closed,
                })
                .collect(),
            creases: (creases.into_iter())
                .map(|(path, sheets, closed, _)| Crease {
                    path: path.as_array().to_vec(),
                    sheet: sheets.first().copied().unwrap_or_default(),
                    closed,
                })
                .collect(),
            junctions,
        };
        let surface = MidSurface::new(parts).map_err(|error| refuse(&error.to_string()))?;
        let pairs = quads.as_flattened().iter();
        if pairs
            .into_iter()
            .any(|&t| t as usize >= surface.triangles().len())
        {
            return Err(refuse("a pair of triangles that do not exist"));
        }
        let mut made = Surface::alone(surface, Vec::new());
        made.result.quads = quads;
        Ok(made)
    }
}

/// How a shell model is written.
struct Model {
    order: Option<u8>,
    abaqus: bool,
    template: Option<Template>,
    placement: f64,
}

/// A model names faces of the part, and there is none.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("a shell model names the faces of its part, and this surface came without one")]
#[diagnostic(help("save it where it was extracted, or save .ply, .vtu or .obj"))]
struct NoPart;

impl Surface {
    fn stage_model(&self, file: &Path, model: &Model) -> Result<Staged, Fault> {
        let Some(input) = &self.input else {
            return Err(Fault::refused(file, &NoPart));
        };
        if !(0.0..=1.0).contains(&model.placement) {
            return Err(Fault::argument(
                "placement",
                "expected a number from 0 to 1",
            ));
        }
        let dialect = if model.abaqus {
            Dialect::Abaqus
        } else {
            Dialect::Calculix
        };
        let format = ShellFormat::of(file);
        let settings = ShellSettings {
            order: match (model.order, format) {
                (None, Some(format)) => format.order(dialect),
                (Some(2), _) => Order::Quadratic,
                (None | Some(1), _) => Order::Linear,
                (Some(_), _) => return Err(Fault::argument("order", "expected 1 or 2")),
            },
            thickness: ThicknessFrom::Ball,
            ..ShellSettings::default()
        };
        let faces = Faces {
            quads: self.result.quads.clone(),
            middles: self.result.middles.iter().copied().collect(),
        };
        let mut shell = ShellModel::of(self.surface(), &faces, &settings);
        shell.name_after(input);
        if model.placement != shell.placement {
            shell.place(model.placement);
        }
        let options = ShellOptions {
            dialect,
            template: model.template,
        };
        stage_shell(&shell, file, options).map_err(unwritten)
    }
}

/// A file that cannot be written.
pub(crate) fn unwritten(error: WriteError) -> Fault {
    Fault::input(&error)
}

/// Gives a written file its name.
pub(crate) fn commit(staged: Staged) -> Result<(), Fault> {
    staged.commit().map_err(unwritten)
}

fn path<'py>(py: Python<'py>, path: &[u32]) -> Bound<'py, PyArray1<u32>> {
    PyArray1::from_slice(py, path)
}

/// The kind of a code, as [`vertex_code`] gives it.
fn kind_of(code: u8) -> Option<VertexKind> {
    use VertexKind::*;
    let all = [Sheet, Seam, Junction, CopingBorder, FadingBorder];
    all.into_iter().find(|&kind| vertex_code(kind) == code)
}
