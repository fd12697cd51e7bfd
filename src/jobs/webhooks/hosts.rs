//! Which hosts webhooks may call, and what a callback URL may look like.

use std::str::FromStr;

use url::{Host, Url};

use crate::wire::MAX_URL_BYTES;

/// A host, or with a leading `*.` every name below it, however deep.
#[derive(Debug, Clone, PartialEq, Eq)]
struct HostPattern {
    host: Host,
    below: bool,
}

impl HostPattern {
    fn matches(&self, host: &Host<&str>) -> bool {
        match (&self.host, host) {
            (Host::Domain(base), Host::Domain(name)) if self.below => name
                .strip_suffix(base.as_str())
                .is_some_and(|rest| rest.len() > 1 && rest.ends_with('.')),
            (Host::Domain(own), Host::Domain(name)) => own == name,
            (Host::Ipv4(own), Host::Ipv4(address)) => own == address,
            (Host::Ipv6(own), Host::Ipv6(address)) => own == address,
            _ => false,
        }
    }
}

impl FromStr for HostPattern {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (below, name) = match text.strip_prefix("*.") {
            Some(base) => (true, base),
            None => (false, text),
        };
        match Host::parse(name) {
            Ok(Host::Domain(name)) if name.contains('*') => Err(format!(
                "{text:?}: a * may only be the first label, as in *.example.com"
            )),
            Ok(Host::Ipv4(_) | Host::Ipv6(_)) if below => {
                Err(format!("{text:?}: an address has no names below it"))
            }
            Ok(host) => Ok(Self { host, below }),
            Err(fault) => Err(format!(
                "{text:?} is not a host name such as example.com or *.example.com ({fault})"
            )),
        }
    }
}

/// The hosts that callback URLs may name, each with scheme and port. Without any, webhooks are off.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AllowedHosts(Vec<AllowedHost>);

#[derive(Debug, Clone, PartialEq, Eq)]
struct AllowedHost {
    scheme: &'static str,
    host: HostPattern,
    port: u16,
}

impl AllowedHosts {
    /// Returns whether webhooks are off.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns a callback URL in its normal form, or what is wrong with it, as a sentence without a subject.
    pub fn check(&self, text: &str) -> Result<Url, String> {
        if self.is_empty() {
            return Err(
                "webhooks are off on this server: leave it out and poll the job, or ask the \
                 operator to allow hosts with --webhook-hosts"
                    .to_owned(),
            );
        }
        let url =
            Url::parse(text).map_err(|fault| format!("must be an absolute https URL ({fault})"))?;
        if !matches!(url.scheme(), "http" | "https") {
            return Err(format!("must be an https URL, not {}", url.scheme()));
        }
        if !url.username().is_empty() || url.password().is_some() {
            return Err("must have no user name and no password; webhooks are signed".to_owned());
        }
        if url.fragment().is_some() {
            return Err("must have no fragment; leave out what begins with #".to_owned());
        }
        if url.as_str().len() > MAX_URL_BYTES {
            return Err(format!("must be at most {MAX_URL_BYTES} bytes long"));
        }
        let host = url.host().ok_or("must name a host")?;
        let port = url.port_or_known_default();
        let allowed = |allowed: &AllowedHost| {
            allowed.scheme == url.scheme()
                && Some(allowed.port) == port
                && allowed.host.matches(&host)
        };
        if !self.0.iter().any(allowed) {
            return Err(format!(
                "the operator of this server allows no webhooks to {}://{host}:{}; use a host, \
                 scheme and port that --webhook-hosts lists",
                url.scheme(),
                port.unwrap_or_default(),
            ));
        }
        Ok(url)
    }
}

impl FromStr for AllowedHosts {
    type Err = String;

    /// Reads `[http://]HOST[:PORT],...`. The default scheme is https, the default port that of the scheme.
    fn from_str(list: &str) -> Result<Self, String> {
        items(list)
            .map(str::parse)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

impl FromStr for AllowedHost {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (scheme, rest) = match text.split_once("://") {
            None => ("https", text),
            Some(("https", rest)) => ("https", rest),
            Some(("http", rest)) => ("http", rest),
            Some(_) => return Err(format!("{text:?}: the scheme must be https or http")),
        };
        let (host, port) = match rest.rsplit_once(':') {
            // The last colon may be one inside an IPv6 address.
            Some((host, port)) if !port.ends_with(']') => match port.parse() {
                Ok(port) => (host, port),
                Err(_) => return Err(format!("{text:?}: {port:?} is not a port")),
            },
            _ => (rest, if scheme == "https" { 443 } else { 80 }),
        };
        Ok(Self {
            scheme,
            host: host.parse()?,
            port,
        })
    }
}

/// The hosts that may have addresses which are not public.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PrivateHosts(Vec<HostPattern>);

impl PrivateHosts {
    /// Returns whether this host may.
    pub fn contains(&self, host: &Host<&str>) -> bool {
        self.0.iter().any(|pattern| pattern.matches(host))
    }
}

impl FromStr for PrivateHosts {
    type Err = String;

