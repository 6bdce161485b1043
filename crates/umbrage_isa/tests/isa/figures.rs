//! Meaning of the figures.

use umbrage_compose::Stage;
use umbrage_isa::{ColorTarget, Isa, PipelineState, costs};

use super::{compiler, cost, of_module, options, permutation};

const WIDTHS: [&str; 5] = ["1", "3", "5", "7", "9"];

fn sun_term(pcf: &str) -> [(&str, &str); 3] {
    [("pass", "shadow_term"), ("method", "basic"), ("pcf", pcf)]
}

#[test]
fn the_same_again() {
    let permutations = WIDTHS.map(|pcf| permutation(&sun_term(pcf)));
    let jobs = permutations
        .each_ref()
        .map(|p| (&**p, PipelineState::of(p)));
    let batch = costs(&options("navi21", "server"), &jobs, &|| ()).expect("figures");
    let mut compiler = compiler("NAVI21");
    for (permutation, batch) in permutations.iter().zip(batch) {
        let batch = batch.expect("figures");
        // In another process, and there after others and twice.
        assert_eq!(cost(&mut compiler, permutation), batch);
        assert_eq!(cost(&mut compiler, permutation), batch);
        let stages: Vec<_> = batch.iter().map(|cost| cost.stage).collect();
        assert_eq!(stages, [Stage::Vertex, Stage::Fragment]);
        assert_eq!(batch[1].entry_point, "fs_shadow_term");
        assert_eq!(batch[1].isa.family, "navi21");
    }
}

#[test]
fn a_wider_filter_costs_more() {
    let mut compiler = compiler("navi21");
    // Up to nine texels its loop is unrolled.
    let fragments = WIDTHS.map(|pcf| cost(&mut compiler, &permutation(&sun_term(pcf)))[1].clone());
    for pair in fragments.windows(2) {
        let (narrow, wide) = (&pair[0].isa, &pair[1].isa);
        assert!(wide.instructions > narrow.instructions, "{pair:?}");
        assert!(wide.code_size > narrow.code_size, "{pair:?}");
        assert!(
            wide.inverse_throughput > narrow.inverse_throughput,
            "{pair:?}"
        );
    }
}

#[test]
fn what_does_nothing_costs_next_to_nothing() {
    let mut compiler = compiler("navi21");
    let idle = cost(&mut compiler, &permutation(&[("pass", "shadow_term")]));
    let busy = cost(&mut compiler, &permutation(&sun_term("1")));
    // A constant into a register, its export, and the end.
    assert_eq!(idle[1].isa.instructions, 3, "{idle:?}");
    assert!(busy[1].isa.instructions > 20 * idle[1].isa.instructions);
    assert!(busy[1].isa.latency > idle[1].isa.latency);
    assert_eq!(idle[1].room.spilled_vgprs + idle[1].room.scratch_size, 0);
    assert!(idle[1].room.waves_per_simd >= busy[1].room.waves_per_simd);
}

#[test]
fn stages_are_those_of_the_pipeline() {
    let mut compiler = compiler("navi21");
    let stages = |choices: &[(&str, &str)], compiler: &mut _| {
        let costs = cost(compiler, &permutation(choices));
        costs.iter().map(|cost| cost.stage).collect::<Vec<_>>()
    };
    let solid = [("pass", "caster")];
    assert_eq!(stages(&solid, &mut compiler), [Stage::Vertex]);
    let holed = [("pass", "caster"), ("alpha_test", "on")];
    assert_eq!(
        stages(&holed, &mut compiler),
        [Stage::Vertex, Stage::Fragment]
    );
}

#[test]
fn every_kind_of_binding() {
    let mut compiler = compiler("navi21");
    for light in ["directional", "spot", "point"] {
        for cookie in ["off", "on"] {
            if (light, cookie) != ("spot", "on") && cookie == "on" {
                continue;
            }
            let choices = [
                ("pass", "illumination"),
                ("light", light),
                ("method", "basic"),
                ("cookie", cookie),
                ("surface", "ggx"),
                ("base_color_texture", "on"),
            ];
            let costs = cost(&mut compiler, &permutation(&choices));
            assert!(costs[1].isa.instructions > 100, "{choices:?} {costs:?}");
        }
    }
}

