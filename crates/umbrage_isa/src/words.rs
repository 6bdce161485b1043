//! wgpu's words in Vulkan's numbers.

use ash::vk;
use umbrage_compose::{BindingKind, Scalar, Stage, VertexInput};
use wgpu_types::{
    BlendComponent, BlendFactor, BlendOperation, CompareFunction, Face, FrontFace, TextureFormat,
};

pub(crate) fn stage(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::Fragment => vk::ShaderStageFlags::FRAGMENT,
        Stage::Compute => vk::ShaderStageFlags::COMPUTE,
    }
}

pub(crate) fn descriptor(kind: &BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::Uniform(_) => vk::DescriptorType::UNIFORM_BUFFER,
        BindingKind::Storage { .. } => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::Texture { .. } => vk::DescriptorType::SAMPLED_IMAGE,
        BindingKind::StorageTexture { .. } => vk::DescriptorType::STORAGE_IMAGE,
        BindingKind::Sampler { .. } => vk::DescriptorType::SAMPLER,
    }
}

/// The format of an attribute, and its bytes; none for what is no attribute.
pub(crate) fn attribute(input: &VertexInput) -> Option<(vk::Format, u32)> {
    use vk::Format as F;
    let formats = match input.scalar {
        Scalar::F32 => [
            F::R32_SFLOAT,
            F::R32G32_SFLOAT,
            F::R32G32B32_SFLOAT,
            F::R32G32B32A32_SFLOAT,
        ],
        Scalar::I32 => [
            F::R32_SINT,
            F::R32G32_SINT,
            F::R32G32B32_SINT,
            F::R32G32B32A32_SINT,
        ],
        Scalar::U32 => [
            F::R32_UINT,
            F::R32G32_UINT,
            F::R32G32B32_UINT,
            F::R32G32B32A32_UINT,
        ],
        Scalar::F16 => [
            F::R16_SFLOAT,
            F::R16G16_SFLOAT,
            F::UNDEFINED,
            F::R16G16B16A16_SFLOAT,
        ],
    };
    let format = *formats.get(usize::try_from(input.components).ok()?.checked_sub(1)?)?;
    let bytes = if input.scalar == Scalar::F16 { 2 } else { 4 };
    (format != F::UNDEFINED).then_some((format, input.components * bytes))
}

/// None for what cannot be drawn into.
pub(crate) fn format(format: TextureFormat) -> Option<vk::Format> {
    use TextureFormat as T;
    use vk::Format as F;
    Some(match format {
        T::R8Unorm => F::R8_UNORM,
        T::R8Uint => F::R8_UINT,
        T::R8Sint => F::R8_SINT,
        T::R16Unorm => F::R16_UNORM,
        T::R16Snorm => F::R16_SNORM,
        T::R16Uint => F::R16_UINT,
        T::R16Sint => F::R16_SINT,
        T::R16Float => F::R16_SFLOAT,
        T::R32Uint => F::R32_UINT,
        T::R32Sint => F::R32_SINT,
        T::R32Float => F::R32_SFLOAT,
        T::Rg8Unorm => F::R8G8_UNORM,
        T::Rg8Uint => F::R8G8_UINT,
        T::Rg8Sint => F::R8G8_SINT,
        T::Rg16Unorm => F::R16G16_UNORM,
        T::Rg16Snorm => F::R16G16_SNORM,
        T::Rg16Uint => F::R16G16_UINT,
        T::Rg16Sint => F::R16G16_SINT,
        T::Rg16Float => F::R16G16_SFLOAT,
        T::Rg32Uint => F::R32G32_UINT,
        T::Rg32Sint => F::R32G32_SINT,
        T::Rg32Float => F::R32G32_SFLOAT,
        T::Rgba8Unorm => F::R8G8B8A8_UNORM,
        T::Rgba8UnormSrgb => F::R8G8B8A8_SRGB,
        T::Rgba8Uint => F::R8G8B8A8_UINT,
        T::Rgba8Sint => F::R8G8B8A8_SINT,
        T::Bgra8Unorm => F::B8G8R8A8_UNORM,
        T::Bgra8UnormSrgb => F::B8G8R8A8_SRGB,
        T::Rgb10a2Uint => F::A2B10G10R10_UINT_PACK32,
        T::Rgb10a2Unorm => F::A2B10G10R10_UNORM_PACK32,
        T::Rg11b10Ufloat => F::B10G11R11_UFLOAT_PACK32,
        T::Rgba16Unorm => F::R16G16B16A16_UNORM,
        T::Rgba16Snorm => F::R16G16B16A16_SNORM,
        T::Rgba16Uint => F::R16G16B16A16_UINT,
        T::Rgba16Sint => F::R16G16B16A16_SINT,
        T::Rgba16Float => F::R16G16B16A16_SFLOAT,
        T::Rgba32Uint => F::R32G32B32A32_UINT,
        T::Rgba32Sint => F::R32G32B32A32_SINT,
        T::Rgba32Float => F::R32G32B32A32_SFLOAT,
        T::Depth16Unorm => F::D16_UNORM,
        T::Depth32Float => F::D32_SFLOAT,
        T::Depth32FloatStencil8 => F::D32_SFLOAT_S8_UINT,
        // As wgpu has it where the hardware has no 24 bits; AMD's does not.
        T::Depth24Plus => F::D32_SFLOAT,
        T::Depth24PlusStencil8 => F::D32_SFLOAT_S8_UINT,
        _ => return None,
    })
}

