//! A renderer puts the numbers of a plan where the shader reads them, or says why it cannot.

mod common;

use common::probe::{number, probing, refusal, texture};
use glam::{Mat4, Vec2, Vec3, Vec4};
use umbrage_shadow::{
    BufferContents, BufferDesc, Constants, Contents, ShadowPlan, TextureShape, Value,
};
use wgpu::TextureFormat;

/// Each number in turn, from `first`: a plan's values are all different, so that none stands in for
/// another.
struct Numbers(f32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 += 1.0;
        self.0 - 1.0
    }
    fn vec2(&mut self) -> Value {
        Value::Vec2(Vec2::from_array([(); 2].map(|()| self.next())))
    }
    fn vec3(&mut self) -> Value {
        Value::Vec3(Vec3::from_array([(); 3].map(|()| self.next())))
    }
    fn vec4(&mut self) -> Value {
        Value::Vec4(Vec4::from_array([(); 4].map(|()| self.next())))
    }
    fn mat4(&mut self) -> Value {
        Value::Mat4(Mat4::from_cols_array(&[(); 16].map(|()| self.next())))
    }
    fn array(&mut self, count: usize, element: fn(&mut Self) -> Value) -> Value {
        Value::Array((0..count).map(|_| element(self)).collect())
    }
    fn split(&mut self) -> Value {
        let members = Constants::new()
            .with("far", Value::F32(self.next()))
            .with("offset", self.vec3())
            .with("scales", self.array(3, Self::vec2))
            .with("matrix", self.mat4());
        Value::Struct(members)
    }
}

/// Every way in which numbers reach a shader. The device's own layout is the oracle: the shader reads
/// element by element, and counts those that are not the ones that were written.
const LAYOUTS: &str = r#"
struct Split {
    far: f32,
    offset: vec3f,
    scales: array<vec2f, 3>,
    matrix: mat4x4f,
}
struct Padded {
    far: f32,
    offset: vec3f,
    scales: array<vec4f, 3>,
    matrix: mat4x4f,
}
struct Block {
    first: f32,
    places: array<vec4f, 3>,
    matrices: array<mat4x4f, 2>,
    splits: array<Padded, 2>,
    last: vec2f,
}
struct Counted {
    count: u32,
    points: array<vec3f>,
}
@group(1) @binding(0) var<uniform> block: Block;
@group(1) @binding(1) var<storage, read> matrices: array<mat4x4f>;
@group(1) @binding(2) var<storage, read> splits: array<Split>;
@group(1) @binding(3) var<storage, read> counted: Counted;
@group(1) @binding(4) var<storage, read> fixed: array<vec3f, 2>;
@group(1) @binding(5) var matrix_texture: texture_2d<f32>;

var<private> expected: f32;
var<private> wrong: f32;

fn one(value: f32) {
    wrong += f32(value != expected);
    expected += 1.0;
}
fn two(value: vec2f) {
    one(value.x);
    one(value.y);
}
fn three(value: vec3f) {
    two(value.xy);
    one(value.z);
}
fn four(value: vec4f) {
    three(value.xyz);
    one(value.w);
}
fn sixteen(value: mat4x4f) {
    for (var column = 0; column < 4; column++) {
        four(value[column]);
    }
}

fn calc_shadow(position_ws: vec3f) -> f32 {
    expected = 1.0;
    one(block.first);
    for (var i = 0; i < 3; i++) {
        four(block.places[i]);
    }
    for (var i = 0; i < 2; i++) {
        sixteen(block.matrices[i]);
    }
    for (var i = 0; i < 2; i++) {
        one(block.splits[i].far);
        three(block.splits[i].offset);
        for (var j = 0; j < 3; j++) {
            four(block.splits[i].scales[j]);
        }
        sixteen(block.splits[i].matrix);
    }
    two(block.last);
    wrong += 1000.0 * f32(arrayLength(&matrices) != 3);
    for (var i = 0; i < 3; i++) {
        sixteen(matrices[i]);
    }
    wrong += 1000.0 * f32(arrayLength(&splits) != 2);
    for (var i = 0; i < 2; i++) {
        one(splits[i].far);
        three(splits[i].offset);
        for (var j = 0; j < 3; j++) {
            two(splits[i].scales[j]);
        }
        sixteen(splits[i].matrix);
    }
    one(f32(counted.count));
    wrong += 1000.0 * f32(arrayLength(&counted.points) != 2);
    for (var i = 0; i < 2; i++) {
        three(counted.points[i]);
    }
    for (var i = 0; i < 2; i++) {
        three(fixed[i]);
    }
    for (var y = 0; y < 2; y++) {
        for (var x = 0; x < 3; x++) {
            four(textureLoad(matrix_texture, vec2i(x, y), 0));
        }
    }
    return wrong;
}
"#;

/// How many numbers the shader reads.
const COUNTED: f32 = 1.0 + 12.0 + 32.0 + 64.0 + 2.0 + 48.0 + 52.0 + 1.0 + 6.0 + 6.0 + 24.0;

