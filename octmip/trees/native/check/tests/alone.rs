//! The checker depends on nothing: a solver could be used here only if the manifest named it.

#[test]
fn the_crate_has_no_dependency() {
    let manifest = include_str!("../Cargo.toml");
    let tables: Vec<&str> = manifest.lines().filter(|line| line.starts_with('[')).collect();
    assert_eq!(tables, ["[package]", "[lib]", "[[bin]]", "[dependencies]"]);
    let (_, dependencies) = manifest.split_once("[dependencies]").expect("the table is there");
    assert_eq!(dependencies.trim(), "");
    assert!(!manifest.contains("build ="));
}
