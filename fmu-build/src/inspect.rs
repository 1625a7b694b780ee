//! Exports and dependencies of a shared library for any platform, without loading it.

use object::read::elf::{Dyn, FileHeader, SectionHeader};
use object::read::macho::{FatArch, MachOFatFile32};
use object::{Architecture, BinaryFormat, Endianness, FileKind, Object, ObjectSymbol, SymbolScope, elf};
use std::collections::BTreeSet;

/// Result with the object reader's error: the file is not a library, or is damaged.
pub type Result<T> = std::result::Result<T, object::Error>;

/// Format and processor of a library.
///
/// # Errors
/// An error if the file is not a library.
pub fn kind(bytes: &[u8]) -> Result<(BinaryFormat, Architecture)> {
    let binary = object::File::parse(bytes)?;
    Ok((binary.format(), binary.architecture()))
}

/// Format and processor of binaries for a target of the Rust compiler.
pub fn kind_of_target(target: &str) -> (BinaryFormat, Architecture) {
    let architecture = match target.split('-').next() {
        Some("x86_64") => Architecture::X86_64,
        Some("i686") => Architecture::I386,
        _ => Architecture::Aarch64,
    };
    let format = match target {
        _ if target.contains("windows") => BinaryFormat::Pe,
        _ if target.contains("apple") => BinaryFormat::MachO,
        _ => BinaryFormat::Elf,
    };
    (format, architecture)
}

/// The libraries in a universal Mach-O file. Any other file counts as a single library.
///
/// # Errors
/// An error if the file's table points outside the file.
pub fn slices(bytes: &[u8]) -> Result<Vec<&[u8]>> {
    match MachOFatFile32::parse(bytes) {
        Ok(fat) => fat.arches().iter().map(|arch| arch.data(bytes)).collect(),
        Err(_) => Ok(vec![bytes]),
    }
}

/// Exported names. Libraries export by name, not by number.
///
/// # Errors
/// An error if the file is not a library.
pub fn exports(bytes: &[u8]) -> Result<BTreeSet<String>> {
    let binary = object::File::parse(bytes)?;
    if binary.format() == BinaryFormat::MachO {
        // Filtered by symbol scope: the reader's own export list includes private symbols. C names
        // begin with an underscore.
        let shown = binary.symbols().filter(|s| s.is_definition() && s.scope() == SymbolScope::Dynamic);
        return shown.map(|s| Ok(s.name()?.trim_start_matches('_').to_owned())).collect();
    }
    let mut names = BTreeSet::new();
    for export in binary.exports()? {
        if let Some(name) = export?.into_name().into_name() {
            names.insert(text(&name));
        }
    }
    Ok(names)
}

/// Names of the required shared libraries, as in the binary; for ELF, also the versions of glibc's
/// symbols.
///
/// # Errors
/// An error if the file is not a library.
pub fn needs(bytes: &[u8]) -> Result<BTreeSet<String>> {
    match FileKind::parse(bytes)? {
        FileKind::Elf32 => elf_needs::<elf::FileHeader32<Endianness>>(bytes),
        FileKind::Elf64 => elf_needs::<elf::FileHeader64<Endianness>>(bytes),
        _ => object::File::parse(bytes)?.imports()?.map(|i| Ok(text(i?.library()))).collect(),
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn elf_needs<Elf: FileHeader<Endian = Endianness>>(bytes: &[u8]) -> Result<BTreeSet<String>> {
    let header = Elf::parse(bytes)?;
    let endian = header.endian()?;
    let sections = header.sections(endian, bytes)?;
    let mut found = BTreeSet::new();
    for section in sections.iter() {
        if let Some((entries, strings)) = section.dynamic(endian, bytes)? {
            let strings = sections.strings(endian, bytes, strings)?;
            for entry in entries.iter().filter(|e| e.tag(endian) == elf::DT_NEEDED) {
                found.insert(text(entry.string(endian, strings)?));
            }
        }
        if let Some((mut versions, strings)) = section.gnu_verneed(endian, bytes)? {
            let strings = sections.strings(endian, bytes, strings)?;
            while let Some((_, mut entries)) = versions.next()? {
                while let Some(entry) = entries.next()? {
                    found.insert(text(entry.name(endian, strings)?));
                }
            }
        }
    }
    Ok(found)
}

/// Whether a needed library is libc, libm, or part of the operating system.
pub fn is_system(library: &str) -> bool {
    const ELF: [&str; 6] = ["libc.so", "libm.so", "libpthread.so", "libdl.so", "ld-linux", "GLIBC_"];
    const WINDOWS: [&str; 4] = ["api-ms-win-", "kernel32.dll", "ntdll.dll", "msvcrt.dll"];
    let lower = library.to_lowercase();
    ELF.iter().any(|name| library.starts_with(name))
        || WINDOWS.iter().any(|name| lower.starts_with(name))
        || library == "/usr/lib/libSystem.B.dylib"
}

/// The oldest supported glibc, from CentOS 7.
pub const GLIBC: [u32; 2] = [2, 17];

/// A needed version of glibc that is later than [`GLIBC`], if any.
pub fn later_glibc(needs: &BTreeSet<String>) -> Option<&str> {
    let versions = needs.iter().filter_map(|name| name.strip_prefix("GLIBC_"));
    let later = |text: &&str| {
        let numbers: Vec<u32> = text.split('.').filter_map(|n| n.parse().ok()).collect();
        numbers.as_slice() >= &[GLIBC[0], GLIBC[1] + 1][..]
    };
    versions.into_iter().find(later)
}
