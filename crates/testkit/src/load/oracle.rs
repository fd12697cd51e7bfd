//! The expected result of each request: that of the same program, run on the command line without a server.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::process::binary;
use crate::stl::cuboid;

/// One request of the load and its undisturbed result.
pub struct Order {
    pub mesh: Vec<u8>,
    /// Without the mesh.
    pub request: Value,
    /// Times apart.
    pub result: Value,
}

/// The requests that clients choose from; `size` makes them longer than the shortest.
pub fn orders(folder: &Path, size: usize) -> Vec<Order> {
    let methods = ["modified_ga", "random", "local", "memetic"];
    (0..12_usize)
        .map(|number| {
            let mesh = cuboid([1.0, 2.0, 3.0 + (number % 3) as f32], 4);
            let settings = [
                ("method", methods[number % 4].to_owned()),
                ("contacts", (3 + number % 2).to_string()),
                (
                    "population",
                    if number == 3 { 12 } else { 3 + number % 3 }.to_string(),
                ),
                ("generations", (size * (2 + number % 5)).to_string()),
                ("candidates", "triangles".to_owned()),
                ("seed", number.to_string()),
            ];
            let request = settings
                .iter()
                .map(|(name, text)| {
                    let number: Option<u64> = text.parse().ok();
                    let value = number.map_or_else(|| text.as_str().into(), Value::from);
                    ((*name).to_owned(), value)
                })
                .collect();
            let result = plan(folder, &mesh, &settings);
            Order {
                mesh,
                request: Value::Object(request),
                result,
            }
        })
        .collect()
}

fn plan(folder: &Path, mesh: &[u8], settings: &[(&str, String)]) -> Value {
    let file = folder.join("calm.stl");
    std::fs::write(&file, mesh).expect("a file");
    let mut command = Command::new(binary());
    command.arg("plan").arg(&file).arg("--json");
    for (name, text) in settings {
        command.arg(format!("--{name}")).arg(text);
    }
    let output = command.output().expect("the binary");
    timeless(serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}")))
}

/// A result without what may differ between two runs of one request.
pub fn timeless(mut value: Value) -> Value {
    fn strip(value: &mut Value) {
        match value {
            Value::Object(object) => {
                object.remove("elapsed_s");
                object.values_mut().for_each(strip);
            }
            Value::Array(items) => items.iter_mut().for_each(strip),
            _ => {}
        }
    }
    strip(&mut value);
    value
}