pub(crate) fn compare(compare: CompareFunction) -> vk::CompareOp {
    match compare {
        CompareFunction::Never => vk::CompareOp::NEVER,
        CompareFunction::Less => vk::CompareOp::LESS,
        CompareFunction::Equal => vk::CompareOp::EQUAL,
        CompareFunction::LessEqual => vk::CompareOp::LESS_OR_EQUAL,
        CompareFunction::Greater => vk::CompareOp::GREATER,
        CompareFunction::NotEqual => vk::CompareOp::NOT_EQUAL,
        CompareFunction::GreaterEqual => vk::CompareOp::GREATER_OR_EQUAL,
        CompareFunction::Always => vk::CompareOp::ALWAYS,
    }
}

pub(crate) fn cull(face: Option<Face>) -> vk::CullModeFlags {
    match face {
        None => vk::CullModeFlags::NONE,
        Some(Face::Front) => vk::CullModeFlags::FRONT,
        Some(Face::Back) => vk::CullModeFlags::BACK,
    }
}

pub(crate) fn front(front: FrontFace) -> vk::FrontFace {
    match front {
        FrontFace::Ccw => vk::FrontFace::COUNTER_CLOCKWISE,
        FrontFace::Cw => vk::FrontFace::CLOCKWISE,
    }
}

/// The source's factor, the destination's, the operation.
pub(crate) fn blend(blend: BlendComponent) -> [i32; 3] {
    [
        factor(blend.src_factor).as_raw(),
        factor(blend.dst_factor).as_raw(),
        operation(blend.operation).as_raw(),
    ]
}

fn factor(factor: BlendFactor) -> vk::BlendFactor {
    use BlendFactor as W;
    use vk::BlendFactor as V;
    match factor {
        W::Zero => V::ZERO,
        W::One => V::ONE,
        W::Src => V::SRC_COLOR,
        W::OneMinusSrc => V::ONE_MINUS_SRC_COLOR,
        W::SrcAlpha => V::SRC_ALPHA,
        W::OneMinusSrcAlpha => V::ONE_MINUS_SRC_ALPHA,
        W::Dst => V::DST_COLOR,
        W::OneMinusDst => V::ONE_MINUS_DST_COLOR,
        W::DstAlpha => V::DST_ALPHA,
        W::OneMinusDstAlpha => V::ONE_MINUS_DST_ALPHA,
        W::SrcAlphaSaturated => V::SRC_ALPHA_SATURATE,
        W::Constant => V::CONSTANT_COLOR,
        W::OneMinusConstant => V::ONE_MINUS_CONSTANT_COLOR,
        W::Src1 => V::SRC1_COLOR,
        W::OneMinusSrc1 => V::ONE_MINUS_SRC1_COLOR,
        W::Src1Alpha => V::SRC1_ALPHA,
        W::OneMinusSrc1Alpha => V::ONE_MINUS_SRC1_ALPHA,
    }
}

fn operation(operation: BlendOperation) -> vk::BlendOp {
    match operation {
        BlendOperation::Add => vk::BlendOp::ADD,
        BlendOperation::Subtract => vk::BlendOp::SUBTRACT,
        BlendOperation::ReverseSubtract => vk::BlendOp::REVERSE_SUBTRACT,
        BlendOperation::Min => vk::BlendOp::MIN,
        BlendOperation::Max => vk::BlendOp::MAX,
    }
}
