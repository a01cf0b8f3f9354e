//! Python's pickles: the objects that one describes, of the few kinds that a checkpoint consists of.
//!
//! A pickle is a program for a stack machine, and Python's can call any function. This one calls none: it knows what its
//! [`Global`]s make and refuses all others by name. Objects are kept in a list and name each other by their places, so that
//! a pickle that nests them deeply or repeats them takes no more memory than steps.

use super::values::{Element, shown};
use crate::files::error::{Context as _, Error, Result, bail, ensure, error};
use std::collections::HashMap;

/// The most steps of a pickle: a published checkpoint has about 20 thousand.
const MAX_STEPS: usize = 1 << 22;

/// The place of an object in [`Objects`].
pub(super) type Id = usize;

/// What a pickle describes.
#[derive(Debug)]
pub(super) enum Object<'a> {
    /// A whole number of at most 64 bits.
    Whole(i64),
    /// One of more, little endian.
    Long(&'a [u8]),
    Text(&'a str),
    Tuple(Vec<Id>),
    List(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    Global(Global),
    Storage(Storage<'a>),
    Tensor(Tensor),
    /// What no tensor is made of: floats, truth values, None, bytes.
    Other,
}

/// What a pickle may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Global {
    OrderedDict,
    /// `_rebuild_tensor_v2`, and `_rebuild_tensor` before PyTorch 0.4.
    Tensor,
    /// `_rebuild_parameter`.
    Parameter,
    Storage(Element),
}

/// Numbers of one type that lie elsewhere in the file.
#[derive(Clone, Debug)]
pub(super) struct Storage<'a> {
    pub element: Element,
    pub key: &'a str,
    /// The first number of it, and how many there are, if it is a part of what is stored.
    pub part: Option<(usize, usize)>,
}

/// A view of a storage.
#[derive(Clone, Debug)]
pub(super) struct Tensor {
    pub storage: Id,
    pub offset: Id,
    pub shape: Id,
    pub strides: Id,
}

/// What is known of a global; all others are refused.
fn global(module: &str, name: &str) -> Option<Global> {
    let element = match (module, name) {
        ("collections", "OrderedDict") => return Some(Global::OrderedDict),
        ("torch._utils", "_rebuild_tensor" | "_rebuild_tensor_v2") => return Some(Global::Tensor),
        ("torch._utils", "_rebuild_parameter") => return Some(Global::Parameter),
        ("torch", "DoubleStorage") => Element::F64,
        ("torch", "FloatStorage") => Element::F32,
        ("torch", "HalfStorage") => Element::F16,
        ("torch", "BFloat16Storage") => Element::Bf16,
        ("torch", "LongStorage") => Element::I64,
        ("torch", "IntStorage") => Element::I32,
        ("torch", "ShortStorage") => Element::I16,
        ("torch", "CharStorage") => Element::I8,
        ("torch", "ByteStorage") => Element::U8,
        ("torch", "BoolStorage") => Element::Bool,
        _ => return None,
    };
    Some(Global::Storage(element))
}

/// All objects of a pickle.
pub(super) struct Objects<'a>(Vec<Object<'a>>);

impl<'a> Objects<'a> {
    pub fn get(&self, id: Id) -> &Object<'a> {
        &self.0[id] // only the machine makes ids
    }

    pub fn all(&self) -> impl Iterator<Item = &Object<'a>> {
        self.0.iter()
    }

    /// A whole number from 0 on.
    pub fn size(&self, id: Id) -> Option<usize> {
        if let Object::Whole(number) = self.get(id) { usize::try_from(*number).ok() } else { None }
    }

    /// A tuple or list of such numbers.
    pub fn sizes(&self, id: Id) -> Option<Vec<usize>> {
        self.items(id)?.iter().map(|&item| self.size(item)).collect()
    }

    pub fn text(&self, id: Id) -> Option<&'a str> {
        if let Object::Text(text) = self.get(id) { Some(text) } else { None }
    }

    pub fn items(&self, id: Id) -> Option<&[Id]> {
        if let Object::Tuple(items) | Object::List(items) = self.get(id) { Some(items) } else { None }
    }

    pub fn dict(&self, id: Id) -> Option<&[(Id, Id)]> {
        if let Object::Dict(entries) = self.get(id) { Some(entries) } else { None }
    }
}

/// Reads the pickle that begins at `*at`, which is then the place behind it.
pub(super) fn read<'a>(bytes: &'a [u8], at: &mut usize) -> Result<(Objects<'a>, Id)> {
    let rest = bytes.get(*at..).unwrap_or_default();
    let mut machine = Machine { rest, objects: Vec::new(), stack: Vec::new(), marks: Vec::new(), memo: HashMap::new() };
    for _ in 0..MAX_STEPS {
        if machine.step()? {
            let result = machine.pop()?;
            *at = bytes.len() - machine.rest.len();
            return Ok((Objects(machine.objects), result));
        }
    }
    bail!("its pickle has more than {MAX_STEPS} steps; save {{'state_dict': model.state_dict()}} alone")
}

