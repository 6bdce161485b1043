//! RADV's figures, and what happens where it does not give them. Where RADV is missing these tests fail: it
//! comes with Mesa's Vulkan drivers, which rendering needs anyhow.
use umbrage_compose::*;
use umbrage_isa::*;

#[test]
fn server() {
    umbrage_isa::serve_if_asked();
}

fn options() -> CompilerOptions {
    CompilerOptions {
        args: ["--exact", "server", "--nocapture"]
            .map(Into::into)
            .to_vec(),
        ..Default::default()
    }
}

#[test]
fn try_it() {
    let m = Manifest::load(std::path::Path::new("../../permutations/all.ron")).unwrap();
    let c = Composer::new(m.library().clone(), Target::webgpu());
    let keys: std::collections::BTreeSet<_> =
        m.keys().iter().map(|k| c.project(k).unwrap()).collect();
    let ps: Vec<_> = keys
        .iter()
        .map(|k| c.compose(k).unwrap().permutation)
        .collect();
    let items: Vec<_> = ps.iter().map(|p| (&**p, PipelineState::plain(p))).collect();
    let t = std::time::Instant::now();
    let r = costs(&options(), &items, &|| ()).unwrap();
    eprintln!("{} in {:?}", r.len(), t.elapsed());
    for (p, r) in ps.iter().zip(r) {
        for s in r.unwrap() {
            let i = s.isa;
            eprintln!(
                "{} {:?} {} v{} s{} {}B {} {} spill {} {} lds {} scr {} w {}",
                p.key,
                s.stage,
                i.instructions,
                i.vgprs,
                i.sgprs,
                i.code_size,
                i.latency,
                i.inverse_throughput,
                i.spilled_vgprs,
                i.spilled_sgprs,
                i.lds_size,
                i.scratch_size,
                i.waves_per_simd
            );
        }
    }
}
