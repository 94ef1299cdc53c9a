use super::*;
use crate::extract::extract;
use crate::surface::shapes;

const COUNT: u32 = 5;

fn settings() -> Settings {
    Settings {
        cell: CellSize::Thicknesses(0.8),
        ..Settings::default()
    }
}

fn made(part: &Part, settings: &Settings, index: u32, count: u32) -> Shard {
    let which = ShardOf::new(index, count).unwrap();
    shard(part, settings, which, &|_, _, _| (), &Stop::default()).unwrap()
}

fn all(part: &Part, count: u32) -> Vec<Shard> {
    let shards = (1..=count).map(|index| made(part, &settings(), index, count));
    // As files, in any order.
    let mut files: Vec<Vec<u8>> = shards.map(|s| bytes(&s)).collect();
    files.rotate_left(1);
    files.iter().map(|f| Shard::read(f).unwrap()).collect()
}

fn bytes(shard: &Shard) -> Vec<u8> {
    let mut bytes = Vec::new();
    shard.write(&mut bytes).unwrap();
    bytes
}

fn merged(shards: Vec<Shard>) -> Result<Extraction, MergeError> {
    merge(shards, None, &|_, _, _| (), &Stop::default())
}

#[test]
fn shards_join_to_the_whole_bit_for_bit() {
    for name in ["tee", "rib_grid", "plate_round_edge"] {
        let part = shapes::part(name);
        let whole = extract(&part, &settings(), &|_, _, _| ()).unwrap();
        for count in [1, 2, COUNT] {
            let joined = merged(all(&part, count)).unwrap();
            assert_eq!(joined.surface, whole.surface, "{name} of {count}");
            assert_eq!(joined.work.counts.cells, whole.work.counts.cells);
        }
    }
}

#[test]
fn a_shard_without_a_seed_enters_at_its_rim() {
    // Two large triangles a side point to few places; so do shards between.
    let part = shapes::part("plate");
    let fine = Settings {
        cell: CellSize::Thicknesses(0.25),
        ..Settings::default()
    };
    let whole = extract(&part, &fine, &|_, _, _| ()).unwrap();
    let shards = (1..=16)
        .map(|index| made(&part, &fine, index, 16))
        .collect();
    assert_eq!(merged(shards).unwrap().surface, whole.surface);
}

#[test]
fn incomplete_and_foreign_shards_are_refused_by_name() {
    let part = shapes::part("tee");
    let shards = all(&part, 3);
    let words = |shards: Vec<Shard>| merged(shards).unwrap_err().to_string();
    let by_index = |index: u32| {
        let mut of = shards.iter().filter(|s| s.which.index == index);
        of.next().unwrap().clone()
    };
    let [one, two, three] = [1, 2, 3].map(by_index);
    assert_eq!(words(Vec::new()), "no shard was given");
    assert_eq!(
        words(vec![one.clone(), three.clone()]),
        "shard 2/3 is missing"
    );
    assert_eq!(words(vec![two.clone()]), "shard 1/3 is missing, and 1 more");
    let doubled = vec![one.clone(), two.clone(), two.clone(), three.clone()];
    assert_eq!(words(doubled), "shard 2/3 was given twice");
    let other = made(&shapes::part("cross"), &settings(), 2, 3);
    let told = words(vec![one.clone(), other, three.clone()]);
    assert!(told.starts_with("shard 2/3 is of another part"), "{told}");
    let coarse = Settings {
        cell: CellSize::Thicknesses(1.0),
        ..Settings::default()
    };
    let told = words(vec![one.clone(), two.clone(), made(&part, &coarse, 3, 3)]);
    assert!(
        told.starts_with("shard 3/3 was made with other settings"),
        "{told}"
    );
    let mut old = two.clone();
    old.task.version = "0.0.9".to_owned();
    let told = words(vec![one.clone(), old, three.clone()]);
    assert!(
        told.starts_with("shard 2/3 was made by version 0.0.9"),
        "{told}"
    );
}

#[test]
fn a_damaged_file_is_refused() {
    let whole = bytes(&made(&shapes::part("tee"), &settings(), 1, 2));
    assert!(Shard::read(&whole).is_ok());
    for end in (0..whole.len()).step_by(whole.len() / 50) {
        assert!(Shard::read(&whole[..end]).is_err(), "cut at {end}");
    }
    for at in (0..whole.len()).step_by(whole.len() / 50) {
        let mut bent = whole.clone();
        bent[at] ^= 0x10;
        assert!(Shard::read(&bent).is_err(), "bent at {at}");
    }
    let mut newer = whole.clone();
    newer[14] = 9;
    let error = Shard::read(&newer).unwrap_err();
    assert!(
        matches!(error, ShardFileError::OtherFormat { found: 9, .. }),
        "{error}"
    );
    assert!(matches!(
        Shard::read(b"solid part"),
        Err(ShardFileError::NoShard)
    ));
}

#[test]
fn a_forged_file_is_refused_without_harm() {
    let whole = bytes(&made(&shapes::part("tee"), &settings(), 2, 2));
    let packed = &whole[18..whole.len() - 32];
    let mut content = Vec::new();
    let mut unpack = flate2::read::ZlibDecoder::new(packed);
    std::io::Read::read_to_end(&mut unpack, &mut content).unwrap();
    // With a checksum that fits, every number in turn is a lie.
    let first = made(&shapes::part("tee"), &settings(), 1, 2);
    let mut refused = 0;
    for at in (0..content.len() - 4).step_by(content.len() / 60) {
        let mut lie = content.clone();
        lie[at..at + 4].fill(0xff);
        let mut file = whole[..18].to_vec();
        let mut pack = flate2::write::ZlibEncoder::new(&mut file, flate2::Compression::fast());
        std::io::Write::write_all(&mut pack, &lie).unwrap();
        pack.finish().unwrap();
        let sum = Sha256::digest(&file);
        file.extend(sum);
        match Shard::read(&file) {
            Ok(shard) => {
                let _ = merged(vec![first.clone(), shard]);
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 0);
}

#[test]
fn which_of_how_many_is_read_and_shown() {
    let three: ShardOf = "3/16".parse().unwrap();
    assert_eq!((three.index(), three.count()), (3, 16));
    assert_eq!(three.to_string(), "3/16");
    for text in ["", "3", "0/4", "5/4", "a/b", "1/0", "-1/4", "1/4294967295"] {
        assert!(text.parse::<ShardOf>().is_err(), "{text}");
    }
}
