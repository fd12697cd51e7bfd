//! Meshes that are added or refused.

use super::*;

fn options_of(format: Option<MeshFormat>) -> MeshOptions {
    MeshOptions {
        format,
        ..MeshOptions::default()
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn bad_meshes_are_named_and_leave_nothing() {
    let data = data();
    let service = start(options(&data)).await;
    let flat = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (text, format, status) in [
        ("", None, 415),
        ("hello, this is no mesh", None, 415),
        (flat, None, 422),
        ("v 0 0 0\nv 1 0 0\nf 1 2 9\n", Some(MeshFormat::Obj), 422),
    ] {
        let refused = service
            .add_mesh(
                &Owner::ANONYMOUS,
                incoming(upload(&service, text).await, options_of(format), None),
            )
            .await;
        let Err(Error::Refused(problem)) = refused else {
            panic!("{text:?}: {refused:?}");
        };
        assert_eq!(problem.status, status, "{text:?}: {problem:?}");
    }
    let too_big: String = "f 1 3 2\n".repeat(2000);
    let upload = upload(&service, &format!("{TETRAHEDRON}{too_big}")).await;
    let refused = service
        .add_mesh(&Owner::ANONYMOUS, incoming(upload, options_of(None), None))
        .await;
    assert!(matches!(refused, Err(Error::Refused(problem)) if problem.status == 422));
    assert_eq!(files_in(&data), 0);
    assert!(
        service
            .meshes(&Owner::ANONYMOUS, 10, None)
            .await
            .unwrap()
            .meshes
            .is_empty()
    );
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_same_mesh_is_kept_once() {
    let data = data();
    let service = start(options(&data)).await;
    let first = upload(&service, TETRAHEDRON).await;
    let (mesh, created) = service
        .add_mesh(
            &Owner::ANONYMOUS,
            incoming(first, options_of(None), Some("tetra.obj".to_owned())),
        )
        .await
        .unwrap();
    assert!(created);
    assert!(
        mesh.report.get().contains(r#""candidates":4"#),
        "{}",
        mesh.report
    );
    for format in [None, Some(MeshFormat::Obj)] {
        let (again, created) = service
            .add_mesh(
                &Owner::ANONYMOUS,
                incoming(
                    upload(&service, TETRAHEDRON).await,
                    options_of(format),
                    None,
                ),
            )
            .await
            .unwrap();
        assert_eq!((&again.id, created), (&mesh.id, false));
        assert_eq!(again.file_name.as_deref(), Some("tetra.obj"));
    }
    assert_eq!(files_in(&data), 1);
    assert_eq!(
        service
            .mesh(&Owner::ANONYMOUS, mesh.id.as_str())
            .await
            .unwrap()
            .id,
        mesh.id
    );
    for id in ["", "../../graspd.db", &"0".repeat(64)] {
        assert!(
            matches!(
                service.mesh(&Owner::ANONYMOUS, id).await,
                Err(Error::NotFound)
            ),
            "{id}"
        );
        assert!(
            matches!(
                service.delete_mesh(&Owner::ANONYMOUS, id).await,
                Err(Error::NotFound)
            ),
            "{id}"
        );
    }
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_refused_job_leaves_no_mesh() {
    let data = data();
    let service = start(Options {
        queue_capacity: 1,
        ..options(&data)
    })
    .await;
    let fields = [("contacts", "9"), ("candidates", "triangles")];
    let fields = fields.map(|(name, value)| (name.to_owned(), value.to_owned()));
    let nine = PlanRequest::from_form(fields, 7).unwrap();
    let refused = service
        .submit_with_upload(
            &Owner::ANONYMOUS,
            incoming(upload(&service, TETRAHEDRON).await, options_of(None), None),
            nine.clone(),
            None,
        )
        .await;
    let Err(Error::Refused(problem)) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!(
        (problem.status, problem.errors[0].pointer.as_str()),
        (422, "/contacts")
    );
    assert!(
        problem.detail.contains('9') && problem.detail.contains('4'),
        "{}",
        problem.detail
    );
    assert_eq!(files_in(&data), 0);

    let job = submit(&service, "endless").await;
    until(&service, job.id, JobState::Running).await;
    submit(&service, "quick").await;
    let other = format!("{TETRAHEDRON}# another\n");
    let refused = service
        .submit_with_upload(
            &Owner::ANONYMOUS,
            incoming(upload(&service, &other).await, options_of(None), None),
            request(""),
            None,
        )
        .await;
    assert!(
        matches!(
            refused,
            Err(Error::QueueFull {
                retry_after_s: 1..=60
            })
        ),
        "{refused:?}"
    );
    let refused = service
        .submit(&Owner::ANONYMOUS, &job.mesh_id, request(""), None)
        .await;
    assert!(
        matches!(refused, Err(Error::QueueFull { .. })),
        "{refused:?}"
    );
    let refused = service
        .submit(&Owner::ANONYMOUS, &job.mesh_id, nine, None)
        .await;
    assert!(matches!(refused, Err(Error::Refused(_))), "{refused:?}");
    let refused = service
        .submit(&Owner::ANONYMOUS, &"0".repeat(64), request(""), None)
        .await;
    assert!(matches!(refused, Err(Error::UnknownMesh)), "{refused:?}");
    assert_eq!(files_in(&data), 1);
    service.shutdown().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_lost_file_is_mended_by_the_same_upload() {
    let data = data();
    let service = start(options(&data)).await;
    let mesh = submit(&service, "quick").await.mesh_id;
    let file = data.path().join("meshes").join(&mesh);
    fs::remove_file(&file).unwrap();
    let again = upload(&service, TETRAHEDRON).await;
    let (again, created) = service
        .add_mesh(&Owner::ANONYMOUS, incoming(again, options_of(None), None))
        .await
        .unwrap();
    assert_eq!((again.id.as_str(), created), (mesh.as_str(), false));
    assert!(file.exists());
    fs::remove_file(&file).unwrap();
    assert_eq!(submit(&service, "quick").await.mesh_id, mesh);
    assert!(file.exists());
    service.shutdown().await;
}