struct Machine<'a> {
    rest: &'a [u8],
    objects: Vec<Object<'a>>,
    stack: Vec<Id>,
    /// The heights of the stack at the marks.
    marks: Vec<usize>,
    memo: HashMap<u64, Id>,
}

fn damaged() -> Error {
    error!("its pickle is damaged or cut short; save or download it again")
}

impl<'a> Machine<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or_else(damaged)?;
        self.rest = rest;
        Ok(taken)
    }

    /// A number of `bytes` bytes, little endian.
    fn number(&mut self, bytes: usize) -> Result<u64> {
        Ok(self.take(bytes)?.iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte)))
    }

    /// Bytes after their number, which has `bytes` bytes.
    fn counted(&mut self, bytes: usize) -> Result<&'a [u8]> {
        let count = self.number(bytes)?;
        self.take(usize::try_from(count).map_err(|_| damaged())?)
    }

    /// The text up to the end of the line.
    fn line(&mut self) -> Result<&'a str> {
        let end = self.rest.iter().position(|&byte| byte == b'\n').ok_or_else(damaged)?;
        let line = self.take(end + 1)?;
        std::str::from_utf8(&line[..end]).map_err(|_| damaged())
    }

    fn push(&mut self, object: Object<'a>) {
        self.stack.push(self.objects.len());
        self.objects.push(object);
    }

    fn push_text(&mut self, bytes: &'a [u8]) {
        self.push(std::str::from_utf8(bytes).map_or(Object::Other, Object::Text)); // Python 2 has texts of any bytes
    }

    fn pop(&mut self) -> Result<Id> {
        let floor = self.marks.last().copied().unwrap_or(0);
        if self.stack.len() <= floor {
            return Err(damaged());
        }
        self.stack.pop().ok_or_else(damaged)
    }

    fn top(&self) -> Result<Id> {
        self.stack.last().copied().ok_or_else(damaged)
    }

    /// All that was pushed since the last mark.
    fn marked(&mut self) -> Result<Vec<Id>> {
        let mark = self.marks.pop().ok_or_else(damaged)?;
        Ok(self.stack.split_off(mark))
    }

    /// The last `count` objects.
    fn last(&mut self, count: usize) -> Result<Vec<Id>> {
        let mut items = (0..count).map(|_| self.pop()).collect::<Result<Vec<_>>>()?;
        items.reverse();
        Ok(items)
    }

    /// One instruction; true at the end of the pickle.
    fn step(&mut self) -> Result<bool> {
        let code = self.take(1)?[0];
        match code {
            b'.' => return Ok(true),
            0x80 => drop(self.take(1)?), // the protocol
            0x95 => drop(self.take(8)?), // a frame: what follows is read in order anyway
            b'(' => self.marks.push(self.stack.len()),
            b'0' => drop(self.pop()?),
            b'1' => drop(self.marked()?),
            b'2' => self.stack.push(self.top()?),
            b'J' => {
                let number = self.number(4)? as u32 as i32;
                self.push(Object::Whole(number.into()));
            }
            b'K' | b'M' => {
                let number = self.number(if code == b'K' { 1 } else { 2 })?;
                self.push(Object::Whole(number as i64));
            }
            0x8a | 0x8b => self.long(if code == 0x8a { 1 } else { 4 })?,
            b'G' => drop((self.take(8)?, self.push(Object::Other))),
            b'N' | 0x88 | 0x89 => self.push(Object::Other),
            b'X' | 0x8c | 0x8d | b'U' | b'T' => {
                let bytes = self.counted(match code {
                    0x8c | b'U' => 1,
                    0x8d => 8,
                    _ => 4,
                })?;
                self.push_text(bytes);
            }
            b'B' | b'C' | 0x8e => {
                self.counted(match code {
                    b'C' => 1,
                    0x8e => 8,
                    _ => 4,
                })?;
                self.push(Object::Other);
            }
            b'q' | b'r' | 0x94 | b'h' | b'j' => self.memoise(code)?,
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                self.named(module, name)?;
            }
            0x93 => {
                let names = self.last(2)?;
                let [module, name] =
                    [0, 1].map(|i| if let Object::Text(text) = self.objects[names[i]] { text } else { "" });
                self.named(module, name)?;
            }
            _ => self.compose(code)?,
        }
        Ok(false)
    }

    fn long(&mut self, bytes: usize) -> Result<()> {
        let digits = self.counted(bytes)?;
        let negative = digits.last().is_some_and(|byte| byte >> 7 == 1);
        let start = if negative { -1 } else { 0 };
        self.push(match digits.len() {
            0..=8 => Object::Whole(digits.iter().rev().fold(start, |number, &byte| number << 8 | i64::from(byte))),
            _ => Object::Long(digits),
        });
        Ok(())
    }

    /// Keeps the top of the stack under a number, or pushes what was kept.
    fn memoise(&mut self, code: u8) -> Result<()> {
        let key = match code {
            b'q' | b'h' => self.number(1)?,
            b'r' | b'j' => self.number(4)?,
            _ => self.memo.len() as u64,
        };
        if matches!(code, b'h' | b'j') {
            let id = *self.memo.get(&key).ok_or_else(damaged)?;
            self.stack.push(id);
        } else {
            self.memo.insert(key, self.top()?);
        }
        Ok(())
    }

    fn named(&mut self, module: &str, name: &str) -> Result<()> {
        let found = global(module, name).with_context(|| {
            format!(
                "its pickle asks for {}, which is refused, since only tensors are read; save {{'state_dict': \
                 model.state_dict()}} alone, or convert it to .safetensors",
                shown(&format!("{module}.{name}"))
            )
        })?;
        self.push(Object::Global(found));
        Ok(())
    }

    /// Instructions that make an object of others.
    fn compose(&mut self, code: u8) -> Result<()> {
        match code {
            b'}' => self.push(Object::Dict(Vec::new())),
            b']' | 0x8f => self.push(Object::List(Vec::new())),
            b')' => self.push(Object::Tuple(Vec::new())),
            b't' => {
                let items = self.marked()?;
                self.push(Object::Tuple(items));
            }
            0x85..=0x87 => {
                let items = self.last(usize::from(code - 0x84))?;
                self.push(Object::Tuple(items));
            }
            b'a' | b'e' | 0x90 => {
                let items = if code == b'a' { self.last(1)? } else { self.marked()? };
                let Object::List(list) = &mut self.objects[*self.stack.last().ok_or_else(damaged)?] else {
                    return Err(damaged());
                };
                list.extend(items);
            }
            b's' | b'u' => {
                let items = if code == b's' { self.last(2)? } else { self.marked()? };
                let Object::Dict(entries) = &mut self.objects[*self.stack.last().ok_or_else(damaged)?] else {
                    return Err(damaged());
                };
                entries.extend(items.as_chunks::<2>().0.iter().map(|&[key, value]| (key, value)));
            }
            b'b' => {
                self.pop()?; // attributes of an object: of an OrderedDict the versions of modules
                let is_plain = matches!(self.objects[self.top()?], Object::Dict(_) | Object::Tensor(_));
                ensure!(
                    is_plain,
                    "its pickle sets attributes of an object; save {{'state_dict': model.state_dict()}} alone"
                );
            }
            b'Q' => {
                let id = self.pop()?;
                let storage = self.storage(id)?;
                self.push(Object::Storage(storage));
            }
            b'R' | 0x81 => {
                let called = self.last(2)?;
                self.call(called[0], called[1])?;
            }
            _ => bail!("its pickle has the instruction {code:#04x}, which torch.save does not write; save it again"),
        }
        Ok(())
    }

    fn fields(&self, id: Id) -> &[Id] {
        if let Object::Tuple(items) | Object::List(items) = &self.objects[id] { items } else { &[] }
    }

    /// What `('storage', type, key, device, count)` names, in older files with `(key, first, count)` of a part or None.
    fn storage(&self, id: Id) -> Result<Storage<'a>> {
        let fields = self.fields(id);
        let object = |at: usize| fields.get(at).map(|&id| &self.objects[id]);
        match (object(0), object(1), object(2)) {
            (
                Some(Object::Text("storage")),
                Some(Object::Global(Global::Storage(element))),
                Some(Object::Text(key)),
            ) => {
                let part = fields.get(5).and_then(|&part| {
                    let whole = |at: usize| match self.objects[*self.fields(part).get(at)?] {
                        Object::Whole(number) => usize::try_from(number).ok(),
                        _ => None,
                    };
                    Some((whole(1)?, whole(2)?))
                });
                Ok(Storage { element: *element, key, part })
            }
            (Some(Object::Text("module")), ..) => {
                bail!("it holds a whole module with its code; save {{'state_dict': model.state_dict()}}")
            }
            _ => Err(damaged()),
        }
    }

    /// What a call of a global makes.
    fn call(&mut self, function: Id, arguments: Id) -> Result<()> {
        let fields = self.fields(arguments);
        let made = match (&self.objects[function], fields) {
            (Object::Global(Global::OrderedDict), []) => Object::Dict(Vec::new()),
            (Object::Global(Global::OrderedDict), &[list]) => {
                let entry = |&item: &Id| if let &[key, value] = self.fields(item) { Some((key, value)) } else { None };
                let entries = self.fields(list).iter().map(entry).collect::<Option<_>>();
                Object::Dict(entries.ok_or_else(damaged)?)
            }
            (Object::Global(Global::Tensor), &[storage, offset, shape, strides, ..]) => {
                Object::Tensor(Tensor { storage, offset, shape, strides })
            }
            (Object::Global(Global::Parameter), &[data, ..]) => {
                self.stack.push(data);
                return Ok(());
            }
            _ => return Err(damaged()),
        };
        self.push(made);
        Ok(())
    }
}
