//! Every stage of the chain equals the reference to the bit for settings that between them hold every pair of values
//! that may be combined; and, on demand, for the full product of costs, prefilters, paths and filters.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::support;
use gpu_stereo::{Image, Params, Pixels, reference};
use rand::seq::{IndexedRandom, SliceRandom};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An option or another circumstance of a case, and its values.
#[derive(Clone)]
pub(crate) struct Factor {
    name: &'static str,
    values: Vec<&'static str>,
}

/// The index of a value of each factor.
pub(crate) type Row = Vec<usize>;

/// A value of a factor: their indices.
pub(crate) type Choice = (usize, usize);

/// Values of options that take numbers, where they are not those of `numbers`. What an option takes in words is taken from the
/// table of options.
const NUMBERS: &[(&str, &[&str])] = &[
    ("disp", &["21", "7", "37"]),
    ("min-disp", &["0", "-4", "3"]),
    ("ad-weight", &["8", "40"]),
    ("census-weight", &["32", "5"]),
    ("learned-weight", &["40", "9"]),
    ("block", &["5", "1", "17"]),
    ("prefilter-cap", &["31", "7"]),
    ("prefilter-window", &["9", "5"]),
    ("p1", &["16", "3"]),
    ("p2", &["96", "40"]),
    ("passes", &["1", "2"]),
    ("smoothness-weight", &["8", "3"]),
    ("smoothness-truncation", &["40", "90"]),
    ("smoothness-edge", &["off", "15"]),
    ("bp-levels", &["3", "6"]),
    ("bp-iterations", &["5", "2"]),
    ("bp-reweighting", &["8", "16"]),
    ("p2-step", &["10", "1"]),
    ("texture", &["off", "150"]),
    ("uniqueness", &["10", "off"]),
    ("speckle-window", &["off", "12"]),
    ("speckle-range", &["1", "3"]),
    ("weighted-median", &["off", "3"]),
    ("weighted-median-sigma", &["20", "200"]),
    ("wls-lambda", &["8000", "50"]),
    ("wls-sigma", &["1.5", "30"]),
];

/// Words of options that no case takes: one that stands for another, and those of networks, whose stages are compared with
/// a tolerance by tests of their own.
const UNLISTED: &[(&str, &str)] = &[("schedule", "auto"), ("method", "psmnet"), ("align-corners", "off")];

/// What a case has besides its options.
const CIRCUMSTANCES: &[(&str, &[&str])] = &[
    ("confidence", &["off", "on"]),
    ("labels", &["off", "on"]),
    ("format", &["gray8", "gray16", "rgba8", "rgba16"]),
    ("device", &["full", "bare"]),
    ("images", &["made", "motorcycle"]),
    ("masks", &["off", "on"]),
];

/// What an option that takes numbers has by default, and off or the first of some numbers that is another and allowed.
fn numbers(name: &'static str, allowed: &str) -> Vec<&'static str> {
    let default: &str = Params::from_options(64, []).unwrap().get(name).unwrap().leak();
    let off = allowed.ends_with("|off").then_some("off");
    let other = off.into_iter().chain(["4", "3", "40", "1"]).find(|value| {
        *value != default
            && Params::from_options(64, [(name, *value)]).is_ok_and(|params| params.get(name).unwrap() == *value)
    });
    let other = other.unwrap_or_else(|| panic!("--{name} needs two values in NUMBERS"));
    vec![default, other]
}

pub(crate) fn factors() -> Vec<Factor> {
    let options = Params::OPTIONS.iter().map(|option| {
        let listed = NUMBERS.iter().find(|(name, _)| *name == option.name);
        let words = option.values.iter().map(|(word, _)| *word);
        let values: Vec<_> = match listed {
            Some((_, values)) => values.to_vec(),
            None if option.values.is_empty() => numbers(option.name, option.placeholder),
            None => words.filter(|word| !UNLISTED.contains(&(option.name, word))).collect(),
        };
        Factor { name: option.name, values }
    });
    let circumstances = CIRCUMSTANCES.iter().map(|(name, values)| Factor { name, values: values.to_vec() });
    options.chain(circumstances).collect()
}

pub(crate) fn value(factors: &[Factor], row: &[usize], name: &str) -> &'static str {
    let at = factors.iter().position(|factor| factor.name == name).unwrap();
    factors[at].values[row[at]]
}

