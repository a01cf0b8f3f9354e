//! What `torch.save` writes: an archive (from PyTorch 1.6 on), or pickles and storages one after the other.

use super::pickle::{self, Id, Object, Objects, Storage, Tensor};
use super::values::{Budget, Found, Given, View, shown};
use crate::files::error::{Context as _, Result, bail, ensure, error};
use crate::files::zip;
use std::collections::BTreeMap;

/// The number with which the older format begins, 0x1950a86a20f9469cfc6c, little endian.
const MAGIC: [u8; 10] = [0x6c, 0xfc, 0x9c, 0x46, 0xf9, 0x20, 0x6a, 0xa8, 0x50, 0x19];

/// The storages of a file by their keys.
type Storages<'a> = BTreeMap<&'a str, &'a [u8]>;

/// The tensors of an archive: `data.pkl`, and a file for each storage in `data` beside it.
pub(super) fn archive(bytes: &[u8]) -> Result<Vec<Given>> {
    let files = zip::files(bytes)?;
    // What is stored as it is need not be decompressed.
    ensure!(
        files.iter().all(|file| file.method == 0),
        "it has compressed files, but torch.save stores them as they are; unzip it and zip it with -0, or save it again"
    );
    let (base, pickled) = files
        .iter()
        .find_map(|file| {
            let base = file.name.strip_suffix(b"data.pkl").filter(|base| base.is_empty() || base.ends_with(b"/"))?;
            Some((base, file.stored))
        })
        .context("it is an archive without data.pkl; give what torch.save wrote")?;
    let mut storages = Storages::new();
    for zip::Packed { name, stored: contents, .. } in &files {
        let Some(name) = name.strip_prefix(base) else { continue };
        ensure!(
            name != b"byteorder" || contents.starts_with(b"little"),
            "it is big endian; save it on another machine"
        );
        let key = name.strip_prefix(b"data/").and_then(|key| std::str::from_utf8(key).ok());
        if let Some(key) = key {
            ensure!(storages.insert(key, contents).is_none(), "it has the storage {} twice; save it again", shown(key));
        }
    }
    let (objects, root) = pickle::read(pickled, &mut 0)?;
    tensors(bytes, &objects, root, &storages)
}

/// The tensors of the older format: pickles of a magic number, a version, the system, the object and the keys of its
/// storages, then the storages, each after its length.
pub(super) fn legacy(bytes: &[u8]) -> Result<Vec<Given>> {
    let mut at = 0;
    let (objects, magic) = pickle::read(bytes, &mut at)?;
    let is_ours = matches!(objects.get(magic), Object::Long(digits) if **digits == MAGIC);
    ensure!(is_ours, "it is a pickle, but none that torch.save wrote; save the weights with torch.save");
    let (objects, version) = pickle::read(bytes, &mut at)?;
    let version = objects.size(version);
    ensure!(version == Some(1001), "its version is not 1001, the only one of this format; save it again");
    pickle::read(bytes, &mut at)?; // the machine that wrote it: little endian, as all that PyTorch runs on
    let (objects, root) = pickle::read(bytes, &mut at)?;
    let (listed, keys) = pickle::read(bytes, &mut at)?;
    let elements = elements(&objects);
    let mut storages = Storages::new();
    for &key in listed.items(keys).context("it has no list of storages; save it again")? {
        let key = listed.text(key).context("a storage has a key that is no text; save it again")?;
        let size =
            elements.get(key).with_context(|| format!("nothing uses its storage {}; save it again", shown(key)))?;
        let storage = storage(bytes, &mut at, *size)
            .with_context(|| format!("its storage {} is cut short; save or download it again", shown(key)))?;
        storages.insert(key, storage);
    }
    tensors(bytes, &objects, root, &storages)
}

/// The bytes of a number of each storage that is used.
fn elements<'a>(objects: &Objects<'a>) -> BTreeMap<&'a str, usize> {
    let of = |object: &Object<'a>| match object {
        Object::Storage(Storage { element, key, .. }) => Some((*key, element.size())),
        _ => None,
    };
    objects.all().filter_map(of).collect()
}

/// The numbers at `*at`, of `size` bytes each, after how many there are; `*at` is then the place behind them.
fn storage<'a>(bytes: &'a [u8], at: &mut usize, size: usize) -> Option<&'a [u8]> {
    let (count, rest) = bytes.get(*at..)?.split_first_chunk::<8>()?;
    let length = usize::try_from(u64::from_le_bytes(*count)).ok()?.checked_mul(size)?;
    let storage = rest.get(..length)?;
    *at += 8 + length;
    Some(storage)
}

/// The tensors of the dictionary `root`, or of its `state_dict`. What else it has is ignored.
fn tensors(file: &[u8], objects: &Objects<'_>, root: Id, storages: &Storages<'_>) -> Result<Vec<Given>> {
    const WANTED: &str = "save {'state_dict': model.state_dict()}, or model.state_dict() alone";
    let entries = |id: Id| objects.dict(id).ok_or_else(|| error!("it holds no dictionary of tensors; {WANTED}"));
    let all = entries(root)?;
    let inner = all.iter().find(|(key, _)| objects.text(*key) == Some("state_dict"));
    let all = inner.map_or(Ok(all), |(_, inner)| entries(*inner))?;
    let mut budget = Budget::of(file);
    let mut given = Vec::new();
    for &(key, value) in all {
        if let (Some(name), Object::Tensor(tensor)) = (objects.text(key), objects.get(value)) {
            given.push(Given::new(name, tensor_of(objects, tensor, storages, &mut budget))?);
        }
    }
    if given.is_empty() {
        bail!("its dictionary has no tensors; {WANTED}");
    }
    Ok(given)
}

fn tensor_of(objects: &Objects<'_>, tensor: &Tensor, storages: &Storages<'_>, budget: &mut Budget) -> Result<Found> {
    let Object::Storage(Storage { element, key, part }) = objects.get(tensor.storage) else {
        bail!("it has no storage; save it again");
    };
    let mut storage =
        *storages.get(key).with_context(|| format!("its storage {} is missing; save it again", shown(key)))?;
    if let Some((first, count)) = part {
        let bytes = |count: usize| count.checked_mul(element.size());
        let part = bytes(*first).zip(bytes(*count)).and_then(|(first, count)| storage.get(first..)?.get(..count));
        storage = part.context("it is a part of a storage that ends before it; save it again")?;
    }
    let numbers = objects.size(tensor.offset).zip(objects.sizes(tensor.shape)).zip(objects.sizes(tensor.strides));
    let ((offset, shape), strides) =
        numbers.context("its place, shape or strides are no whole numbers from 0 on; save it again")?;
    let view = View { element: *element, storage, offset, shape: &shape, strides: &strides };
    Ok(Found { element: *element, values: view.values(budget)?, shape })
}
