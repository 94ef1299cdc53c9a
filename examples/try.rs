use midsurf::field::{Field, walls::*};
use midsurf::lattice::Lattice;
use midsurf::mesh::*;
use std::io::Write;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let loaded = midsurf::io::read_mesh(&a[1]).unwrap();
    let coping = midsurf::tags::read_tags(std::path::Path::new(&a[2]), &loaded, std::path::Path::new(&a[1])).unwrap();
    let cell: f64 = a[3].parse().unwrap();
    let (part, w) = Part::new(loaded.mesh.clone(), coping.flags, PartOptions::default()).unwrap();
    for w in w { eprintln!("{w}"); }
    let t0 = std::time::Instant::now();
    let field = Field::new(&part);
    let walls = Walls::new(&part, &field, Separation { min_angle: 15.0, keep_fins_from: None });
    let (lo, hi) = field.bounds();
    let lattice = Lattice::covering(lo, hi, cell).unwrap();
    let mut tr = midsurf::trace::Tracer::new(&walls, lattice);
    let t1 = std::time::Instant::now();
    tr.run(&|_, _, _| ());
    let t2 = std::time::Instant::now();
    let mesh = tr.assemble();
    let et = mesh.edge_triangles();
    let mut cracks = 0; let mut bad = 0; let mut at = vec![];
    for (e, t) in &et {
        let line = mesh.lines.get(e);
        if t.len() == 1 && line.is_none() { cracks += 1; if cracks < 4 { println!("  CRACK {:.6} {:.6} tri {:?}", mesh.vertices[e.0 as usize].at, mesh.vertices[e.1 as usize].at, mesh.triangles[t[0] as usize].map(|v| mesh.vertices[v as usize].at)); for (k, v) in mesh.lines.iter() { if k.0==e.0||k.1==e.0||k.0==e.1||k.1==e.1 { println!("     line {:.6} {:.6} {v:?} count {}", mesh.vertices[k.0 as usize].at, mesh.vertices[k.1 as usize].at, et.iter().find(|x| x.0==*k).map_or(0,|x|x.1.len())); } } } at.push(mesh.vertices[e.0 as usize].at); }
        if t.len() > 2 && line.is_none() { bad += 1; if bad < 6 { println!("  BAD {:.5} {:.5} tris {:?}", mesh.vertices[e.0 as usize].at, mesh.vertices[e.1 as usize].at, t.iter().map(|&t| mesh.triangles[t as usize].map(|v| mesh.vertices[v as usize].at)).collect::<Vec<_>>()); } }
    }
    let (fl, to) = tr.failures();
    println!("verts {} tris {} cracks {cracks} bad {bad} face-lost {} tet-open {} queries {} edgeq {:.2} prep {:?} run {:?}", mesh.vertices.len(), mesh.triangles.len(), fl.len(), to.len(), tr.found().queries, tr.found().edge_queries as f64 / tr.found().edges_solved as f64, t1-t0, t2 - t1);
    for p in at.iter().take(4) { println!("  crack {p:.4}"); }
    for p in fl.iter().take(4) { println!("  face lost {p:.4}"); }
    for p in to.iter().take(4) { println!("  tet open {p:.4}"); }
    if a.len() > 4 {
        let mut f = std::io::BufWriter::new(std::fs::File::create(&a[4]).unwrap());
        for v in &mesh.vertices { writeln!(f, "v {} {} {}", v.at.x, v.at.y, v.at.z).unwrap(); }
        for t in &mesh.triangles { writeln!(f, "f {} {} {}", t[0]+1, t[1]+1, t[2]+1).unwrap(); }
    }
}