/// The options of a row and their values.
pub(crate) fn options(factors: &[Factor], row: &[usize]) -> impl Iterator<Item = (&'static str, &'static str)> {
    let given = factors.iter().zip(row).map(|(factor, &i)| (factor.name, factor.values[i]));
    given.filter(|(name, _)| CIRCUMSTANCES.iter().all(|(other, _)| other != name))
}

pub(crate) fn params(factors: &[Factor], row: &[usize]) -> Result<Params, gpu_stereo::Error> {
    let disparities = value(factors, row, "disp").parse().unwrap();
    let mut params = Params::from_options(disparities, options(factors, row))?;
    params.confidence = value(factors, row, "confidence") == "on";
    params.labels = value(factors, row, "labels") == "on";
    Ok(params)
}

/// The pairs of values that no case may hold: with each method, cost, block and either choice of colours beside them
/// the settings are refused.
pub(crate) fn refused_pairs(factors: &[Factor]) -> BTreeSet<[Choice; 2]> {
    let completing: Vec<usize> =
        (0..factors.len()).filter(|&f| ["method", "cost", "block", "color-cost"].contains(&factors[f].name)).collect();
    let mut completions: Vec<Row> = vec![vec![0; factors.len()]];
    let color = factors.iter().position(|factor| factor.name == "color-cost").unwrap();
    let off = factors[color].values.iter().position(|value| *value == "off").unwrap();
    completions[0][color] = off;
    for &f in &completing {
        let all = completions.iter().flat_map(|row| {
            (0..factors[f].values.len()).map(move |v| {
                let mut row = row.clone();
                row[f] = v;
                row
            })
        });
        completions = all.collect();
    }
    let allowed = |pair: &[Choice; 2]| {
        completions.iter().any(|row| {
            let fits = pair.iter().all(|(f, v)| !completing.contains(f) || row[*f] == *v);
            let mut row = row.clone();
            pair.iter().for_each(|&(f, v)| row[f] = v);
            fits && params(factors, &row).is_ok()
        })
    };
    all_pairs(factors).into_iter().filter(|pair| !allowed(pair)).collect()
}

pub(crate) fn all_pairs(factors: &[Factor]) -> BTreeSet<[Choice; 2]> {
    let choices = |f: usize| (0..factors[f].values.len()).map(move |v| (f, v));
    let pairs_of = |f: usize| {
        (0..f).flat_map(move |e| choices(e).flat_map(move |first| choices(f).map(move |second| [first, second])))
    };
    (0..factors.len()).flat_map(pairs_of).collect()
}

fn pair(a: Choice, b: Choice) -> [Choice; 2] {
    if a.0 < b.0 { [a, b] } else { [b, a] }
}

/// Rows that hold every pair but the refused ones: each is the best of a few that begin with a pair that is still
/// missing and then take, factor by factor, the value that adds most missing pairs.
pub(crate) fn covering(factors: &[Factor], refused: &BTreeSet<[Choice; 2]>, random: &mut ChaCha8Rng) -> Vec<Row> {
    const TRIES: usize = 12;
    let mut missing: Vec<[Choice; 2]> = all_pairs(factors).difference(refused).copied().collect();
    let mut rows = Vec::new();
    while !missing.is_empty() {
        let known: BTreeSet<_> = missing.iter().copied().collect();
        let mut best: Option<(usize, Row)> = None;
        for _ in 0..TRIES {
            let mut chosen: Vec<Choice> = missing.choose(random).unwrap().to_vec();
            let mut others: Vec<usize> = (0..factors.len()).filter(|f| chosen.iter().all(|(g, _)| g != f)).collect();
            others.shuffle(random);
            for f in others {
                let may = |v: &usize| chosen.iter().all(|&other| !refused.contains(&pair((f, *v), other)));
                let gain = |v: usize| chosen.iter().filter(|&&other| known.contains(&pair((f, v), other))).count();
                let allowed = (0..factors[f].values.len()).filter(may);
                let found = allowed.max_by_key(|&v| (gain(v), random.random::<u32>()));
                chosen.extend(found.map(|v| (f, v)));
            }
            chosen.sort();
            let row: Row = chosen.iter().map(|(_, v)| *v).collect();
            if row.len() < factors.len() {
                continue; // what was chosen first leaves no value for a factor
            }
            let gain = missing.iter().filter(|pair| holds(&row, pair)).count();
            if best.as_ref().is_none_or(|(most, _)| gain > *most) {
                best = Some((gain, row));
            }
        }
        let (gain, row) = best.expect("a row can be completed");
        assert!(gain > 0);
        missing.retain(|pair| !holds(&row, pair));
        rows.push(row);
    }
    rows
}

