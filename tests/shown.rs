//! Messages about what is missing or in another unit.

use serde_json::Value;

use crate::harness::{Folder, Server, veloid};
use crate::ride;

/// What the command line says of a ride that it refuses.
fn refused(folder: &Folder, name: &str, bytes: impl AsRef<[u8]>) -> String {
    let path = folder.write(name, bytes);
    let bike = folder.write("bike.json", ride::BIKE);
    let [path, bike] = [path, bike].map(|path| path.to_str().unwrap().to_owned());
    let output = veloid(&["identify", &path, "--bike", &bike]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn missing_channels_come_with_the_option_that_maps_them() {
    let folder = Folder::new();
    let with_header = |header: &str| {
        let table = ride::table(400, 200.0);
        format!("{header}\n{}", table.split_once('\n').unwrap().1)
    };
    let said = refused(&folder, "none.csv", with_header("number,u_f,u_r,z_f,z_r"));
    assert!(said.contains("--map t=COLUMN"), "{said}");
    let named = with_header("t,u_f,u_r,Weg vorne,Weg hinten");
    let said = refused(&folder, "ways.csv", named.clone());
    let maps = ["z_f=Weg vorne", "z_r=Weg hinten"];
    assert!(
        maps.iter()
            .all(|map| said.contains(&format!("--map '{map}'"))),
        "{said}"
    );
    // What is offered works.
    let ways = folder.write("ways.csv", named);
    let bike = folder.0.join("bike.json");
    let read = veloid(&[
        "identify",
        ways.to_str().unwrap(),
        "--bike",
        bike.to_str().unwrap(),
        "--map",
        maps[0],
        "--map",
        maps[1],
        "--trials",
        "1",
        "--no-diagnosis",
    ]);
    assert!(read.status.success(), "{read:?}");
}

#[test]
fn files_of_other_programs_come_with_whole_advice() {
    let folder = Folder::new();
    let hdf5 = refused(&folder, "ride.h5", b"\x89HDF\r\n\x1a\n\0\0\0\0\0\x08\x08\0");
    assert!(
        hdf5.contains("HDF5 file that MATLAB did not write"),
        "{hdf5}"
    );
    assert!(hdf5.contains("CSV") && !hdf5.contains("damaged"), "{hdf5}");

    // A table in a .mat file: an array of class 17 with its name.
    let mut mat = format!("{:<124}", "MATLAB 5.0 MAT-file").into_bytes();
    mat.extend(*b"\0\x01IM");
    let element = |kind: u32, data: &[u8]| {
        let mut bytes = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    };
    let flags = element(6, &[17, 0, 0, 0, 0, 0, 0, 0]);
    let name = element(1, b"recorded");
    mat.extend(element(14, &[flags, name].concat()));
    let said = refused(&folder, "ride.mat", mat);
    assert!(
        said.contains("recorded") && said.contains("save table2struct(T, 'ToScalar', true)"),
        "{said}"
    );
}

#[tokio::test]
async fn a_wheelbase_in_millimetres_is_named_as_such() {
    let server = Server::start();
    let form = reqwest::multipart::Form::new()
        .text("bike_name", "lab-7")
        .text("mass_front_kg", "23")
        .text("mass_rear_kg", "63")
        .text("wheelbase_m", "1101")
        .part(
            "file",
            reqwest::multipart::Part::bytes(ride::example()).file_name("ride.csv"),
        );
    let address = server.address("/v1/rides");
    let answer = server.client.post(address).multipart(form).send();
    let answer = answer.await.unwrap();
    assert_eq!(answer.status(), 422);
    let problem: Value = answer.json().await.unwrap();
    let said = problem.to_string();
    let expected = "wheelbase_m is 1101.0, expected 0.02 to 10: in millimetres";
    assert!(said.contains(expected), "{said}");
}

#[tokio::test]
async fn times_have_three_digits_and_the_effects_page_no_markdown() {
    let server = Server::start();
    let mut times = Vec::new();
    // One time in ten ends with a zero.
    for _ in 0..30 {
        let job = server.submit(&[("again", "true"), ("trials", "1"), ("diagnosis", "false")]);
        let view = server.json(&job.await).await;
        times.push(view["created_at"].as_str().unwrap().to_owned());
    }
    assert!(
        times
            .iter()
            .all(|time| time.len() == "2026-11-27T12:00:00.250Z".len()),
        "{times:?}"
    );
    assert!(times.is_sorted(), "{times:?}");

    let page = server.get("/effects").await.text().await.unwrap();
    assert!(!page.contains('`') && page.contains("<code>tyre + "));
}
