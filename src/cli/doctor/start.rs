//! Settings with which a server would not start. The checks are those of the server.

use std::net::SocketAddr;

use super::Finding;
use crate::cli::daemon::log_filter;
use crate::config::Config;
use crate::http::{cors_layer, requires_keys};
use crate::jobs::webhooks;

/// Checks all such settings.
pub async fn findings(config: &Config) -> Vec<Finding> {
    let mut findings = Vec::new();
    // An address that cannot be resolved is reported by the check of the address.
    if let Ok(mut addresses) = tokio::net::lookup_host(&config.listen).await
        && let Some(address) = addresses.next()
    {
        findings.push(keys(config, address));
    }
    findings.extend([webhooks(config), origins(config), log_level(config)]);
    findings
}

fn keys(config: &Config, address: SocketAddr) -> Finding {
    let check = "API keys";
    match requires_keys(config, address) {
        Ok(true) => Finding::ok(check, "required"),
        Ok(false) => Finding::ok(check, "not required"),
        Err(fault) => Finding::wrong(check, fault, "set --auth, or listen on 127.0.0.1"),
    }
}

fn webhooks(config: &Config) -> Finding {
    let check = "webhooks";
    let options = webhooks::Options::new(
        config.webhook_hosts.clone(),
        config.webhook_private_hosts.clone(),
        config.webhook_secret.as_ref(),
    );
    match options {
        Ok(options) if options.hosts.is_empty() => Finding::ok(check, "off"),
        Ok(_) => Finding::ok(check, "on, and signed"),
        Err(fault) => Finding::wrong(
            check,
            fault,
            "set GRASPD_WEBHOOK_SECRET to whsec_ and the output of openssl rand -base64 32",
        ),
    }
}

fn origins(config: &Config) -> Finding {
    let check = "CORS";
    match cors_layer(&config.cors_origins) {
        Ok(None) => Finding::ok(check, "off"),
        Ok(Some(_)) => Finding::ok(check, config.cors_origins.join(", ")),
        Err(fault) => Finding::wrong(check, fault, "correct the origin in --cors-origins"),
    }
}

fn log_level(config: &Config) -> Finding {
    let check = "log level";
    match log_filter(&config.log) {
        Ok(filter) => Finding::ok(check, filter),
        Err(fault) => Finding::wrong(
            check,
            fault,
            "use error, warn, info, debug, trace, or a filter such as info,graspd=debug",
        ),
    }
}