pub(crate) fn holds(row: &[usize], pair: &[Choice; 2]) -> bool {
    pair.iter().all(|&(f, v)| row[f] == v)
}

/// As the command would be called.
fn command(factors: &[Factor], row: &[usize]) -> String {
    let words = factors.iter().zip(row).map(|(factor, &i)| format!("--{} {}", factor.name, factor.values[i]));
    words.collect::<Vec<_>>().join(" ")
}

/// Odd sizes, also smaller than a block and than the range.
const SIZES: [(u32, u32); 6] = [(61, 23), (37, 41), (83, 13), (19, 29), (45, 9), (7, 31)];

fn read(path: &Path) -> image::GrayImage {
    image::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display())).into_luma8()
}

/// Real pairs of images, of which cases take pieces.
pub(crate) struct RealPairs(Vec<[image::GrayImage; 2]>);

impl RealPairs {
    pub(crate) fn new() -> Self {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let beside = root.join("../shared/data");
        let folders =
            [root.join("data/motorcycle"), beside.join("middlebury2003/teddy"), beside.join("kitti2015/000001_10")];
        let there = folders.iter().filter(|folder| folder.join("left.png").exists());
        Self(there.map(|folder| ["left.png", "right.png"].map(|name| read(&folder.join(name)))).collect())
    }

    /// A piece of pair `nth`, counted around.
    pub(crate) fn piece(&self, nth: usize, (width, height): (u32, u32), random: &mut ChaCha8Rng) -> (Image, Image) {
        let [left, right] = &self.0[nth % self.0.len()];
        let x = random.random_range(0..=left.width() - width);
        let y = random.random_range(0..=left.height() - height);
        let piece = |image: &image::GrayImage| {
            let samples = image::imageops::crop_imm(image, x, y, width, height).to_image().into_raw();
            Image::new(width, height, Pixels::Gray8(samples)).unwrap()
        };
        (piece(left), piece(right))
    }
}

/// The pair of a case, in its format.
pub(crate) fn images(factors: &[Factor], pairs: &RealPairs, nth: usize, row: &[usize]) -> (Image, Image) {
    let size = SIZES[nth % SIZES.len()];
    let mut random = ChaCha8Rng::seed_from_u64(nth as u64);
    let (left, right) = match value(factors, row, "images") {
        "made" => support::pair(size.0, size.1, nth as u64),
        _ => pairs.piece(nth, size, &mut random),
    };
    let format = ["gray8", "gray16", "rgba8", "rgba16"].iter().position(|name| *name == value(factors, row, "format"));
    let [left, right] = [left, right].map(|image| support::as_format(&image, format.unwrap() as u32));
    (left, right)
}

/// What a worker checks cases with.
struct Bench<'a> {
    factors: &'a [Factor],
    pairs: &'a RealPairs,
    devices: [(gpu_stereo::wgpu::Adapter, gpu_stereo::wgpu::Device, gpu_stereo::wgpu::Queue); 2],
}