fn layouts(first: f32) -> ShadowPlan {
    let mut n = Numbers(first);
    let padded = |n: &mut Numbers| {
        let members = Constants::new()
            .with("far", Value::F32(n.next()))
            .with("offset", n.vec3())
            .with("scales", n.array(3, Numbers::vec4))
            .with("matrix", n.mat4());
        Value::Struct(members)
    };
    let constants = Constants::new()
        .with("first", Value::F32(n.next()))
        .with("places", n.array(3, Numbers::vec4))
        .with("matrices", n.array(2, Numbers::mat4))
        .with("splits", n.array(2, padded))
        .with("last", n.vec2());
    let buffer = |name: &str, value| BufferDesc {
        name: name.to_owned(),
        contents: BufferContents::Value(value),
    };
    let buffers = vec![
        buffer("matrices", n.array(3, Numbers::mat4)),
        buffer("splits", n.array(2, Numbers::split)),
        buffer("counted", {
            let members = Constants::new().with("count", Value::U32(n.next() as u32));
            Value::Struct(members.with("points", n.array(2, Numbers::vec3)))
        }),
        buffer("fixed", n.array(2, Numbers::vec3)),
    ];
    let texels: Vec<u8> = (0..24).flat_map(|_| n.next().to_le_bytes()).collect();
    ShadowPlan {
        textures: vec![texture("matrix_texture", TextureFormat::Rgba32Float, 3, 2)],
        contents: vec![Contents {
            texture: "matrix_texture".to_owned(),
            bytes: texels,
        }],
        buffers,
        constants,
        ..ShadowPlan::default()
    }
}

#[test]
fn numbers_reach_the_shader_wherever_they_lie() {
    let mut renderer = probing(LAYOUTS, |frame| {
        layouts(1.0 + frame.settings.get("which") as f32)
    });
    assert_eq!(number(&mut renderer, 0.0), 0.0);
    // A shader that compared nothing would say so here; and what was uploaded is not kept.
    assert_eq!(number(&mut renderer, 7.0), COUNTED);
    assert_eq!(number(&mut renderer, 0.0), 0.0);
}

#[test]
fn values_that_do_not_fit_are_named() {
    type Spoil = fn(&mut ShadowPlan);
    fn array<'a>(plan: &'a mut ShadowPlan, buffer: &str) -> &'a mut Vec<Value> {
        let found = plan.buffers.iter_mut().find(|b| b.name == buffer);
        match found.map(|found| &mut found.contents) {
            Some(BufferContents::Value(Value::Array(values))) => values,
            _ => unreachable!("`{buffer}` is an array"),
        }
    }
    fn member(plan: &mut ShadowPlan, name: &str, change: fn(&mut Vec<Value>)) {
        let Some(Value::Array(values)) = plan.constants.get(name) else {
            unreachable!("`{name}` is an array")
        };
        let mut values = values.clone();
        change(&mut values);
        // The first of a name counts.
        let mut constants = Constants::new().with(name, Value::Array(values));
        for other in ["first", "places", "matrices", "splits", "last"] {
            if let Some(value) = plan.constants.get(other) {
                constants = constants.with(other, value.clone());
            }
        }
        plan.constants = constants;
    }
    let cases: [(Spoil, &str); 15] = [
        (
            |plan| array(plan, "matrices").clear(),
            "`matrices` of probe::probe: the shader's `matrices` is array<mat4x4f> of one element at \
             the least, but the value given for it has 0 elements",
        ),
        (
            |plan| array(plan, "fixed").truncate(1),
            "`fixed` is array<vec3<f32>, 2>, but the value given for it has 1 elements",
        ),
        (
            |plan| array(plan, "matrices")[1] = Value::F32(1.0),
            "`matrices[1]` is mat4x4f, but the value given for it is F32(1.0)",
        ),
        (
            |plan| array(plan, "matrices")[2] = Value::Mat4(Mat4::NAN),
            "`matrices[2]` is not finite",
        ),
        (
            |plan| array(plan, "splits")[1] = Value::Struct(Constants::new()),
            "reads `splits[1].far`, but no value is given for it",
        ),
        (
            |plan| plan.buffers.retain(|buffer| buffer.name != "splits"),
            "`splits` of probe::probe: the shader reads it, but it is none of what its light and \
             shadow method give",
        ),
        (
            |plan| plan.buffers[0].contents = BufferContents::Value(Value::F32(1.0)),
            "`matrices` is array<mat4x4f> of one element at the least, but the value given for it is",
        ),
        (
            |plan| member(plan, "places", |places| places.push(places[0].clone())),
            "`places` is array<vec4<f32>, 3>, but the value given for it has 4 elements",
        ),
        (
            |plan| member(plan, "places", |places| places.truncate(2)),
            "`places` is array<vec4<f32>, 3>, but the value given for it has 2 elements",
        ),
        (
            |plan| member(plan, "splits", |splits| splits[0] = Value::U32(0)),
            "`splits[0]` is a struct, but the value given for it is U32(0)",
        ),
        (
            |plan| plan.contents[0].texture = "matrix".to_owned(),
            "light `lights[0]`: method `probe` plans what cannot be done: contents for `matrix`, which is none of its \
             textures; this is a fault of the method: mend it, or choose another",
        ),
        (
            |plan| plan.contents[0].bytes.truncate(95),
            "95 bytes for `matrix_texture`, whose 3 by 2 texels of Rgba32Float take 96",
        ),
        (
            |plan| plan.contents.push(plan.contents[0].clone()),
            "contents for `matrix_texture` twice",
        ),
        (
            |plan| plan.textures[0].format = TextureFormat::Depth32Float,
            "whose format Depth32Float cannot be filled texel by texel",
        ),
        (
            |plan| plan.textures[0].shape = TextureShape::Cube,
            "contents for `matrix_texture`, which is not one rectangle",
        ),
    ];
    for (spoil, expected) in cases {
        let mut renderer = probing(LAYOUTS, move |_| {
            let mut plan = layouts(1.0);
            spoil(&mut plan);
            plan
        });
        let message = refusal(&mut renderer);
        assert!(message.contains(expected), "{message}\nlacks: {expected}");
    }
}
