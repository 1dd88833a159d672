//! Rides whose clocks no logger has harm nobody beside them. And files of 10 MB made to do harm: each is refused in one line, within 200 MB of memory. What
//! they take is printed; `docs/security.md` has the figures:
//! `cargo test --workspace --test blackbox hostile:: -- --nocapture`

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::harness::{Folder, Server, VELOID};
use crate::{ride, workbook};

const SIZE: usize = 10 << 20;
/// Most memory (kB).
const MOST: u64 = 200 << 10;

/// Repeats a text up to the size.
fn filled(head: &[u8], body: &[u8]) -> Vec<u8> {
    let mut file = head.to_vec();
    while file.len() + body.len() <= SIZE {
        file.extend_from_slice(body);
    }
    file
}

/// A packed file of that size: a text, then `block` over and over.
fn gzip(head: &[u8], block: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(head).unwrap();
    // Members follow each other in a file as `cat` puts them.
    let first = packer.finish().unwrap();
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    for _ in 0..100 {
        packer.write_all(block).unwrap();
    }
    filled(&first, &packer.finish().unwrap())
}

/// A zstd frame that begins with a text and goes on with blocks that say "128 KiB of this byte" in four
/// bytes each: 327 GB.
fn zstd_bomb(window: u8, text: &[u8], byte: u8) -> Vec<u8> {
    // Magic; no checksum, no size; the window.
    let mut head = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, window];
    let block = |kind: u32, size: usize| ((size as u32) << 3 | kind << 1).to_le_bytes();
    head.extend(&block(0, text.len())[..3]);
    head.extend(text);
    let [a, b, c, _] = block(1, 128 << 10);
    filled(&head, &[a, b, c, byte])
}

/// A MATLAB file of these elements.
fn mat(elements: &[u8]) -> Vec<u8> {
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend(b"\x00\x01IM");
    file.extend(elements);
    file
}

fn element(kind: u32, size: u32, data: &[u8]) -> Vec<u8> {
    let mut element = [kind.to_le_bytes(), size.to_le_bytes()].concat();
    element.extend(data);
    element.resize(element.len().next_multiple_of(8), 0);
    element
}

/// An array of doubles that may say anything of its shape.
fn array(name: &str, shape: [u32; 2], data: &[u8]) -> Vec<u8> {
    let shape = [shape[0].to_le_bytes(), shape[1].to_le_bytes()].concat();
    let parts = [
        element(6, 8, &[6, 0, 0, 0, 0, 0, 0, 0]),
        element(5, 8, &shape),
        element(1, name.len() as u32, name.as_bytes()),
        element(9, data.len() as u32, data),
    ]
    .concat();
    element(14, parts.len() as u32, &parts)
}

/// A structure of 2^96 elements.
fn structure() -> Vec<u8> {
    let parts = [
        element(6, 8, &[2, 0, 0, 0, 0, 0, 0, 0]),
        element(5, 12, &[0xff; 12]),
        element(1, 1, b"s"),
        element(5, 4, &8_u32.to_le_bytes()),
        element(1, 8, b"z_f\0\0\0\0\0"),
    ]
    .concat();
    element(14, parts.len() as u32, &parts)
}

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(data).unwrap();
    packer.finish().unwrap()
}

