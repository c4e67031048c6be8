use std::path::PathBuf;

use rusqlite::Connection;

use super::*;

const PNG: &[u8] = b"\x89PNG\r\n\x1a\nred";

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("barrelman-map-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }

    fn mbtiles(&self, tiles: &[(u8, u32, u32, &[u8])]) -> PathBuf {
        let path = self.0.join("map.mbtiles");
        let _ = std::fs::remove_file(&path);
        let file = Connection::open(&path).unwrap();
        file.execute_batch(
            "CREATE TABLE metadata (name text, value text);
             CREATE TABLE tiles (zoom_level integer, tile_column integer, tile_row integer, tile_data blob);
             INSERT INTO metadata VALUES ('attribution', 'the harbour office');",
        )
        .unwrap();
        for tile in tiles {
            file.execute("INSERT INTO tiles VALUES (?1, ?2, ?3, ?4)", *tile).unwrap();
        }
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn tile(map: &Map, zoom: u8, x: u32, y: u32) -> Option<(&'static str, Vec<u8>)> {
    map.tile(TileAt::new(zoom, x, y)?).unwrap()
}

#[test]
fn a_folder_has_its_tiles_by_zoom_column_and_row_from_the_north() {
    let folder = Folder::new("folder");
    folder.put("17/5/9.png", PNG);
    folder.put("15/1/2.png", PNG);
    folder.put("notes/readme.txt", b"no tile");
    folder.put("18/1/notes.txt", b"no tile");
    let map = Map::open(&folder.0).unwrap();
    assert_eq!(map.about(), &About { min_zoom: 15, max_zoom: 17, attribution: None });
    assert_eq!(tile(&map, 17, 5, 9), Some(("image/png", PNG.to_vec())));
    for (zoom, x, y) in [(17, 9, 5), (16, 5, 9), (18, 1, 1), (2, 4, 0), (200, 0, 0)] {
        assert_eq!(tile(&map, zoom, x, y), None, "{zoom}/{x}/{y}");
    }
}

#[test]
fn an_mbtiles_file_counts_its_rows_from_the_south() {
    let folder = Folder::new("mbtiles");
    let path = folder.mbtiles(&[(3, 2, 1, PNG), (4, 0, 0, b"\xFF\xD8\xFFjpeg")]);
    let map = Map::open(&path).unwrap();
    let attribution = Some("the harbour office".to_owned());
    assert_eq!(map.about(), &About { min_zoom: 3, max_zoom: 4, attribution });
    assert_eq!(tile(&map, 3, 2, 6), Some(("image/png", PNG.to_vec())));
    assert_eq!(tile(&map, 3, 2, 1), None);
    assert_eq!(tile(&map, 4, 0, 15).map(|(kind, _)| kind), Some("image/jpeg"));
}

#[test]
fn what_is_no_map_is_refused_with_the_reason() {
    let folder = Folder::new("refused");
    folder.put("file", b"no database");
    let error = |path: &Path| format!("{:#}", Map::open(path).err().unwrap());
    assert!(error(&folder.0.join("missing")).contains("there is no map"));
    assert!(error(&folder.0.join("file")).contains("no MBTiles file"), "{}", error(&folder.0.join("file")));
    assert!(error(&folder.0).contains("17/69000/42000.png"), "{}", error(&folder.0));
    let vector = folder.mbtiles(&[(3, 2, 1, b"\x1f\x8bvector")]);
    assert!(error(&vector).contains("vector tiles"), "{}", error(&vector));
    let empty = folder.mbtiles(&[]);
    assert!(error(&empty).contains("no tile"), "{}", error(&empty));
    folder.put("3/1/1.png", b"\x1f\x8bvector");
    assert!(error(&folder.0).contains("vector tiles"), "{}", error(&folder.0));
}

#[test]
fn a_tile_that_is_too_large_or_no_picture_is_not_passed_on() {
    let folder = Folder::new("tiles");
    let large = [PNG, &vec![0; MAX_TILE_BYTES]].concat();
    let path = folder.mbtiles(&[(1, 0, 0, PNG), (1, 1, 0, &large), (1, 1, 1, b"<script>")]);
    let map = Map::open(&path).unwrap();
    assert!(tile(&map, 1, 0, 1).is_some());
    assert_eq!((tile(&map, 1, 1, 1), tile(&map, 1, 1, 0)), (None, None));
}
