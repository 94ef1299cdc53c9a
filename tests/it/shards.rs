//! Extraction in shards, through the command line.

use crate::common::{Desk, fixture};

#[test]
fn merged_shards_are_the_whole_extraction() {
    let desk = Desk::new();
    let part = fixture("bracket.obj");
    let tags = fixture("bracket.coping.txt");
    let [part, tags] = [&part, &tags].map(|file| file.to_str().unwrap());
    let extract = ["extract", part, "--coping", tags, "--cell", "1t", "-q"];
    let name = |file: &str| desk.path(file).to_str().unwrap().to_owned();
    let run = |args: &[&str]| {
        let output = desk.run(args);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), told)
    };
    let whole = ["whole.ply", "whole.vtu", "whole.obj"].map(name);
    let outputs = ["-o", &whole[0], "-o", &whole[1], "-o", &whole[2]];
    assert_eq!(run(&[&extract[..], &outputs].concat()).0, Some(0));
    let shards = ["a.shard", "b.shard", "c.shard"].map(name);
    for (n, shard) in shards.iter().enumerate() {
        let which = format!("{}/3", n + 1);
        let threads = (n + 1).to_string();
        let args = ["--shard", &which, "-o", shard, "-j", &threads];
        assert_eq!(
            run(&[&extract[..], &args].concat()),
            (Some(0), String::new())
        );
    }
    let merged = ["merged.ply", "merged.vtu", "merged.obj"].map(name);
    let [c, a, b] = [&shards[2], &shards[0], &shards[1]];
    let outputs = ["-q", "-o", &merged[0], "-o", &merged[1], "-o", &merged[2]];
    let args = [&["merge", c, a, b][..], &outputs].concat();
    assert_eq!(run(&args), (Some(0), String::new()));
    for (whole, merged) in whole.iter().zip(&merged) {
        let bytes = |file| std::fs::read(file).unwrap();
        assert!(bytes(whole) == bytes(merged), "{merged}");
    }

    let refused = |args: &[&str], words: &[&str]| {
        let (code, told) = run(args);
        assert_eq!(code, Some(2), "{args:?}: {told}");
        for word in words {
            assert!(told.contains(word), "{args:?}: no {word:?} in\n{told}");
        }
    };
    refused(&["merge", a, c], &["shard 2/3 is missing", "--shard 2/3"]);
    refused(&["merge", a, b, b, c], &["b.shard", "2/3 was given twice"]);
    refused(&["merge", a, b, part], &["bracket.obj", "not a shard"]);
    let two = ["--shard", "1/3", "-o", "x.shard", "-o", "y.shard"];
    refused(&[&extract[..], &two].concat(), &["one file"]);
    let foreign = ["--shard", "1/3", "-o", "x.ply"];
    refused(&[&extract[..], &foreign].concat(), &["x.ply", ".shard"]);
    refused(&["extract", part, "--shard", "4/3"], &["3/16"]);
}
