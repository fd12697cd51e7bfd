//! Pictures of meshes, decoded.

use reqwest::StatusCode;

use crate::common::{Server, problem, server, small_box, stl};

const BORDER: [u8; 3] = [255, 0, 32];

/// A picture as its decoder gives it: red, green, blue, opacity.
struct Picture {
    size: [u32; 2],
    pixels: Vec<[u8; 4]>,
}

impl Picture {
    fn decode(bytes: &[u8]) -> Self {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgba);
        Self {
            size: [info.width, info.height],
            pixels: pixels
                .chunks_exact(4)
                .map(|p| p.try_into().unwrap())
                .collect(),
        }
    }

    fn at(&self, x: u32, y: u32) -> [u8; 4] {
        self.pixels[(y * self.size[0] + x) as usize]
    }

    fn count(&self, wanted: [u8; 3]) -> usize {
        self.pixels.iter().filter(|p| p[..3] == wanted).count()
    }
}

impl Server {
    async fn picture(&self, path: &str) -> Picture {
        let answer = self.get(path).send().await.unwrap();
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        assert_eq!(answer.headers()["content-type"], "image/png");
        Picture::decode(&answer.bytes().await.unwrap())
    }
}

/// The box without its last triangle.
fn holed_box() -> Vec<u8> {
    let mut bytes = small_box();
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) - 1;
    bytes[80..84].copy_from_slice(&count.to_le_bytes());
    bytes.truncate(bytes.len() - 50);
    bytes
}

#[tokio::test(flavor = "multi_thread")]
async fn a_picture_shows_the_body_on_its_background() {
    let server = server().await;
    let id = server.mesh(small_box()).await;
    let light = server.picture(&format!("/meshes/{id}/preview.png")).await;
    assert_eq!(light.size, [1024, 512]);
    assert_eq!(light.at(0, 0), [255; 4]);
    // Beside the mark in the middle of either half is the body.
    for x in [256 + 20, 768 + 20] {
        let body = light.at(x, 256);
        assert!(body[..3] != [255; 3] && body[3] == 255, "{body:?}");
    }
    let dark = format!("/meshes/{id}/preview.png?theme=dark&width=301");
    let dark = server.picture(&dark).await;
    assert_eq!(dark.size, [301, 150]);
    assert!(dark.at(0, 0)[..3].iter().all(|part| *part < 40));
    let body = |picture: &Picture| {
        let background = picture.at(0, 0);
        let drawn = picture.pixels.iter().filter(|p| **p != background).count();
        drawn as f64 / picture.pixels.len() as f64
    };
    assert!((body(&light) - body(&dark)).abs() < 0.03);
}

