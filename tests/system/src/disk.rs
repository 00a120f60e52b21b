//! A disk that is slow or fails: a file system in memory over `/dev/fuse`, which holds one folder
//! of plain files. It speaks just enough of the kernel's protocol (linux/fuse.h, version 7) for a
//! recorder.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

/// Largest number of bytes of a write.
const WRITE_MAX: usize = 1 << 17;
/// Length of a request's head.
const HEAD: usize = 40;
/// Number of the root folder.
const ROOT: u64 = 1;
/// Kernel error: there is no such file.
const ENOENT: i32 = 2;
/// Kernel error: the request is not implemented.
const ENOSYS: i32 = 38;

/// Behaviour of the disk.
#[derive(Debug, Clone, Copy, Default)]
pub struct Manner {
    /// Delay of each write.
    pub delay: Duration,
    /// Size of a file beyond which writes fail, bytes, and the kernel's error number.
    pub error_after: Option<(u64, i32)>,
    /// The kernel's error number with which `fsync` fails.
    pub sync_error: Option<i32>,
}

/// A mounted disk. It is unmounted on drop.
pub struct Disk {
    folder: PathBuf,
}

impl Disk {
    /// Mounts a disk at this empty folder. `None` if this user or machine cannot mount it.
    #[must_use]
    pub fn mount(folder: &Path, manner: Manner) -> Option<Self> {
        let device = File::options().read(true).write(true).open("/dev/fuse");
        let device = device.ok()?;
        // `mount` gets the device as its standard input, which it hands to the kernel.
        let mounted = Command::new("mount")
            .args(["-i", "-t", "fuse", "-o"])
            .arg("fd=0,rootmode=40000,user_id=0,group_id=0")
            .arg("none")
            .arg(folder)
            .stdin(Stdio::from(device.try_clone().ok()?))
            .stderr(Stdio::null())
            .status();
        if !mounted.is_ok_and(|status| status.success()) {
            return None;
        }
        let mut files = Files {
            manner,
            names: BTreeMap::new(),
            contents: BTreeMap::new(),
        };
        std::thread::spawn(move || files.serve(device));
        Some(Self {
            folder: folder.to_owned(),
        })
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // The server's thread ends with the last program that uses the disk.
        let _ = Command::new("umount").arg("-l").arg(&self.folder).status();
    }
}

struct Files {
    manner: Manner,
    names: BTreeMap<Vec<u8>, u64>,
    contents: BTreeMap<u64, Vec<u8>>,
}

/// Answer to a request: bytes, or an error number.
type Answer = Result<Vec<u8>, i32>;

impl Files {
    fn serve(&mut self, mut device: File) {
        let mut buffer = vec![0; WRITE_MAX + 4096];
        loop {
            let length = match device.read(&mut buffer) {
                Ok(length) => length,
                // The program that asked has ended.
                Err(error) if error.raw_os_error() == Some(ENOENT) => continue,
                // The disk has been unmounted.
                Err(_) => return,
            };
            let Some((head, body)) = buffer
                .get(..length)
                .and_then(|it| it.split_at_checked(HEAD))
            else {
                return;
            };
            let (kind, unique, node) = (u32_at(head, 4), &head[8..16], u64_at(head, 16));
            let Some(answer) = self.answer(kind, node, body) else {
                continue;
            };
            let (error, body) = match answer {
                Ok(body) => (0, body),
                Err(error) => (-error, Vec::new()),
            };
            let mut reply = ((16 + body.len()) as u32).to_le_bytes().to_vec();
            reply.extend(error.to_le_bytes());
            reply.extend(unique);
            reply.extend(body);
            let _ = device.write(&reply);
        }
    }

    /// The answer to a request; `None` if the kernel expects none.
    fn answer(&mut self, kind: u32, node: u64, body: &[u8]) -> Option<Answer> {
        Some(match kind {
            1 => self.look_up(body),
            2 | 36 | 42 => return None, // forget, interrupt, forget several
            3 => Ok(attributes_out(self.attributes(node))),
            4 => self.set_attributes(node, body),
            10 => match self.names.remove(name(body)) {
                Some(_) => Ok(Vec::new()),
                None => Err(ENOENT),
            },
            14 | 27 => Ok(vec![0; 16]), // open a file, a folder
            15 => Ok(self.read(node, body)),
            16 => self.write(node, body),
            17 => Ok(room()),
            18 | 25 | 29 => Ok(Vec::new()), // release, flush
            20 => self.manner.sync_error.map_or(Ok(Vec::new()), Err),
            26 => Ok(greeting()),
            28 => Ok(Vec::new()), // the folder is not listed
            35 => {
                let number = ROOT + 1 + self.contents.len() as u64;
                self.names.insert(name(&body[16..]).to_vec(), number);
                self.contents.insert(number, Vec::new());
                let mut out = self.entry(number);
                out.extend([0; 16]);
                Ok(out)
            }
            _ => Err(ENOSYS),
        })
    }

