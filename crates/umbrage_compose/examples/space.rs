use umbrage_compose::*;
fn main() {
    let package = Package::load("umbrage", std::path::Path::new("shader_lib")).unwrap();
    let library = Library::new([package]).unwrap();
    let composer = Composer::new(library, Target::webgpu());
    let mut by_pass = std::collections::BTreeMap::new();
    let start = std::time::Instant::now();
    let mut n=0;
    println!("{}", composer.legal_keys());
    composer.for_each_variant(&mut |variant| {
        n+=1;
        if n % 20000 == 0 { eprintln!("{n} {:?} {}", start.elapsed(), variant.key); }
        assert!(variant.fault.is_none(), "{:?}", variant.fault);
        *by_pass.entry(variant.key.get("pass").unwrap_or("").to_owned()).or_insert(0) += 1;
    });
    println!("{by_pass:?} {} {:?}", by_pass.values().sum::<usize>(), start.elapsed());
}