impl Bench<'_> {
    /// Every stage, and the map of the whole chain.
    fn check(&self, nth: usize, row: &[usize], params: &Params) {
        let of = |name| value(self.factors, row, name);
        let (left, right) = images(self.factors, self.pairs, nth, row);
        let size = (left.width(), left.height());
        let params = &{
            let mut params = params.clone();
            params.masks = (of("masks") == "on").then(|| support::masks(size.0, size.1, nth as u64));
            params
        };
        let (adapter, device, queue) = &self.devices[usize::from(of("device") == "bare")];
        let case = format!("number {nth}, {}x{}, {}", size.0, size.1, command(self.factors, row));
        let matcher = support::matcher(device, queue, size, left.format(), params)
            .unwrap_or_else(|error| panic!("{error}, case {case}"));
        support::assert_equal(&matcher.check_blocking(&left, &right).unwrap(), adapter, &case);
        let matched = matcher.compute_blocking(&left, &right).unwrap();
        let expected = reference::compute_all(&left, &right, params).unwrap();
        assert!(matched == expected, "the whole chain differs from the reference, case {case}");
        support::assert_native(&left, &right, params, &expected, &case);
    }
}

/// Checks cases on all cores until `end`, if there is one. Returns how many were checked; `None` where there is no adapter.
pub(crate) fn check_all(
    factors: &[Factor],
    cases: &[(usize, Row, Params)],
    end: Option<Instant>,
    done: impl Fn(usize) + Sync,
) -> Option<usize> {
    let pairs = RealPairs::new();
    let (next, finished, absent) = (AtomicUsize::new(0), AtomicUsize::new(0), Mutex::new(false));
    let work = || {
        let (Some(full), Some(bare)) = (support::device(), support::bare_device()) else {
            *absent.lock().unwrap() = true;
            return;
        };
        let bench = Bench { factors, pairs: &pairs, devices: [full, bare] };
        while end.is_none_or(|end| Instant::now() < end) {
            let Some((nth, row, params)) = cases.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
            bench.check(*nth, row, params);
            done(finished.fetch_add(1, Ordering::Relaxed) + 1);
        }
    };
    // wgpu's OpenGL has one context, which serves one thread at a time.
    let one = gpu_stereo::wgpu::Backends::from_env() == Some(gpu_stereo::wgpu::Backends::GL);
    let workers = if one { 1 } else { std::thread::available_parallelism().map_or(1, |n| n.get()) };
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    let absent = absent.into_inner().unwrap();
    (!absent).then(|| finished.into_inner())
}

/// Two values of two options, by name.
type NamedPair = [(&'static str, &'static str); 2];

/// What [`Params::validate`] refuses of the values here.
fn refusals() -> BTreeSet<NamedPair> {
    let with_ncc =
        [[("block", "1"), ("cost", "ncc")], [("cost", "ncc"), ("method", "sgm")], [("cost", "ncc"), ("method", "bp")]];
    let costs = Params::OPTIONS.iter().find(|option| option.name == "cost").unwrap().values;
    let gray = costs.iter().map(|(name, _)| *name).filter(|name| !["sad", "bt"].contains(name));
    let gray = gray.filter(|name| !UNLISTED.contains(&("cost", name)));
    let colours = gray.map(|cost| [("color-cost", "on"), ("cost", cost)]);
    with_ncc.into_iter().chain(colours).collect()
}

#[test]
fn every_pair_of_values_is_exact() {
    let factors = factors();
    let refused = refused_pairs(&factors);
    let named = |&(f, v): &Choice| (factors[f].name, factors[f].values[v]);
    let by_name: BTreeSet<NamedPair> = refused
        .iter()
        .map(|[a, b]| {
            let mut pair = [named(a), named(b)];
            pair.sort();
            pair
        })
        .collect();
    assert_eq!(by_name, refusals(), "refused (left), and what is said to be (right)");

    let rows = covering(&factors, &refused, &mut ChaCha8Rng::seed_from_u64(1));
    let covered = |pair: &&[Choice; 2]| rows.iter().any(|row| holds(row, pair));
    let all = all_pairs(&factors);
    assert_eq!(all.iter().filter(covered).count(), all.len() - refused.len(), "every pair that is not refused");
    let case = |(nth, row): (usize, Row)| {
        let params = params(&factors, &row).unwrap_or_else(|error| panic!("{error}: {}", command(&factors, &row)));
        (nth, row, params)
    };
    let cases: Vec<_> = rows.into_iter().enumerate().map(case).collect();
    println!("{} cases hold {} pairs; {} are refused", cases.len(), all.len() - refused.len(), refused.len());
    let checked = check_all(&factors, &cases, None, |_| ());
    assert!(checked.is_none_or(|checked| checked == cases.len()), "only {checked:?} cases were checked");
}