    fn look_up(&self, body: &[u8]) -> Answer {
        let number = self.names.get(name(body)).ok_or(ENOENT)?;
        Ok(self.entry(*number))
    }

    fn set_attributes(&mut self, node: u64, body: &[u8]) -> Answer {
        const SIZE: u32 = 1 << 3;
        if u32_at(body, 0) & SIZE != 0 {
            let file = self.contents.get_mut(&node).ok_or(ENOENT)?;
            file.resize(u64_at(body, 16) as usize, 0);
        }
        Ok(attributes_out(self.attributes(node)))
    }

    fn read(&self, node: u64, body: &[u8]) -> Vec<u8> {
        let (offset, size) = (u64_at(body, 8) as usize, u32_at(body, 16) as usize);
        let file = self.contents.get(&node).map_or(&[][..], Vec::as_slice);
        let end = file.len().min(offset + size);
        file.get(offset..end).unwrap_or_default().to_vec()
    }

    fn write(&mut self, node: u64, body: &[u8]) -> Answer {
        std::thread::sleep(self.manner.delay);
        let (offset, size) = (u64_at(body, 8) as usize, u32_at(body, 16) as usize);
        let data = body.get(40..40 + size).ok_or(ENOSYS)?;
        let end = offset + size;
        if let Some((most, error)) = self.manner.error_after
            && end as u64 > most
        {
            return Err(error);
        }
        let file = self.contents.get_mut(&node).ok_or(ENOENT)?;
        file.resize(file.len().max(end), 0);
        file[offset..end].copy_from_slice(data);
        Ok((size as u64).to_le_bytes().to_vec())
    }

    fn attributes(&self, node: u64) -> Vec<u8> {
        let (mode, size) = match self.contents.get(&node) {
            Some(file) => (0o100_600_u32, file.len() as u64),
            None => (0o040_700, 0),
        };
        let mut out = Vec::new();
        // Number, size, blocks, and three times.
        for value in [node, size, size.div_ceil(512), 0, 0, 0] {
            out.extend(value.to_le_bytes());
        }
        // Parts of the times, mode, links, owner, group, device, size of a block, flags.
        for value in [0, 0, 0, mode, 1, 0, 0, 0, 4096, 0] {
            out.extend(value.to_le_bytes());
        }
        out
    }

    fn entry(&self, node: u64) -> Vec<u8> {
        let mut out = node.to_le_bytes().to_vec();
        out.extend([0; 32]); // generation, validity of name and attributes
        out.extend(self.attributes(node));
        out
    }
}

fn attributes_out(attributes: Vec<u8>) -> Vec<u8> {
    let mut out = vec![0; 16]; // validity
    out.extend(attributes);
    out
}

/// Version, and the most bytes of a write.
fn greeting() -> Vec<u8> {
    // Without this flag the kernel writes page by page, whatever the largest write is.
    const BIG_WRITES: u32 = 1 << 5;
    let mut out = Vec::new();
    for value in [7, 31, 0, BIG_WRITES, 0, WRITE_MAX as u32, 1] {
        out.extend(u32::to_le_bytes(value));
    }
    out.resize(64, 0);
    out
}

/// Free space: a gigabyte.
fn room() -> Vec<u8> {
    let mut out = Vec::new();
    for value in [1_u64 << 18, 1 << 18, 1 << 18, 1 << 10, 1 << 10] {
        out.extend(value.to_le_bytes());
    }
    for value in [4096_u32, 255, 4096, 0] {
        out.extend(value.to_le_bytes());
    }
    out.resize(80, 0);
    out
}

/// A name, up to the zero byte that ends it.
fn name(body: &[u8]) -> &[u8] {
    body.split(|byte| *byte == 0).next().unwrap_or_default()
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let four = bytes.get(at..at + 4).and_then(|it| it.try_into().ok());
    four.map_or(0, u32::from_le_bytes)
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let eight = bytes.get(at..at + 8).and_then(|it| it.try_into().ok());
    eight.map_or(0, u64::from_le_bytes)
}
