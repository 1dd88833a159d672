#![allow(clippy::unwrap_used)]
use super::*;

async fn keeps_abc(files: &Files) {
    let mut incoming = files.begin().await.unwrap();
    incoming.write(b"ab").await.unwrap();
    incoming.write(b"c").await.unwrap();
    let path = incoming.path().await.unwrap();
    assert_eq!(std::fs::read(path).unwrap(), b"abc");
    let kept = files.keep(incoming).await.unwrap();
    assert_eq!(
        kept.sha256,
        "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    );
    assert_eq!(kept.bytes, 3);
    let lies = files.on_disk(&kept.sha256).await.unwrap();
    assert_eq!(std::fs::read(lies.path()).unwrap(), b"abc");
    drop(lies);
    let chunks = files.stream(&kept.sha256).await.unwrap();
    let chunks: Vec<Bytes> = chunks.try_collect().await.unwrap();
    assert_eq!(chunks.concat(), b"abc");
    drop(files.begin().await.unwrap());
    let left = std::fs::read_dir(&files.incoming).unwrap().count();
    assert_eq!(left, 0, "what is kept or abandoned is no longer on its way");
    let missing = files.on_disk("0").await.map(drop).unwrap_err();
    assert!(matches!(missing, FileError::Missing(name) if name == "0"));
    assert_eq!(files.verify(&kept.sha256).await.unwrap(), 3);
}

#[tokio::test]
async fn a_file_is_there_until_it_is_removed_and_an_old_one_is_listed() {
    let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
    let files = Files::in_folder(&root).await.unwrap();
    keeps_abc(&files).await;
    std::fs::write(root.join("rides/README"), "no raw file").unwrap();
    let listed = async |time| -> Vec<String> { files.kept_for(time).try_collect().await.unwrap() };
    let [abc] = &listed(Duration::ZERO).await[..] else {
        panic!("one raw file");
    };
    assert!(listed(Duration::from_secs(3600)).await.is_empty());
    assert!(files.has(abc).await.unwrap());
    assert!(files.remove(abc).await.unwrap());
    assert!(!files.has(abc).await.unwrap() && !files.remove(abc).await.unwrap());
    std::fs::remove_dir_all(root).unwrap();
}

#[tokio::test]
async fn a_kept_file_is_found_by_its_hash_and_an_abandoned_one_is_gone() {
    let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
    let shared = Url::from_file_path(root.join("shared")).unwrap();
    keeps_abc(&Files::in_folder(&root).await.unwrap()).await;
    keeps_abc(&Files::at(&shared, &root).await.unwrap()).await;
    assert_eq!(
        std::fs::read_dir(root.join("shared/rides"))
            .unwrap()
            .count(),
        1
    );
    if cfg!(feature = "s3") {
        let memory = "memory:///".parse().unwrap();
        keeps_abc(&Files::at(&memory, &root).await.unwrap()).await;
    }
    std::fs::remove_dir_all(root).unwrap();
}

#[tokio::test]
async fn altered_bytes_are_not_given_out() {
    let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
    let files = Files::in_folder(&root).await.unwrap();
    let mut incoming = files.begin().await.unwrap();
    incoming.write(b"abc").await.unwrap();
    let kept = files.keep(incoming).await.unwrap();
    std::fs::write(root.join("rides").join(&kept.sha256), "abd").unwrap();
    for fault in [
        files.on_disk(&kept.sha256).await.map(drop).unwrap_err(),
        files.verify(&kept.sha256).await.map(drop).unwrap_err(),
    ] {
        assert!(matches!(fault, FileError::Altered { .. }), "{fault}");
    }
    std::fs::remove_dir_all(root).unwrap();
}

#[tokio::test]
async fn what_arrives_is_left_and_what_a_dead_process_left_goes() {
    let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
    let files = Files::in_folder(&root).await.unwrap();
    let arriving = files.begin().await.unwrap();
    let left = files.incoming.join("left");
    let long_ago = std::time::SystemTime::now() - 2 * BEGUN;
    for path in [&left, &arriving.path] {
        let file = std::fs::File::options()
            .create(true)
            .append(true)
            .open(path);
        file.unwrap().set_modified(long_ago).unwrap();
    }
    assert_eq!(files.clear().await.unwrap(), 1);
    assert!(arriving.path.exists() && !left.exists());
    std::fs::remove_dir_all(root).unwrap();
}

#[cfg(feature = "s3")]
#[tokio::test]
async fn a_file_larger_than_one_part_comes_back_whole() {
    let root = std::env::temp_dir().join(format!("veloid-files-{}", Uuid::now_v7()));
    let memory = "memory:///".parse().unwrap();
    let files = Files::at(&memory, &root).await.unwrap();
    let mut incoming = files.begin().await.unwrap();
    let block: Vec<u8> = (0..1 << 20).map(|i: u32| i.to_le_bytes()[1]).collect();
    for _ in 0..25 {
        incoming.write(&block).await.unwrap();
    }
    let kept = files.keep(incoming).await.unwrap();
    let copy = files.on_disk(&kept.sha256).await.unwrap();
    let bytes = std::fs::read(copy.path()).unwrap();
    assert_eq!(hex(&Sha256::digest(bytes)), kept.sha256);
    drop(copy);
    let left = std::fs::read_dir(&files.incoming).unwrap().count();
    assert_eq!(left, 0, "a copy goes with its reader");
    std::fs::remove_dir_all(root).unwrap();
}