    /// Reads `HOST,...`.
    fn from_str(list: &str) -> Result<Self, String> {
        items(list)
            .map(str::parse)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

fn items(list: &str) -> impl Iterator<Item = &str> {
    list.split(',')
        .map(str::trim)
        .filter(|item| !item.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allowed(list: &str) -> AllowedHosts {
        list.parse().unwrap()
    }

    #[test]
    fn only_listed_places_pass() {
        let hosts = "hooks.example.com, *.example.org:8443,http://plain.local:9000,203.0.113.7,\
                     http://[::1]:9000,https://bücher.example";
        let hosts = allowed(hosts);
        for good in [
            "https://hooks.example.com",
            "https://HOOKS.Example.com:443/a/b?token=1&x=%20",
            "https://a.example.org:8443/",
            "https://a.b.example.org:8443/",
            "http://plain.local:9000/x",
            "https://203.0.113.7/x",
            // The same literal in another spelling.
            "https://0xcb.0.113.7/x",
            "http://[0:0:0:0:0:0:0:1]:9000/x",
            "https://xn--bcher-kva.example/",
        ] {
            assert!(hosts.check(good).is_ok(), "{good}: {:?}", hosts.check(good));
        }
        for bad in [
            "https://example.com/",
            "https://hooks.example.com.evil.test/",
            "https://hooks.example.com.:443/",
            "https://evil.test/hooks.example.com",
            "https://evil.test\\@hooks.example.com/",
            "https://hooks.example.com:8443/",
            "http://hooks.example.com/",
            "http://hooks.example.com:443/",
            "https://example.org:8443/",
            "https://.example.org:8443/",
            "https://evilexample.org:8443/",
            "https://a.example.org/",
            "https://plain.local:9000/",
            "http://plain.local/",
            "https://203.0.113.8/",
            "https://127.0.0.1/",
            "https://2130706433/",
            "http://[::1]/",
            "http://[::ffff:127.0.0.1]:9000/",
            "https://localhost/",
        ] {
            assert!(hosts.check(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn refusals_of_callbacks_name_the_fault() {
        let hosts = allowed("hooks.example.com");
        let long = format!("https://hooks.example.com/{}", "x".repeat(2048));
        // Short as written, long once escaped.
        let escaped = format!("https://hooks.example.com/{}", "é".repeat(500));
        for (bad, why) in [
            ("", "absolute"),
            ("hooks.example.com", "absolute"),
            ("/x", "absolute"),
            ("https://", "absolute"),
            ("ftp://hooks.example.com/", "not ftp"),
            ("file:///etc/passwd", "not file"),
            ("javascript:alert(1)", "not javascript"),
            ("https://u@hooks.example.com/", "no user name"),
            ("https://u:p@hooks.example.com/", "no user name"),
            ("https://hooks.example.com@evil.test/", "no user name"),
            ("https://hooks.example.com/#x", "no fragment"),
            (&long, "2048 bytes"),
            (&escaped, "2048 bytes"),
            ("https://evil.test/", "https://evil.test:443"),
        ] {
            let said = hosts.check(bad).unwrap_err();
            assert!(said.contains(why), "{bad}: {said}");
        }
        let off = AllowedHosts::default().check("https://hooks.example.com/");
        assert!(off.unwrap_err().contains("off"));
    }

    #[test]
    fn lists_that_mean_nothing_are_refused() {
        for list in ["", " , "] {
            assert!(allowed(list).is_empty(), "{list:?}");
        }
        for wrong in [
            "ftp://example.com",
            "https://",
            "example.com:",
            "example.com:70000",
            "example.com/hook",
            "u@example.com",
            "*",
            "*.",
            "a.*.example.com",
            "*.127.0.0.1",
            "::1",
            "exa mple.com",
            "good.example,b@d.example",
        ] {
            let read = wrong.parse::<AllowedHosts>();
            assert!(read.is_err(), "{wrong:?}: {read:?}");
        }
        for wrong in ["http://example.com", "example.com:80", "*"] {
            let read = wrong.parse::<PrivateHosts>();
            assert!(read.is_err(), "{wrong:?}: {read:?}");
        }
    }

    #[test]
    fn private_hosts_are_those_listed() {
        let hosts: PrivateHosts = "localhost,*.internal,10.0.0.1".parse().unwrap();
        for (url, listed) in [
            ("http://localhost/", true),
            ("http://a.internal/", true),
            ("http://10.0.0.1/", true),
            ("http://10.0.0.2/", false),
            ("http://internal/", false),
            ("http://example.com/", false),
        ] {
            let url = Url::parse(url).unwrap();
            assert_eq!(hosts.contains(&url.host().unwrap()), listed, "{url}");
        }
    }
}
