//! include/volgrad.h is what cbindgen makes of src/ffi. `UPDATE_HEADER=1 cargo test --features ffi,exr --test header` writes it.

use std::{env, fs, path::Path};

#[test]
fn header_is_up_to_date() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("cbindgen.toml is valid");
    let bindings = cbindgen::Builder::new().with_crate(root).with_config(config).generate().expect("src/ffi parses");
    let mut text = Vec::new();
    bindings.write(&mut text);
    let text = String::from_utf8(text).expect("the header is UTF-8");
    // Without a suffix they would be signed 64-bit numbers, which C++ does not like to see narrowed.
    let text = ["4294967295", "4294967294"].iter().fold(text, |text, n| text.replace(n, &format!("UINT32_C({n})")));
    let file = root.join("include/volgrad.h");
    if env::var_os("UPDATE_HEADER").is_some() {
        fs::write(&file, &text).expect("include/volgrad.h can be written");
    }
    let stored = fs::read_to_string(&file).expect("include/volgrad.h exists");
    assert!(stored == text, "include/volgrad.h is stale: run with UPDATE_HEADER=1, and review the difference");
    let foreign = |line: &&str| {
        let name = line.strip_prefix("typedef struct ").or(line.strip_prefix("#define "));
        name.is_some_and(|name| !name.starts_with("volgrad_") && !name.starts_with("VOLGRAD_"))
    };
    assert_eq!(text.lines().find(foreign), None, "not volgrad's name: exclude it in cbindgen.toml");
}
