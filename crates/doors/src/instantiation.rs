//! Arguments of an instantiation, and the properties of a variable that a door needs.

use crate::ffi::Fault;
use crate::ffi::library::own_path;
use crate::life::{EventHandling, Interface, Life};
use crate::problem::Problem;
use std::borrow::Cow;
use std::path::PathBuf;

/// A version of FMI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
}

/// Arguments of an instantiation (FMI 2.0, 2.1.5; FMI 3.0.2, 2.3.1).
#[derive(Clone, Copy, Debug)]
pub struct Instantiation<'a> {
    /// FMI version of the call.
    pub version: Version,
    /// Intended use of the instance.
    pub interface: Interface,
    /// Event handling by the host.
    pub handling: EventHandling,
    /// Name of the instance: not blank.
    pub name: &'a str,
    /// Token that identifies the model description: `fmuGUID`, `instantiationToken`.
    pub token: &'a str,
    /// Location of the FMU's folder `resources` as given by the host: a URI in FMI 2.0, a path in
    /// FMI 3.0; `None` if the host gives none.
    pub resources: Option<&'a str>,
}

impl Instantiation<'_> {
    /// Refuses a token that differs from `own`. The error has the version's name for the argument.
    ///
    /// # Errors
    /// [`Problem::Fault`].
    pub fn check_token(&self, own: &str) -> Result<(), Problem> {
        if self.token == own { Ok(()) } else { Err(self.wrong_token(own)) }
    }

    /// The error for a token of another library.
    pub fn wrong_token(&self, allowed: &str) -> Problem {
        let argument = match self.version {
            Version::Fmi2 => "fmuGUID",
            Version::Fmi3 => "instantiationToken",
        };
        let (value, allowed) = (self.token.to_owned(), allowed.to_owned());
        Problem::Fault(Fault::Text { argument, value, allowed })
    }

    /// The folder of the FMU's resources. In FMI 2.0 the location is a file URI, with or without a
    /// host and percent codes, or a path, which some hosts give. In FMI 3.0 it is a path, with or
    /// without a trailing separator. The folder need not exist.
    ///
    /// # Errors
    /// [`Problem::Fault`] if the host gives no location, or one that is not a file.
    pub fn resource_folder(&self) -> Result<PathBuf, Problem> {
        let (argument, form) = match self.version {
            Version::Fmi2 => ("fmuResourceLocation", "the URI of a folder, file:///…"),
            Version::Fmi3 => ("resourcePath", "the path of a folder"),
        };
        let given = self.resources.unwrap_or_default();
        let path = match self.version {
            Version::Fmi2 => path_of_uri(given),
            Version::Fmi3 => Some(given.to_owned()),
        };
        let refused = || Fault::Text { argument, value: given.to_owned(), allowed: form.to_owned() };
        let path = path.filter(|path| !path.is_empty()).ok_or_else(refused)?;
        Ok(PathBuf::from(path))
    }

    /// Possible folders of the FMU's resources, the most likely first: the folder that the host
    /// gives, then the folder `resources` of the unpacked FMU that contains the library, for hosts
    /// that give no folder or a wrong one.
    pub fn resource_folders(&self) -> Vec<PathBuf> {
        // The library is in binaries/PLATFORM/.
        let beside = own_path().and_then(|path| Some(path.ancestors().nth(3)?.join("resources")));
        self.resource_folder().ok().into_iter().chain(beside).collect()
    }

    /// Lifecycle data of the new instance.
    pub fn life(&self) -> Life {
        Life::new(self.interface, self.handling)
    }
}

/// The properties of a variable that a door needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named<'a> {
    /// Its name.
    pub name: Cow<'a, str>,
    /// Whether it is a continuous input, which may be set within a step.
    pub continuous_input: bool,
    /// Whether its description has `intermediateUpdate="true"` (FMI 3.0.2, 4.2.2).
    pub intermediate_update: bool,
}

/// The path of a file URI (RFC 8089); `None` for another scheme, or for percent codes that are not
/// UTF-8.
fn path_of_uri(uri: &str) -> Option<String> {
    let Some(scheme) = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("file:")) else {
        return (!uri.contains("://")).then(|| uri.to_owned());
    };
    let path = decoded(&uri[scheme.len()..])?;
    let Some(of_host) = path.strip_prefix("//") else { return Some(path) };
    let (host, rest) = of_host.split_at(of_host.find('/')?);
    let drive = rest.as_bytes().get(2) == Some(&b':');
    Some(match host {
        // A Windows path begins with its drive.
        "" | "localhost" if drive => rest[1..].to_owned(),
        "" | "localhost" => rest.to_owned(),
        // A folder of another machine.
        _ => path,
    })
}

/// Text with its percent codes decoded. A percent sign without a valid code is kept.
fn decoded(text: &str) -> Option<String> {
    let (mut bytes, mut rest) = (Vec::with_capacity(text.len()), text.as_bytes());
    while let Some((&first, after)) = rest.split_first() {
        let code = after.first_chunk::<2>().filter(|_| first == b'%');
        let code = code.and_then(|code| std::str::from_utf8(code).ok());
        let hexadecimal = |code: &&str| code.bytes().all(|byte| byte.is_ascii_hexdigit());
        match code.filter(hexadecimal).and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &after[2..];
            }
            None => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(version: Version, resources: Option<&str>) -> Result<PathBuf, Problem> {
        let (interface, handling) = (Interface::CoSimulation, EventHandling::default());
        Instantiation { version, interface, handling, name: "a", token: "", resources }.resource_folder()
    }

    #[test]
    fn resources_are_found_by_what_hosts_say() {
        for (uri, path) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources/", "/tmp/resources/"),
            ("file://localhost/tmp/%C3%BC", "/tmp/ü"),
            ("FILE:///C:/Temp/resources", "C:/Temp/resources"),
            ("file://server/share/resources", "//server/share/resources"),
            ("file:///tmp/100%", "/tmp/100%"),
            ("/tmp/resources", "/tmp/resources"),
        ] {
            assert_eq!(folder(Version::Fmi2, Some(uri)), Ok(PathBuf::from(path)), "{uri}");
        }
        let own = "/tmp/a%20b/";
        assert_eq!(folder(Version::Fmi3, Some(own)), Ok(PathBuf::from(own)));
    }

    #[test]
    fn resources_that_are_no_folder_are_refused_by_name() {
        for (version, resources, text) in [
            (Version::Fmi2, None, "fmuResourceLocation = \"\": expected the URI of a folder"),
            (Version::Fmi2, Some("https://a/b"), "fmuResourceLocation = \"https://a/b\": expected"),
            (Version::Fmi2, Some("file:///%ff"), "fmuResourceLocation = \"file:///%ff\""),
            (Version::Fmi2, Some("file://server"), "fmuResourceLocation"),
            (Version::Fmi3, None, "resourcePath = \"\": expected the path of a folder"),
        ] {
            let problem = folder(version, resources).unwrap_err().to_string();
            assert!(problem.starts_with(text), "{problem}");
        }
    }
}
