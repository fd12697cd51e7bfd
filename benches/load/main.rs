//! Drives a running server hard and says how it took it, each measurement as a row of a Markdown table:
//! `cargo bench --bench load -- URL COMMAND`. benches/load.sh starts the servers and runs them all.

mod api;
mod measures;
mod times;

use api::Api;

const COMMANDS: &str = "overhead COUNT | queue COUNT | keys CLIENTS SUBMISSIONS KEYS | cancels COUNT | soak SECONDS RATE";

#[tokio::main]
async fn main() {
    // Cargo adds this when it runs a bench; without it this is a test run, with nothing to drive.
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let Some(at) = arguments.iter().position(|argument| argument == "--bench") else {
        return;
    };
    arguments.remove(at);
    let (Some(url), Some(command)) = (arguments.first(), arguments.get(1)) else {
        usage();
    };
    let number = |at: usize| {
        let text = arguments.get(at).map_or("", String::as_str);
        text.parse::<usize>().unwrap_or_else(|_| usage())
    };
    let api = Api::new(url).await;
    match command.as_str() {
        "overhead" => measures::overhead(&api, number(2)).await,
        "queue" => measures::queue(&api, number(2)).await,
        "keys" => measures::keys(&api, number(2), number(3), number(4)).await,
        "cancels" => measures::cancels(&api, number(2)).await,
        "soak" => measures::soak(&api, number(2), number(3)).await,
        _ => usage(),
    }
}

fn usage() -> ! {
    eprintln!("usage: load URL ({COMMANDS})");
    std::process::exit(2);
}
