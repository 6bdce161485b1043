//! Buffers and textures, within what a device allows.

use std::borrow::Cow;

use crate::TooLarge;

/// A buffer that holds `bytes`, which are zeros up to the next word; `what` names it in an error.
///
/// # Errors
/// More bytes than the device allows for this usage.
pub fn buffer(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    what: &str,
    usage: wgpu::BufferUsages,
    bytes: &[u8],
) -> Result<wgpu::Buffer, TooLarge> {
    // Copies come in words of four bytes.
    let mut bytes = Cow::Borrowed(bytes);
    if bytes.is_empty() || bytes.len() % 4 != 0 {
        let padded = bytes.len().div_ceil(4).max(1) * 4;
        bytes.to_mut().resize(padded, 0);
    }
    let buffer = zeros(device, what, usage, bytes.len() as u64)?;
    queue.write_buffer(&buffer, 0, &bytes);
    Ok(buffer)
}

/// A buffer of so many bytes, a multiple of 4, all zeros; `what` names it in an error.
///
/// # Errors
/// No bytes, or more than the device allows for this usage.
pub fn zeros(
    device: &wgpu::Device,
    what: &str,
    usage: wgpu::BufferUsages,
    size: u64,
) -> Result<wgpu::Buffer, TooLarge> {
    let limits = device.limits();
    let limit = if usage.contains(wgpu::BufferUsages::UNIFORM) {
        limits.max_uniform_buffer_binding_size
    } else if usage.contains(wgpu::BufferUsages::STORAGE) {
        limits.max_storage_buffer_binding_size
    } else {
        limits.max_buffer_size
    };
    if !(1..=limit.min(limits.max_buffer_size)).contains(&size) {
        return Err(TooLarge {
            what: what.to_owned(),
            size: format!("{size} bytes"),
            limit,
        });
    }
    Ok(device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(what),
        size,
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    }))
}

/// A texture; `what` names it in an error.
///
/// # Errors
/// No texels, layers or levels, or more than the device allows.
pub fn texture(
    device: &wgpu::Device,
    what: &str,
    size: wgpu::Extent3d,
    levels: u32,
    format: wgpu::TextureFormat,
    usage: wgpu::TextureUsages,
) -> Result<wgpu::Texture, TooLarge> {
    let fault = |size: String, limit: u32| TooLarge {
        what: what.to_owned(),
        size,
        limit: limit.into(),
    };
    let limit = device.limits().max_texture_dimension_2d;
    if size.width == 0 || size.height == 0 || size.width > limit || size.height > limit {
        return Err(fault(
            format!("{} by {} texels", size.width, size.height),
            limit,
        ));
    }
    let (layers, limit) = (
        size.depth_or_array_layers,
        device.limits().max_texture_array_layers,
    );
    if !(1..=limit).contains(&layers) {
        return Err(fault(format!("{layers} layers"), limit));
    }
    let limit = size.max_mips(wgpu::TextureDimension::D2);
    if !(1..=limit).contains(&levels) {
        return Err(fault(format!("{levels} mip levels"), limit));
    }
    Ok(device.create_texture(&wgpu::TextureDescriptor {
        label: Some(what),
        size,
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    }))
}