#[test]
fn compute_stages_have_figures() {
    let text = "
        var<workgroup> shared_sums: array<f32, 64>;
        @group(0) @binding(0) var<storage, read> numbers: array<f32>;
        @group(0) @binding(1) var<storage, read_write> sums: array<f32>;
        @group(0) @binding(2) var picture: texture_storage_2d<r32float, write>;
        @compute @workgroup_size(64)
        fn cs_sum(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
            shared_sums[lane] = numbers[id.x];
            workgroupBarrier();
            sums[id.x] = shared_sums[lane] + shared_sums[63u - lane];
            textureStore(picture, id.xy, vec4f(sums[id.x]));
        }
        @compute @workgroup_size(1)
        fn cs_clear(@builtin(global_invocation_id) id: vec3u) { sums[id.x] = 0.0; }
    ";
    let costs = cost(&mut compiler("navi21"), &of_module(text));
    let names: Vec<_> = costs.iter().map(|c| (c.stage, &*c.entry_point)).collect();
    assert_eq!(
        names,
        [(Stage::Compute, "cs_sum"), (Stage::Compute, "cs_clear")]
    );
    // 64 floats, and RADV's grain of 512 bytes.
    assert_eq!(costs[0].room.lds_size, 512);
    assert_eq!(costs[1].room.lds_size, 0);
    assert!(costs[0].isa.instructions > costs[1].isa.instructions);
}

#[test]
fn families_differ() {
    let shader = permutation(&sun_term("3"));
    let fragment = |family: &str| cost(&mut compiler(family), &shader)[1].isa.clone();
    let (rdna2, vega) = (fragment("navi21"), fragment("vega10"));
    assert_eq!(vega.family, "vega10");
    // Waves of 64 where RDNA has 32, and half as much done at a time.
    assert_ne!(rdna2.sgprs, vega.sgprs);
    assert!(vega.inverse_throughput > rdna2.inverse_throughput);
}

/// Claims of the crate page about branches and loops.
#[test]
fn loops_are_counted_once_and_timed_by_a_guess() {
    let mut compiler = compiler("navi21");
    let mut measure = |opening: &str, closing: &str| {
        let text = format!(
            "@group(0) @binding(0) var<storage, read_write> numbers: array<f32>;
            @group(0) @binding(1) var<uniform> count: u32;
            @compute @workgroup_size(64)
            fn cs_own(@builtin(global_invocation_id) id: vec3u) {{
                var x = numbers[id.x];
                {opening}
                x = sin(x) * sin(x + 1.0) + sqrt(abs(x)) + exp2(x) * log2(abs(x) + 2.0);
                x = sin(x) * sin(x + 1.0) + sqrt(abs(x)) + exp2(x) * log2(abs(x) + 2.0);
                x = sin(x) * sin(x + 1.0) + sqrt(abs(x)) + exp2(x) * log2(abs(x) + 2.0);
                x = sin(x) * sin(x + 1.0) + sqrt(abs(x)) + exp2(x) * log2(abs(x) + 2.0);
                {closing}
                numbers[id.x] = x;
            }}"
        );
        cost(&mut compiler, &of_module(&text)).remove(0).isa
    };
    let once = measure("", "");
    let looped = measure("for (var i = 0u; i < count; i++) {", "}");
    let branched = measure("if count > 3u {", "}");
    assert!(
        branched.inverse_throughput < once.inverse_throughput,
        "{branched:?}"
    );
    let nested = measure(
        "for (var i = 0u; i < count; i++) { for (var j = 0u; j < count; j++) {",
        "}}",
    );
    assert!(nested.instructions < 2 * once.instructions, "{nested:?}");
    let times =
        |more: &Isa, less: &Isa| more.inverse_throughput as f64 / less.inverse_throughput as f64;
    assert!(
        (6.0..10.0).contains(&times(&looped, &once)),
        "{looped:?} {once:?}"
    );
    assert!(
        (3.0..10.0).contains(&times(&nested, &looped)),
        "{nested:?} {looped:?}"
    );
    let mut point = |pcf| {
        let choices = [
            ("light", "point"),
            ("pass", "shadow_term"),
            ("method", "basic"),
            ("pcf", pcf),
        ];
        cost(&mut compiler, &permutation(&choices)).remove(1).isa
    };
    assert_eq!(point("11"), point("15"));
}

#[test]
fn targets_matter_and_what_becomes_of_the_output_does_not() {
    let mut compiler = compiler("navi21");
    let choices = [("pass", "illumination"), ("method", "basic")];
    let sun = permutation(&choices);
    let mut fragment = |state: &PipelineState| {
        let costs = compiler.cost(&sun, state).expect("figures");
        costs[1].isa.clone()
    };
    let added = PipelineState::of(&sun);
    let plain = PipelineState::plain(&sun);
    assert_ne!(added, plain);
    assert_eq!(fragment(&added), fragment(&plain));
    let culled = PipelineState {
        cull: Some(wgpu_types::Face::Back),
        ..plain.clone()
    };
    assert_eq!(fragment(&culled), fragment(&plain));
    let wide = PipelineState {
        colors: plain
            .colors
            .iter()
            .map(|target| {
                target.map(|target| ColorTarget {
                    format: wgpu_types::TextureFormat::Rgba32Float,
                    ..target
                })
            })
            .collect(),
        ..plain.clone()
    };
    assert_ne!(fragment(&wide), fragment(&plain));
    let nowhere = PipelineState {
        colors: vec![None],
        ..plain
    };
    assert!(fragment(&nowhere).instructions < 5);
}