/// Every cost (those with a census with every census) with every prefilter, all paths and block matching, and every
/// combination of filters; the other options at random. `GPU_STEREO_SHARE=I/N` takes share I of N of it, from 1 to N.
#[test]
#[ignore = "takes days: CONTRIBUTING.md"]
fn full_product() {
    let factors = factors();
    let share = std::env::var("GPU_STEREO_SHARE").unwrap_or("1/1".into());
    let numbers = share.split_once('/').map(|(i, n)| (i.parse(), n.parse()));
    let Some((Ok(share), Ok(shares @ 1..))) = numbers else { panic!("GPU_STEREO_SHARE is {share}, but must be I/N") };
    assert!((1..=shares).contains(&share), "GPU_STEREO_SHARE: {share} is not one of {shares}");

    let of = |name: &str| -> (&'static str, Vec<&'static str>) {
        let factor = factors.iter().find(|factor| factor.name == name).unwrap();
        (factor.name, factor.values.clone())
    };
    let names =
        ["cost", "census", "prefilter", "method", "paths", "lr-check", "right-view", "speckle-window", "median"];
    let product = names.into_iter().chain(["fill", "weighted-median", "wls"]).map(of);
    let mut all: Vec<BTreeMap<&str, &str>> = vec![BTreeMap::new()];
    for (name, values) in product {
        let extended = all.iter().flat_map(|case| {
            // What has no effect takes its first value.
            let counts = match name {
                "census" => case["cost"].contains("census"),
                "method" => case["cost"] != "ncc",
                "paths" => case["method"] == "sgm",
                "right-view" => case["lr-check"] != "off",
                _ => true,
            };
            let only = if name == "method" && !counts { vec!["bm"] } else { values[..1].to_vec() };
            let values = if counts { values.clone() } else { only };
            values.into_iter().map(|value| {
                let mut case = case.clone();
                case.insert(name, value);
                case
            })
        });
        all = extended.collect();
    }
    let mut random = ChaCha8Rng::seed_from_u64(2);
    all.shuffle(&mut random);
    let (total, mut refused) = (all.len(), 0);
    let mut cases = Vec::new();
    for (nth, case) in all.into_iter().enumerate().filter(|(nth, _)| nth % shares == share - 1) {
        let mut random = ChaCha8Rng::seed_from_u64(nth as u64);
        let mut drawn = || -> Row {
            let index = |factor: &Factor, random: &mut ChaCha8Rng| match case.get(factor.name) {
                Some(value) => factor.values.iter().position(|other| other == value).unwrap(),
                None => random.random_range(0..factor.values.len()),
            };
            factors.iter().map(|factor| index(factor, &mut random)).collect()
        };
        // What is drawn may not go with the cost: then it is drawn again.
        let good = (0..100).map(|_| drawn()).find_map(|row| params(&factors, &row).ok().map(|params| (row, params)));
        match good {
            Some((row, params)) => cases.push((nth, row, params)),
            None => refused += 1,
        }
    }
    let say = |text: String| writeln!(std::io::stderr(), "{text}").unwrap();
    say(format!("share {share} of {shares}: {} of {total} cases, and {refused} that are refused", cases.len()));
    let (start, last) = (Instant::now(), Mutex::new(Instant::now()));
    let checked = check_all(&factors, &cases, None, |done| {
        let mut last = last.lock().unwrap();
        if last.elapsed() > Duration::from_secs(10) || done == cases.len() {
            *last = Instant::now();
            let left = start.elapsed().as_secs_f64() / done as f64 * (cases.len() - done) as f64;
            say(format!("{done} of {} are exact, about {:.0} minutes to go", cases.len(), left / 60.0));
        }
    });
    assert!(checked != Some(0), "no case was checked");
}