/// What each file is, and the file.
fn rides() -> Vec<(&'static str, Vec<u8>)> {
    const TABLE: &[u8] = b"t,u_f,z_f\n0,0,0\n1,1,1\n";
    let empty = vec![b'\n'; 1 << 20];
    let numbers = b"1,2,3\n".repeat(1 << 17);
    let columns: String = (0..1_000_000).fold("t,u_f,z_f".to_owned(), |mut text, i| {
        let _ = write!(text, ",c{i}");
        text
    });
    let zeros = vec![0; 8 << 20];
    let nan = f64::NAN.to_le_bytes().repeat(SIZE / 16);
    let rows = (nan.len() / 8) as u32;
    // A matrix of 60 MB, and one that is longer than it says.
    let matrix = zlib(&element(14, 60 << 20, &vec![0; 60 << 20]));
    let matrix = element(15, matrix.len() as u32, &matrix);
    let bomb = zlib(&vec![0; 100 << 20]);
    let bomb = element(15, bomb.len() as u32, &bomb);
    vec![
        ("workbook of one text", workbook::one_text(60_000_000)),
        (
            "workbook of a trillion strings",
            workbook::promised_strings(1_000_000_000_000),
        ),
        ("workbook of long fonts", workbook::long_fonts(60_000)),
        ("gzip bomb", gzip(TABLE, &empty)),
        ("gzip bomb of numbers", gzip(TABLE, &numbers)),
        ("zstd bomb", zstd_bomb(0x38, TABLE, b'\n')),
        ("zstd bomb of one line", zstd_bomb(0x38, TABLE, b'1')),
        ("zstd window of 2 GB", zstd_bomb(0xa8, TABLE, b'\n')),
        ("one endless line", filled(b"t,u_f,z_f\n", b"1")),
        ("one endless row", filled(b"t,u_f,z_f\n", b"1,")),
        ("one endless header", filled(b"t", b",z_f")),
        ("a million columns", columns.into_bytes()),
        ("nothing but line ends", filled(TABLE, b"\n")),
        ("nothing but comments", filled(b"", b"#\n")),
        ("nothing but separators", filled(b"t,u_f,z_f\n", b",,\n")),
        ("all NaN", filled(b"t,u_f,z_f\n", b"NaN,NaN,NaN\n")),
        ("no time goes by", filled(b"t,u_f,z_f\n", b"0,0,1\n")),
        ("an open quote", filled(b"t,u_f,z_f\n\"", b"0,1\n")),
        ("UTF-16 of nothing", filled(b"\xff\xfe", b"\n\0")),
        (
            ".mat all NaN",
            mat(&[array("t", [rows, 1], &nan), array("z_f", [rows, 1], &nan)].concat()),
        ),
        (
            ".mat of impossible shape",
            mat(&array("z_f", [u32::MAX, u32::MAX], &zeros)),
        ),
        (
            ".mat of an impossible structure",
            filled(&mat(&[]), &structure()),
        ),
        (
            ".mat of a size beyond its end",
            mat(&element(14, u32::MAX, &zeros)),
        ),
        (
            ".mat of a million variables",
            filled(&mat(&[]), &array("v", [1, 1], &[0; 8])),
        ),
        (".mat of bombs", filled(&mat(&[]), &bomb)),
        (".mat of large matrices", filled(&mat(&[]), &matrix)),
        (
            ".mat of wide matrices",
            filled(&mat(&[]), &array("m", [1, 1024], &zeros[..8192])),
        ),
    ]
}

/// What each bike file is, and the file.
fn bikes() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("deep lists", filled(b"{\"a\":", b"[")),
        ("deep objects", filled(b"", b"{\"a\":")),
        (
            "a list of millions",
            [filled(b"{\"a\":[0", b",0"), b"]}".to_vec()].concat(),
        ),
        ("an endless name", filled(b"{\"bike\":\"", b"x")),
        ("an endless number", filled(b"{\"mass_front_kg\":1", b"0")),
    ]
}

