//! Files as torch.save writes them, byte by byte.

/// What tensors lie in.
pub struct Storage {
    pub kind: &'static str,
    pub key: &'static str,
    pub bytes: Vec<u8>,
}

impl Storage {
    fn size(&self) -> usize {
        match self.kind {
            "LongStorage" => 8,
            "HalfStorage" => 2,
            _ => 4,
        }
    }
}

fn text(text: &str) -> Vec<u8> {
    [b"X", &(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn whole(number: u32) -> Vec<u8> {
    [b"J", &number.to_le_bytes()[..]].concat()
}

/// A whole pickle of an object.
pub fn pickled(object: &[u8]) -> Vec<u8> {
    [b"\x80\x02", object, b"."].concat()
}

/// An OrderedDict with an attribute, as state_dict() has it.
pub fn dict(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let entries: Vec<u8> = entries.iter().flat_map(|(name, value)| [text(name), value.clone()].concat()).collect();
    [&b"ccollections\nOrderedDict\nq\x01)Rq\x02("[..], &entries, b"u}X\x09\0\0\0_metadata}sb"].concat()
}

/// A view of a storage.
pub fn tensor(storage: &Storage, offset: u32, shape: &[u32], strides: &[u32]) -> Vec<u8> {
    let tuple =
        |numbers: &[u32]| [b"(", &numbers.iter().flat_map(|&n| whole(n)).collect::<Vec<_>>()[..], b"t"].concat();
    let count = (storage.bytes.len() / storage.size()) as u32;
    [
        &b"ctorch._utils\n_rebuild_tensor_v2\n(("[..],
        &text("storage"),
        format!("ctorch\n{}\n", storage.kind).as_bytes(),
        &text(storage.key),
        &text("cpu"),
        &whole(count),
        b"tQ",
        &whole(offset),
        &tuple(shape),
        &tuple(strides),
        b"\x89ccollections\nOrderedDict\n)RtR",
    ]
    .concat()
}

/// The archive of PyTorch since 1.6.
pub fn archive(pickle: &[u8], storages: &[Storage], wide: bool) -> Vec<u8> {
    let names: Vec<String> = storages.iter().map(|storage| format!("it/data/{}", storage.key)).collect();
    let mut files = vec![("it/data.pkl", pickle), ("it/byteorder", b"little"), ("it/version", b"3\n")];
    files.extend(names.iter().zip(storages).map(|(name, storage)| (name.as_str(), &storage.bytes[..])));
    zip(&files, wide, 0)
}

/// An archive. `wide`: with fields of 64 bits; `method`: how files are said to be compressed.
pub fn zip(files: &[(&str, &[u8])], wide: bool, method: u16) -> Vec<u8> {
    let (mut bytes, mut list) = (Vec::new(), Vec::new());
    for (name, contents) in files {
        let at = bytes.len() as u64;
        let padding = vec![0; 5]; // PyTorch aligns contents by an extra field
        let extra = [&b"FB\x05\0"[..], &padding].concat();
        let lengths = [(contents.len() as u32).to_le_bytes(); 2].concat();
        let name_length = (name.len() as u16).to_le_bytes();
        bytes.extend([&b"PK\x03\x04\0\0\0\0"[..], &method.to_le_bytes(), &[0; 8], &lengths].concat());
        bytes.extend(
            [&name_length[..], &(extra.len() as u16).to_le_bytes(), name.as_bytes(), &extra, contents].concat(),
        );
        let (lengths, place, extra) = if wide {
            let length = (contents.len() as u64).to_le_bytes();
            let extra = [&b"\x09\0\x01\0?\x01\0\x18\0"[..], &length, &length, &at.to_le_bytes()].concat();
            (vec![255; 8], vec![255; 4], extra)
        } else {
            (lengths, (at as u32).to_le_bytes().to_vec(), Vec::new())
        };
        list.extend([&b"PK\x01\x02\0\0\0\0\0\0"[..], &method.to_le_bytes(), &[0; 8], &lengths, &name_length].concat());
        list.extend([&(extra.len() as u16).to_le_bytes()[..], &[0; 10], &place, name.as_bytes(), &extra].concat());
    }
    let (start, count) = (bytes.len() as u64, files.len() as u64);
    let end = start + list.len() as u64;
    bytes.extend(&list);
    let mut place = (start as u32).to_le_bytes();
    if wide {
        let numbers = [count, count, list.len() as u64, start].map(u64::to_le_bytes).concat();
        bytes.extend([&b"PK\x06\x06"[..], &44_u64.to_le_bytes(), &[0; 12], &numbers].concat());
        bytes.extend([&b"PK\x06\x07\0\0\0\0"[..], &end.to_le_bytes(), &1_u32.to_le_bytes()].concat());
        place = [255; 4];
    }
    let count = [(count as u16).to_le_bytes(); 2].concat();
    bytes.extend(
        [&b"PK\x05\x06\0\0\0\0"[..], &count, &(list.len() as u32).to_le_bytes(), &place, b"\x03\0end"].concat(),
    );
    bytes
}

/// The format before.
pub fn legacy(pickle: &[u8], storages: &[Storage]) -> Vec<u8> {
    let magic = b"\x80\x02\x8a\x0a\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19.";
    let system = pickled(b"}q\0(X\x0d\0\0\0little_endian\x88X\x10\0\0\0protocol_versionM\xe9\x03u");
    let keys: Vec<u8> = storages.iter().flat_map(|storage| text(storage.key)).collect();
    let keys = pickled(&[&b"]("[..], &keys, b"e"].concat());
    let mut bytes = [&magic[..], &pickled(b"M\xe9\x03"), &system, pickle, &keys].concat();
    for storage in storages {
        let count = (storage.bytes.len() / storage.size()) as u64;
        bytes.extend([&count.to_le_bytes()[..], &storage.bytes].concat());
    }
    bytes
}