#[tokio::test(flavor = "multi_thread")]
async fn only_a_hole_is_rimmed_in_red() {
    let server = server().await;
    for (mesh, holed) in [(small_box(), false), (holed_box(), true)] {
        let id = server.mesh(mesh).await;
        let picture = server.picture(&format!("/meshes/{id}/preview.png")).await;
        assert_eq!(picture.count(BORDER) > 50, holed);
        assert_eq!(picture.count(BORDER) > 0, holed);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_svg_has_picture_figures_and_the_name_that_its_sender_gave() {
    let server = server().await;
    let part = reqwest::multipart::Part::bytes(holed_box()).file_name("a<b>&c.stl");
    let form = reqwest::multipart::Form::new().part("mesh", part);
    let answer = server.post("/meshes").multipart(form).send().await.unwrap();
    let path = answer.headers()["location"].to_str().unwrap().to_owned() + "/preview.svg";
    let svg = server.get(&path).send().await.unwrap();
    assert_eq!(svg.status(), StatusCode::OK);
    assert_eq!(svg.headers()["content-type"], "image/svg+xml");
    let svg = svg.text().await.unwrap();
    for wanted in [
        "a&lt;b&gt;&amp;c.stl",
        ">border edges</text>",
        ">3</text>",
        "the surface is open along 3 edges",
        "prefers-color-scheme:dark",
        "href=\"data:image/png;base64,iVBORw0KGgo",
    ] {
        assert!(svg.contains(wanted), "{wanted}");
    }
    let dark = server.get(&(path + "?theme=dark")).send().await.unwrap();
    let dark = dark.text().await.unwrap();
    assert!(dark.contains("#16181c") && !dark.contains("prefers-color-scheme"));
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_have_entity_tags() {
    let server = server().await;
    let id = server.mesh(small_box()).await;
    let mut tags = Vec::new();
    for name in [
        "preview.png",
        "preview.png?theme=dark",
        "preview.png?width=200",
        "preview.svg",
    ] {
        let path = format!("/meshes/{id}/{name}");
        let answer = server.get(&path).send().await.unwrap();
        let tag = answer.headers()["etag"].clone();
        let again = server.get(&path).header("if-none-match", &tag);
        let again = again.send().await.unwrap();
        assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
        assert_eq!(again.headers()["etag"], tag);
        let other = server.get(&path).header("if-none-match", "\"x\"");
        assert_eq!(other.send().await.unwrap().status(), StatusCode::OK);
        assert!(!tags.contains(&tag), "{tag:?}");
        tags.push(tag);
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_mesh_under_another_name_is_another_picture() {
    let server = server().await;
    let mut tags = Vec::new();
    for name in ["one.stl", "two.stl", "one.stl"] {
        let part = reqwest::multipart::Part::bytes(holed_box()).file_name(name);
        let form = reqwest::multipart::Form::new().part("mesh", part);
        let answer = server.post("/meshes").multipart(form).send().await.unwrap();
        let mesh = answer.headers()["location"].to_str().unwrap().to_owned();
        let picture = server.get(&format!("{mesh}/preview.svg")).send().await;
        let picture = picture.unwrap();
        tags.push(picture.headers()["etag"].clone());
        assert!(picture.text().await.unwrap().contains(name));
        let deleted = server.delete(&mesh).send().await.unwrap();
        assert_eq!(deleted.status(), StatusCode::NO_CONTENT);
    }
    assert!(tags[0] != tags[1] && tags[0] == tags[2], "{tags:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_drawn_is_a_problem() {
    let server = server().await;
    let id = server.mesh(small_box()).await;
    for name in ["preview.png", "preview.svg"] {
        let path = format!("/meshes/{id}/{name}");
        for query in [
            "width=63",
            "width=4097",
            "width=many",
            "width=",
            "theme=blue",
            "width=100&width=200",
            "height=100",
        ] {
            let answer = server.get(&format!("{path}?{query}")).send().await.unwrap();
            let problem = problem(answer, 400).await;
            let name = query.split('=').next().unwrap();
            assert_eq!(problem["errors"][0]["pointer"], format!("/{name}"));
        }
        for accept in ["application/json", "image/gif", "image/*;q=0"] {
            let answer = server.get(&path).header("accept", accept).send().await;
            problem(answer.unwrap(), 406).await;
        }
        let image = server.get(&path).header("accept", "image/*").send().await;
        assert_eq!(image.unwrap().status(), StatusCode::OK);
        for unknown in ["0".repeat(64), "x".to_owned()] {
            let path = format!("/meshes/{unknown}/{name}");
            problem(server.get(&path).send().await.unwrap(), 404).await;
        }
        problem(server.delete(&path).send().await.unwrap(), 405).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_deleted_mesh_is_not_drawn() {
    let server = server().await;
    let tetrahedron = stl(&[
        [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    ]);
    let id = server.mesh(tetrahedron).await;
    let path = format!("/meshes/{id}");
    let picture = format!("{path}/preview.png");
    assert_eq!(server.picture(&picture).await.size, [1024, 512]);
    server.delete(&path).send().await.unwrap();
    problem(server.get(&picture).send().await.unwrap(), 404).await;
}
