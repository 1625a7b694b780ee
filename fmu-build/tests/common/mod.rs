//! What a shared library exports and needs, of any platform; code blocks of pages.
#![allow(dead_code, missing_docs)] // every test binary uses its own part

pub mod python;

use object::read::elf::{FileHeader, SectionHeader};
use object::{BinaryFormat, Endianness, FileKind, Object, ObjectSymbol, SymbolScope, elf};
use std::collections::BTreeSet;

/// Fenced blocks of a page as (what follows the fence, text).
pub fn blocks(markdown: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut lines = markdown.lines();
    while let Some(line) = lines.next() {
        if let Some(language) = line.strip_prefix("```") {
            let text: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            found.push((language.to_owned(), text.join("\n")));
        }
    }
    found
}

pub fn functions() -> BTreeSet<String> {
    fmu_build::compile::exported().collect()
}

/// Names exported.
pub fn exports(bytes: &[u8]) -> BTreeSet<String> {
    let binary = object::File::parse(bytes).unwrap();
    if binary.format() == BinaryFormat::MachO {
        // By the scope of symbols: the reader's own list has private ones too. C names begin with an underscore.
        let shown = binary.symbols().filter(|s| s.is_definition() && s.scope() == SymbolScope::Dynamic);
        return shown.map(|s| s.name().unwrap().trim_start_matches('_').to_owned()).collect();
    }
    let name = |export: object::Export<'_>| {
        let name = export.into_name().into_name().expect("exported by name, not by number");
        String::from_utf8_lossy(&name).into_owned()
    };
    binary.exports().unwrap().map(|export| name(export.unwrap())).collect()
}

/// Shared libraries needed, as the binary names them; for ELF the versions of glibc's symbols as well.
pub fn needs(bytes: &[u8]) -> BTreeSet<String> {
    match FileKind::parse(bytes).unwrap() {
        FileKind::Elf32 => elf_needs::<elf::FileHeader32<Endianness>>(bytes),
        FileKind::Elf64 => elf_needs::<elf::FileHeader64<Endianness>>(bytes),
        _ => {
            let binary = object::File::parse(bytes).unwrap();
            let imports = binary.imports().unwrap();
            imports.map(|i| String::from_utf8_lossy(i.unwrap().library()).into_owned()).collect()
        }
    }
}

fn elf_needs<Elf: FileHeader<Endian = Endianness>>(bytes: &[u8]) -> BTreeSet<String> {
    let header = Elf::parse(bytes).unwrap();
    let endian = header.endian().unwrap();
    let sections = header.sections(endian, bytes).unwrap();
    let mut found = BTreeSet::new();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    for section in sections.iter() {
        if let Some((entries, strings)) = section.dynamic(endian, bytes).unwrap() {
            let strings = sections.strings(endian, bytes, strings).unwrap();
            use object::read::elf::Dyn;
            for entry in entries.iter().filter(|e| e.tag(endian) == elf::DT_NEEDED) {
                found.insert(text(entry.string(endian, strings).unwrap()));
            }
        }
        if let Some((mut versions, strings)) = section.gnu_verneed(endian, bytes).unwrap() {
            let strings = sections.strings(endian, bytes, strings).unwrap();
            while let Some((_, mut entries)) = versions.next().unwrap() {
                while let Some(entry) = entries.next().unwrap() {
                    found.insert(text(entry.name(endian, strings).unwrap()));
                }
            }
        }
    }
    found
}

/// Whether a library needed is the C library, its mathematics, or what the system brings along with them.
pub fn is_system(library: &str) -> bool {
    const ELF: [&str; 6] = ["libc.so", "libm.so", "libpthread.so", "libdl.so", "ld-linux", "GLIBC_"];
    const WINDOWS: [&str; 4] = ["api-ms-win-", "kernel32.dll", "ntdll.dll", "msvcrt.dll"];
    let lower = library.to_lowercase();
    ELF.iter().any(|name| library.starts_with(name))
        || WINDOWS.iter().any(|name| lower.starts_with(name))
        || library == "/usr/lib/libSystem.B.dylib"
}