/// Runs `veloid identify` to its end; what it says, the most memory it had (kB) and its CPU time.
fn refused(what: &str, ride: &Path, bike: &Path) -> (String, u64, Duration) {
    let mut child = Command::new(&*VELOID)
        .arg("identify")
        .arg(ride)
        .arg("--bike")
        .arg(bike)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let process = Path::new("/proc").join(child.id().to_string());
    // What the process had when it was last looked at; the marks only rise.
    let (mut memory, mut ticks) = (0, 0);
    let status = loop {
        let status = std::fs::read_to_string(process.join("status")).unwrap_or_default();
        let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        if let Some(mark) = mark {
            memory = mark.trim().trim_end_matches(" kB").parse().unwrap();
        }
        let stat = std::fs::read_to_string(process.join("stat")).unwrap_or_default();
        let fields: Vec<&str> = stat
            .rsplit(')')
            .next()
            .unwrap_or_default()
            .split(' ')
            .collect();
        if let (Some(user), Some(system)) = (fields.get(12), fields.get(13)) {
            ticks = user.parse::<u64>().unwrap() + system.parse::<u64>().unwrap();
        }
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(Duration::from_millis(1));
    };
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(status.code(), Some(2), "{what}: {message}");
    assert_eq!(message.lines().count(), 1, "{what}: {message}");
    assert!(
        message.len() < 1000,
        "{what}: a message of {} bytes",
        message.len()
    );
    // A tick is 10 ms on Linux.
    (message, memory, Duration::from_millis(10 * ticks))
}

#[test]
#[ignore = "slow"]
fn no_file_of_ten_megabytes_takes_two_hundred() {
    if !Path::new("/proc/self/status").exists() {
        return crate::skips::not_applicable("no /proc to read the memory of a process from");
    }
    let folder = Folder::new();
    let good = folder.write("bike.json", ride::BIKE);
    let hostile = rides().into_iter().map(|(what, file)| (what, "ride", file));
    let hostile = hostile.chain(bikes().into_iter().map(|(what, file)| (what, "bike", file)));
    for (what, part, file) in hostile {
        let size = file.len() as f64 / 1e6;
        let path = folder.write(part, file);
        let bike = if part == "bike" { &path } else { &good };
        // Who is refused at once may be gone before he is looked at, but not every time.
        let mut tries = (0..50).map(|_| refused(what, &path, bike));
        let seen = tries.find(|(_, memory, _)| *memory > 0);
        let (message, memory, time) = seen.unwrap_or_else(|| panic!("{what}: never seen"));
        eprintln!(
            "{what}: {size:.1} MB, {} MB, {time:?}: {}",
            memory >> 10,
            message.trim()
        );
        assert!(memory > 0 && memory <= MOST, "{what}: {memory} kB");
    }
}

/// A ride of 55 kB and such steps (s).
fn stepped(step_s: f64) -> Vec<u8> {
    let table = ride::table(800, 200.0);
    let mut lines = table.lines();
    let mut text = format!("{}\n", lines.next().unwrap());
    for (i, line) in lines.enumerate() {
        let (_, cells) = line.split_once(',').unwrap();
        let _ = writeln!(text, "{:e},{cells}", i as f64 * step_s);
    }
    text.into_bytes()
}

/// Steps of 1e-13 s once took a server down with all that it had to do, those of 1e-11 s kept threads that nothing
/// ended, those of 1e-20 s panicked.
#[tokio::test]
async fn a_clock_that_no_logger_has_harms_no_other_ride() {
    let mut server = Server::with(&["--workers", "1"]);
    let mut queued = Vec::new();
    for seed in ["1", "2", "3"] {
        queued.push(
            server
                .submit(&[&ride::QUICK[..], &[("seed", seed)]].concat())
                .await,
        );
    }
    for step_s in [1e-13, 1e-11, 1e-20, 5e-324, 1e-7, 1001.0, 3.2e7] {
        let response = server
            .upload(stepped(step_s), ride::BIKE, &ride::QUICK)
            .await;
        assert_eq!(response.status(), 422, "{step_s:e}");
        let problem: Value = response.json().await.unwrap();
        assert_eq!(
            problem["place"]["fault"], "rate-out-of-range",
            "{problem:#}"
        );
        assert_eq!(problem["place"]["column"], 1, "{problem:#}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains("0.001 Hz to 1000000 Hz"), "{detail}");
    }
    for job in queued {
        server.succeeded(&job).await;
    }
    assert!(server.is_there());
    assert_eq!(server.get("/readyz").await.status(), 200);
}
